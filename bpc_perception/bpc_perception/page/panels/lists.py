"""The lists at the side: how the nodes are, and what happened."""

from __future__ import annotations

from nicegui import ui

from bpc_perception.core.inspection.defects import DefectKind
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.verdict_words import defect_in_words
from bpc_perception.page import elements
from bpc_perception.page.board import Event, Level

MOST_DEFECTS, MOST_EVENTS = 4, 6  # that are listed, the newest
LEVEL_TONES = {Level.OK: 'good', Level.WARN: 'warn', Level.ERROR: 'bad', Level.STALE: 'old',
               Level.UNHEARD: 'old'}


class NodesPanel:
    """Each node with its level and words."""

    def __init__(self) -> None:
        with elements.card('nodes', 'Nodes'):
            self._entries = ui.element('div').classes('entries')

    def show(self, nodes: dict[str, tuple[Level, str]]) -> None:
        """Show level and words of nodes, by name."""
        self._entries.clear()
        with self._entries:
            for name, (level, words) in nodes.items():
                elements.entry(LEVEL_TONES[level], name, words)


class EventsPanel:
    """The newest events, gaps, ooze and other defects."""

    def __init__(self) -> None:
        with elements.card('events', 'Defects and alarms'):
            self._entries = ui.element('div').classes('entries')

    def show(self, events: tuple[Event, ...], profile: ThicknessProfile | None,
             verdict: PrintVerdict | None) -> None:
        """Show events, and what is wrong with a print if there is one."""
        found = _found(profile, verdict)
        self._entries.clear()
        with self._entries:
            for event in events[:MOST_EVENTS]:
                times = f' ({event.times} times)' if event.times > 1 else ''
                elements.entry('bad' if event.alarm else 'warn', event.at,
                               f'{event.source}: {event.words}{times}')
            for start, words in found[:MOST_DEFECTS]:
                elements.entry('gap', f'{start * MM_PER_M:.1f} mm', words)
            if len(found) > MOST_DEFECTS:
                ui.label(f'and {len(found) - MOST_DEFECTS} before').classes('quiet')
            if not found and not events:
                ui.label('none').classes('quiet')


def _found(profile: ThicknessProfile | None,
           verdict: PrintVerdict | None) -> list[tuple[float, str]]:
    """Return what is wrong, the newest first: arc length [m] and words.

    All gaps and all ooze, also those that the tolerances allow.
    """
    found = [] if profile is None else [
        (start, f'{word} of {(end - start) * MM_PER_M:.1f} mm')
        for word, extents in (('gap', profile.gaps), ('ooze', profile.ooze))
        for start, end in extents.tolist()]
    if verdict is not None:
        found += [(each.start, defect_in_words(each)) for each in verdict.defects
                  if each.kind not in (DefectKind.GAP, DefectKind.OOZE)]
    return sorted(found, reverse=True)
