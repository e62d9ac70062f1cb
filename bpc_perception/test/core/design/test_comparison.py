"""Prints that grow beside their design, and what that says of their widths."""

from __future__ import annotations

from dataclasses import replace

from design_builders import along, lattice, MM, path_of, printed, profile_along, snake, stroke_of
import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.core.design import comparison
from bpc_perception.core.design.comparison import (
    compare_with_design,
    DesignComparison,
    DesignFollower,
    WantedDesign,
)
from bpc_perception.core.design.design import Design
from bpc_perception.core.design.presence import Presence
from bpc_perception.core.design.registration import Registration
from bpc_perception.core.geometry import transform
from bpc_perception.core.profile import Status
from bpc_perception.core.targets import WidthTargets

PLACE = pose((0.5, -0.1, 0.02), (77, 0, 0))
STEP = Design((replace(stroke_of(((0, 0, 0.3), (10, 0, 0.3), (20, 0, 0.3), (20, 9, 0.3))),
                       widths=np.array((0.8, 1.2, np.nan)) * MM),))


def at(design: Design, share: float, finished: bool = False,
       left_out: tuple[int, ...] = ()) -> DesignComparison:
    """A print of which so much is done, beside its design; a new one each time."""
    return grown(DesignFollower(WantedDesign('vase.csv', design)), design, share, finished,
                 left_out)


def grown(follower: DesignFollower, design: Design, share: float, finished: bool = False,
          left_out: tuple[int, ...] = ()) -> DesignComparison:
    points, stroke = printed(design, PLACE, share * design.length, left_out)
    return follower.compare(profile_along(points, stroke), path_of(points, stroke, finished))


def test_what_was_left_out_is_skipped_at_once_and_the_rest_is_to_come() -> None:
    design = lattice()
    missing = at(design, 0.5, left_out=(4,)).findings.missing
    assert {each.presence for each in missing if each.stroke == 4} == {Presence.SKIPPED}
    coming = sum(each.end - each.start for each in missing
                 if each.presence == Presence.YET_TO_COME)
    assert coming == pytest.approx(0.5 * design.length - 20 * MM, abs=1.5 * MM)


def test_at_its_end_nothing_is_to_come() -> None:
    design = lattice()
    points, stroke = printed(design, PLACE, 0.7 * design.length)
    profile = profile_along(points, stroke)
    wanted = WantedDesign('vase.csv', design)
    for found in (DesignFollower(wanted).compare(profile, path_of(points, stroke, True)),
                  compare_with_design(profile, wanted)):
        assert {each.presence for each in found.findings.missing} == {Presence.SKIPPED}
        missing = sum(each.end - each.start for each in found.findings.missing)
        assert missing == pytest.approx(0.3 * design.length, abs=1.5 * MM)


def test_where_it_lies_is_looked_for_when_there_is_more_of_it(
        monkeypatch: pytest.MonkeyPatch) -> None:
    """Seldom, but the place is as good as one that is found at once."""
    tried = []
    register = comparison.register

    def counted(*values: object) -> object:
        tried.append(values)
        return register(*values)  # type: ignore[arg-type]

    monkeypatch.setattr(comparison, 'register', counted)
    design = lattice(layers=2)
    follower = DesignFollower(WantedDesign('vase.csv', design))
    shares = np.linspace(0.1, 0.99, 60)
    last = [grown(follower, design, share) for share in shares][-1]
    assert len(tried) <= np.log(10) / np.log(1.2) + 2
    points = np.concatenate([stroke.points for stroke in design.strokes])
    place = last.findings.registration.T_base_design
    assert np.abs(transform(place, points) - transform(PLACE, points)).max() < 0.02 * MM


def test_another_print_lies_elsewhere() -> None:
    design = lattice()
    follower = DesignFollower(WantedDesign('vase.csv', design))
    grown(follower, design, 0.9)
    points, stroke = printed(design, pose((0.1, 0.2, 0.0)), 0.3 * design.length)
    profile = replace(profile_along(points, stroke), print_id='another')
    place = follower.compare(profile, path_of(points, stroke, False)).findings.registration
    np.testing.assert_allclose(place.T_base_design[:3, 3], (0.1, 0.2, 0.0), atol=0.05 * MM)


def test_widths_of_the_design_are_the_targets_also_of_what_comes() -> None:
    found = at(STEP, 0.2)
    assert found.deviations is not None
    targets = found.targets(np.linspace(0, 0.2 * STEP.length, len(found.deviations.piece)), None)
    assert targets is not None
    np.testing.assert_allclose(targets.at(np.linspace(0, 9, 40) * MM), 0.8 * MM)
    assert float(targets.at(12 * MM)) == pytest.approx(1.2 * MM)


