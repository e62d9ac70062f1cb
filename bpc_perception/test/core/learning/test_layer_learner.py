"""Learning follows prints: a schedule for each layer whose path was printed before.

Truth by the mass balance, see layer_builders: where the share g arrives, 1 / g is needed.
"""

from __future__ import annotations

from dataclasses import replace

from layer_builders import GAIN, lacking, LAYER_HEIGHT_M, SPACING, Stack, STRANDS, TARGET, way
import numpy as np
from perception_builders import advice_of, SECOND, START_NS
import pytest

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.config import AdviceConfig, LearningConfig, ThicknessConfig
from bpc_perception.core.learning.layer_learner import LayerLearner
from bpc_perception.core.learning.layer_schedule import LayerSchedule, ScheduleReason
from bpc_perception.core.profile import Status
from bpc_perception.core.targets import WidthTargets

CONFIG = ThicknessConfig(advice=AdviceConfig(target_thickness=TARGET),
                         learning=LearningConfig(followed=True))
WANTED = WidthTargets.constant(TARGET)
WAY = way()
LENGTH = SPACING * (len(WAY) - 1)
OTHER_WAY = way(((0, 0), (30, 0), (30, 6), (18, 6), (18, 20)))
LATER_NS = START_NS + 500 * SECOND


def look(learner: LayerLearner, stack: Stack, *seen: tuple[int, float], end: bool = False,
         reason: Reason = Reason.ON_TARGET, config: ThicknessConfig = CONFIG) -> LayerSchedule:
    """Show a learner captures of a print; return what it tells after the last."""
    shown = [stack.until(*one) for one in seen] + ([stack.finished()] if end else [])
    for profile, path in shown:
        learner.look(profile, path, WANTED, GAIN, config)
        learner.hear(advice_of(reason))
    return learner.told


def test_a_layer_gets_what_those_before_lacked_at_the_same_places() -> None:
    learner, stack = LayerLearner(), Stack(WAY, WAY, WAY)
    told = look(learner, stack, (0, 0.02), (0, 0.07))
    assert (told.valid, told.reason) == (False, ScheduleReason.NOTHING_LEARNED)
    told = look(learner, stack, (1, 0.004), (1, 0.07))
    assert (told.reason, told.print_id, told.layer) == (ScheduleReason.LEARNED, 'print', 1)
    assert told.based_on == (('print', 0),)
    told = look(learner, stack, (2, 0.004))
    assert (told.layer, told.based_on) == (2, (('print', 0), ('print', 1)))
    assert told.schedule is not None
    for place in (0.015, 0.04, 0.075):  # away from the steps, which are smoothed
        assert told.schedule.at(place) == pytest.approx(1 / lacking(np.array(place)), rel=0.1)
    own = np.column_stack([np.interp(told.schedule.place, SPACING * np.arange(len(WAY)), axis)
                           for axis in WAY.T])
    np.testing.assert_allclose(told.points - own, np.tile((0, 0, LAYER_HEIGHT_M), (len(own), 1)),
                               atol=SPACING)


def test_advice_learns_what_is_planned_where_the_layer_is() -> None:
    learner, stack = LayerLearner(), Stack(WAY, WAY)
    look(learner, stack, (0, 0.07), (1, 0.004), (1, 0.02))
    _, path = stack.until(1, 0.02)
    planned = learner.planned(path, CONFIG)
    schedule = learner.told.schedule
    assert planned is not None
    assert schedule is not None
    began = path.arc_length[np.argmax(stack.layer == 1)]
    assert planned.since == pytest.approx(began + 0.004, abs=2 * SPACING)  # as it was told
    before = path.arc_length < planned.since
    np.testing.assert_array_equal(planned.factor[before], 1.0)
    np.testing.assert_allclose(planned.factor[~before],
                               schedule.at(path.arc_length[~before] - began), rtol=0.02)
    ahead = schedule.at(np.linspace(0.02, 0.02 + 0.01 * CONFIG.advice.lifetime, 500))
    assert planned.ahead == pytest.approx((ahead.min(), ahead.max()), rel=0.01)


@pytest.mark.parametrize('changed', [{'followed': False}, {'enabled': False}])
def test_advice_is_on_top_of_a_schedule_only_where_that_is_followed(
        changed: dict[str, bool]) -> None:
    config = replace(CONFIG, learning=LearningConfig(**{'followed': True, **changed}))
    learner, stack = LayerLearner(), Stack(WAY, WAY)
    told = look(learner, stack, (0, 0.07), (1, 0.004), config=config)
    assert told.valid == config.learning.enabled
    assert learner.planned(stack.until(1, 0.02)[1], config) is None


