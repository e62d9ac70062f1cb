"""Words for what is to be mended, and whether the next layer can be laid."""

from __future__ import annotations

from collections import Counter

from bpc_perception.core.repair.plan import (
    FillKind,
    LayerRepair,
    LayerState,
    NextLayer,
    NotFilled,
    Obstacle,
    RepairPlan,
)
from bpc_perception.display.units import MM_PER_M

ANSWERS = {NextLayer.YES: 'yes', NextLayer.NO: 'no', NextLayer.NOT_KNOWN: 'not known'}
KINDS = {FillKind.GAP: 'gap', FillKind.THIN: 'thin'}
NOT_FILLED = {
    NotFilled.ALLOWED: 'no longer than is allowed',
    NotFilled.SHORT: 'shorter than the bead is wide',
    NotFilled.END_NOT_SEEN: 'where it ends is not seen',
    NotFilled.FLOW_NOT_KNOWN: 'what was commanded is not known',
    NotFilled.AREA_NOT_KNOWN: 'what it lacks is not known',
    NotFilled.ENOUGH_INK: 'narrower, but of no less ink beyond doubt',
    NotFilled.COVERED: 'the nozzle would touch ink of a higher layer',
    NotFilled.WIDTH_NOT_KNOWN: 'the width of the bead is not known',
    NotFilled.CONTRADICTION: 'path and picture, or extruder and motion, contradict each other'}


def next_layer_in_words(state: LayerState) -> str:
    """Return whether the next layer can be laid, and why not."""
    reasons = ', '.join(_obstacle(state, each) for each in state.obstacles)
    return ANSWERS[state.next_layer] + (f': {reasons}' if reasons else '')


def repair_in_words(layer: LayerRepair) -> str:
    """Return what is proposed for a layer, in a line."""
    counts = Counter(KINDS[each.kind] for each in layer.fills)
    volume = sum(each.volume for each in layer.fills) * MM_PER_M**3
    fills = (f'{_counted(counts)} to fill with {volume:.2f} mm³' if counts else
             'nothing to fill')
    left = Counter(KINDS[each.kind] for each in layer.unfilled)
    return (f'layer {layer.number}: {fills}{f", {_counted(left)} left" if left else ""}; '
            f'next layer: {next_layer_in_words(layer.state)}')


def repairs_in_words(plan: RepairPlan) -> list[str]:
    """Return a line for each finished layer; one for all that are sound."""
    sound = [each for each in plan.finished if not each.fills and not each.unfilled
             and each.state.next_layer == NextLayer.YES]
    lines = [repair_in_words(each) for each in plan.finished if each not in sound]
    if not sound:
        return lines
    numbers = ', '.join(str(each.number) for each in sound)
    return [*lines, f'{"layer" if len(sound) == 1 else "layers"} {numbers}: nothing to repair; '
            'next layer: yes']


def _obstacle(state: LayerState, obstacle: Obstacle) -> str:
    match obstacle:
        case Obstacle.GAP:
            return f'a gap of {state.longest_gap * MM_PER_M:.1f} mm'
        case Obstacle.HIGH:
            return (f'ink stands {state.highest * MM_PER_M:.2f} mm high, in a layer of '
                    f'{state.height * MM_PER_M:.2f}')
        case Obstacle.LOW:
            return (f'ink of {state.lowest * MM_PER_M:.2f} mm, in a layer of '
                    f'{state.height * MM_PER_M:.2f}')
        case Obstacle.NOT_ENOUGH_SEEN:
            return (f'{state.seen:.0%} seen, {state.longest_unseen * MM_PER_M:.1f} mm hidden in '
                    'one piece')
        case Obstacle.HEIGHT_NOT_KNOWN:
            return 'heights are not known'
        case Obstacle.CONTRADICTION:
            return 'data contradict each other'


def _counted(counts: Counter[str]) -> str:
    return ', '.join(f'{count} × {name}' for name, count in counts.items())