def test_a_gap_is_no_thin_bead() -> None:
    points, stroke = printed(STEP, PLACE, STEP.length)
    profile = profile_along(points, stroke, width=1 * MM)
    status, thickness = profile.status.copy(), profile.thickness.copy()
    status[10:30], thickness[10:30] = Status.GAP, 0.0
    broken = replace(profile, status=status, thickness=thickness)
    wanted = WantedDesign('vase.csv', STEP)
    whole, found = (compare_with_design(each, wanted).findings.width
                    for each in (profile, broken))
    assert found.count == whole.count - 20
    assert found.most == pytest.approx(0.2 * MM)


def test_where_the_design_tells_no_width_another_target_holds() -> None:
    found = at(STEP, 1.0, finished=True)
    assert found.deviations is not None
    arc = np.linspace(0, STEP.length, len(found.deviations.piece))
    targets = found.targets(arc, WidthTargets.constant(2 * MM))
    assert targets is not None
    assert targets.at(np.array((5, 15, 25)) * MM) == pytest.approx(
        np.array((0.8, 1.2, 2.0)) * MM)
    bare = Design((stroke_of(((0, 0, 0), (20, 0, 0))),))
    assert at(bare, 1.0).targets(arc, None) is None


def test_what_does_not_fit_is_warned_of_once_there_is_enough_of_it() -> None:
    points, stroke = printed(snake(), PLACE)
    wanted = WantedDesign('vase.csv', lattice())
    for share, warned in ((0.05, False), (1.0, True)):
        count = round(share * len(points))
        profile = profile_along(points[:count], stroke[:count])
        found = compare_with_design(profile, wanted)
        warning = found.warning(profile)
        assert warning.startswith('design: registration: expected') == warned
    assert found.targets(profile.arc_length, None) is None


def test_no_width_is_wanted_where_a_design_that_tells_some_is_not_found() -> None:
    """Else 2 mm of the settings would be the target of what is to become 0.8 mm wide."""
    points, stroke = printed(snake(), PLACE)
    profile, others = profile_along(points, stroke), WidthTargets.constant(2 * MM)
    for design, targets in ((STEP, None), (lattice(), others)):
        found = compare_with_design(profile, WantedDesign('vase.csv', design))
        assert found.findings.registration.refusal
        assert found.targets(profile.arc_length, others) is targets


@pytest.mark.parametrize(('aside', 'lost'), [(0.0, False), (50.0, True)])
def test_a_place_that_is_told_wrong_is_warned_of_and_wants_no_width(aside: float,
                                                                    lost: bool) -> None:
    design = Design((*STEP.strokes, stroke_of(((0, 15, 0.3), (20, 15, 0.3)), width=0.8)))
    points, stroke = printed(design, PLACE)
    profile = profile_along(points, stroke)
    told = Registration(pose((0, 0, aside * MM)) @ PLACE)
    found = compare_with_design(profile, WantedDesign('vase.csv', design, told))
    assert ('found 100% of the ink beside' in found.warning(profile)) == lost
    targets = found.targets(profile.arc_length, WidthTargets.constant(2 * MM))
    assert (targets is None) == lost


def test_a_nozzle_whose_ink_is_not_known_yet_has_come_nowhere() -> None:
    """The newest states of the extruder may be missing: it may travel over strokes to come."""
    design = lattice()
    points, stroke = printed(design, PLACE, 0.3 * design.length)
    ahead = along(transform(PLACE, design.strokes[14].points), 5 * MM)
    path = path_of(np.concatenate((points, ahead)), np.append(stroke, np.zeros(len(ahead))), False)
    path = replace(path, extruder_known=np.arange(len(path)) < len(points))
    found = DesignFollower(WantedDesign('vase.csv', design)).compare(
        profile_along(points, stroke), path)
    assert Presence.SKIPPED not in {each.presence for each in found.findings.missing}


def test_a_nozzle_that_lifts_beside_a_stroke_to_come_has_not_come_there() -> None:
    design = lattice()
    points, stroke = printed(design, PLACE, 4 * 20 * MM)
    # Ink is commanded still, and the way up runs along another stroke for a moment.
    lifting = along(transform(PLACE, design.strokes[14].points), 0.4 * MM)
    points, stroke = np.concatenate((points, lifting)), np.append(stroke, [4] * len(lifting))
    more, numbers = (np.concatenate((a, b)) for a, b in zip(
        (points, stroke), printed(Design(design.strokes[4:6]), PLACE), strict=True))
    numbers[len(stroke):] += 4 * (numbers[len(stroke):] > 0)
    found = DesignFollower(WantedDesign('vase.csv', design, Registration(PLACE))).compare(
        profile_along(more, numbers), path_of(more, numbers, False))
    assert Presence.SKIPPED not in {each.presence for each in found.findings.missing}


def test_a_print_that_is_over_is_looked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    follower, design = DesignFollower(WantedDesign('vase.csv', snake())), snake()
    place = grown(follower, design, 1.0, True).findings.registration
    monkeypatch.setattr(comparison, 'register', None)
    assert grown(follower, design, 1.0, True).findings.registration is place