def test_a_path_that_leaves_the_one_learned_from_withdraws_the_schedule() -> None:
    learner, stack = LayerLearner(), Stack(WAY, OTHER_WAY)
    assert look(learner, stack, (0, 0.07), (1, 0.03)).valid  # so far it is the same
    told = look(learner, stack, (1, 0.06))
    assert (told.valid, told.reason) == (False, ScheduleReason.OTHER_PATH)
    assert learner.planned(stack.until(1, 0.06)[1], CONFIG) is None
    assert not look(learner, stack, (1, 0.06)).valid


def test_a_path_that_differs_by_less_than_a_millimetre_is_the_same() -> None:
    wobbling = WAY + 0.4e-3 * np.sin(np.arange(len(WAY)) / 40)[:, None] * (0, 1, 0)
    assert look(LayerLearner(), Stack(WAY, wobbling), (0, 0.07), (1, 0.004), (1, 0.09)).valid


def test_one_that_goes_the_other_way_round_has_no_schedule() -> None:
    told = look(LayerLearner(), Stack(WAY, WAY[::-1]), (0, 0.07), (1, 0.01))
    assert told.reason == ScheduleReason.OTHER_PATH


def test_the_layers_of_a_scaffold_take_turns() -> None:
    """Each direction is learned from its own layers."""
    across = WAY[:, [1, 0, 2]]
    learner, stack = LayerLearner(), Stack(WAY, across, WAY, across)
    assert not look(learner, stack, (0, 0.07), (1, 0.01), (1, 0.08)).valid
    assert look(learner, stack, (2, 0.01), (2, 0.08)).based_on == (('print', 0),)
    assert look(learner, stack, (3, 0.01)).based_on == (('print', 1),)


def test_the_next_print_begins_with_what_the_last_taught_also_beside_it() -> None:
    learner = LayerLearner()
    told = look(learner, Stack(WAY), (0, 0.05), end=True)
    assert (told.valid, told.print_id, told.layer) == (True, '', 0)
    beside = Stack(np.add(WAY, (0.05, 0, 0)), print_id='next', start_ns=LATER_NS)
    told = look(learner, beside, (0, 0.01))
    assert (told.valid, told.print_id) == (True, 'next')
    planned = learner.planned(beside.until(0, 0.01)[1], CONFIG)
    assert planned is not None
    assert planned.since == 0.0  # it was told before the print began
    assert look(learner, Stack(OTHER_WAY[:, [1, 0, 2]], print_id='other', start_ns=2 * LATER_NS),
                (0, 0.03)).reason == ScheduleReason.OTHER_PATH


def test_an_early_start_of_the_extruder_moves_places_not_factors() -> None:
    """The ink of the second layer begins 4 mm before that of the first."""
    earlier = way(((-4, 0), *STRANDS[1:]))
    learner, stack = LayerLearner(), Stack(WAY, earlier)
    look(learner, stack, (0, 0.07), (1, 0.01), (1, 0.03))
    _, path = stack.until(1, 0.03)
    planned, schedule = learner.planned(path, CONFIG), learner.told.schedule
    assert planned is not None
    assert schedule is not None
    assert planned.factor[-1] == pytest.approx(float(schedule.at(0.026)), rel=0.02)


@pytest.mark.parametrize('reason', [Reason.CLOG_SUSPECTED, Reason.EXTRUDER_FAULT,
                                    Reason.PATH_OFFSET, Reason.GAP_DETECTED])
def test_what_came_with_alarms_is_not_learned_from(reason: Reason) -> None:
    learner, stack = LayerLearner(), Stack(WAY, WAY)
    look(learner, stack, (0, 0.03), (0, 0.06), reason=reason)
    told = look(learner, stack, (1, 0.004))
    assert (told.valid, told.reason) == (False, ScheduleReason.FAULTS)


@pytest.mark.parametrize(('status', 'share', 'reason'), [
    (Status.GAP, 0.1, ScheduleReason.LEARNED), (Status.GAP, 0.3, ScheduleReason.FAULTS),
    (Status.NO_DATA, 0.1, ScheduleReason.LEARNED),
    (Status.NO_DATA, 0.6, ScheduleReason.NOT_ENOUGH_SEEN)])
def test_gaps_and_what_was_not_seen_are_no_ground_to_learn_on(
        status: Status, share: float, reason: ScheduleReason) -> None:
    learner, stack = LayerLearner(), Stack(WAY, WAY)
    profile, path = stack.until(1, 0.004)
    spoiled = (stack.place[:len(profile)] > (1 - share) * LENGTH) & (profile.layer == 0)
    profile = replace(profile, status=np.where(spoiled, status, profile.status).astype(np.uint8),
                      thickness=np.where(spoiled, 0.0 if status == Status.GAP else np.nan,
                                         profile.thickness))
    look(learner, stack, (0, 0.05))
    learner.look(profile, path, WANTED, GAIN, CONFIG)
    assert learner.told.reason == reason
    assert learner.told.valid == (reason == ScheduleReason.LEARNED)


def test_without_a_recorded_command_nothing_is_learned() -> None:
    stack = Stack(WAY, WAY)
    unknown = np.full(len(stack.path), np.nan)
    stack.path = replace(stack.path, flow_rate=unknown, plunger_velocity=unknown)
    assert look(LayerLearner(), stack, (0, 0.07), (1, 0.01)).reason == ScheduleReason.NOT_RECORDED


def test_a_layer_that_is_over_at_once_is_not_enough() -> None:
    short = way(((0, 0), (25, 0)))  # 2.5 s: a lag of some seconds could be anything
    told = look(LayerLearner(), Stack(short), (0, 0.02), end=True)
    assert (told.valid, told.reason) == (False, ScheduleReason.NOT_ENOUGH_SEEN)


def test_a_defect_of_learning_leaves_the_print_alone(
        caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('bpc_perception.core.learning.layer_learner.places_on', None)
    told = look(LayerLearner(), Stack(WAY, WAY), (0, 0.07), (1, 0.01), (1, 0.02))
    assert not told.valid
    assert 'learning failed' in caplog.text


def test_without_a_target_nothing_is_learned() -> None:
    learner, stack = LayerLearner(), Stack(WAY, WAY)
    for seen in ((0, 0.07), (1, 0.01)):
        learner.look(*stack.until(*seen), None, GAIN, CONFIG)
    assert learner.told.reason == ScheduleReason.NOTHING_LEARNED


def test_of_several_objects_nothing_is_told_after_the_first() -> None:
    """Their layers begin anew, and nobody knows whose is whose."""
    stack = Stack(WAY, WAY, np.add(WAY, (0.1, 0, -2 * LAYER_HEIGHT_M)))
    stack.layer[stack.layer == 2] = 0
    learner = LayerLearner()
    assert look(learner, stack, (1, 0.004)).valid is False  # the first was not looked at
    profile, path = stack.finished()
    learner.look(profile, path, WANTED, GAIN, CONFIG)
    assert not learner.told.valid


def test_a_print_that_is_forgotten_leaves_what_it_taught() -> None:
    learner = LayerLearner()
    look(learner, Stack(WAY), (0, 0.05), end=True)
    look(learner, Stack(OTHER_WAY[:, [1, 0, 2]], print_id='other', start_ns=2 * LATER_NS),
         (0, 0.03))
    assert not learner.told.valid
    learner.forget_print()
    assert (learner.told.valid, learner.told.print_id) == (True, '')
    again = Stack(WAY, print_id='again', start_ns=LATER_NS)
    assert look(learner, again, (0, 0.004)).valid


def test_what_is_kept_is_for_the_next_print_of_its_path_until_that_taught() -> None:
    taught = LayerLearner()
    kept = look(taught, Stack(WAY), (0, 0.05), end=True)
    learner = LayerLearner(kept)
    assert learner.told is kept
    other = Stack(OTHER_WAY[:, [1, 0, 2]], print_id='other', start_ns=LATER_NS)
    assert look(learner, other, (0, 0.03)).reason == ScheduleReason.OTHER_PATH
    again = Stack(WAY, print_id='again', start_ns=2 * LATER_NS)
    assert look(learner, again, (0, 0.004)).based_on == (('print', 0),)
    assert look(learner, again, end=True).based_on == (('again', 0),)


def test_no_factor_passes_the_limits_whatever_was_measured() -> None:
    rng = np.random.default_rng(25)
    limits = CONFIG.advice
    for _ in range(40):
        share = np.exp(rng.normal(0, 1, 20))
        learner = LayerLearner()
        stack = Stack(WAY, WAY, share=lambda place, share=share: np.interp(
            place, np.linspace(0, LENGTH, 20), share))
        told = look(learner, stack, (0, 0.07), (1, 0.004))
        if told.schedule is not None:
            assert told.schedule.factor.min() >= limits.minimum_scale
            assert told.schedule.factor.max() <= limits.maximum_scale
