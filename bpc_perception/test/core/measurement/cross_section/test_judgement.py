"""What is known of a sample: each condition and threshold, and which of two conditions counts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np
from perception_builders import (
    band_image,
    BED,
    capture_of,
    DOWN,
    INK,
    one_piece,
    PIXEL as IMAGE_PIXEL,
    surface,
)
import pytest

from bpc_perception.core.arrays import Array, Flags, Floats
from bpc_perception.core.measurement.cross_section.appearance.appearance import Appearance
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.judgement import (
    ends_within_pixel,
    judge,
    leans_over_gap,
    typical_width,
)
from bpc_perception.core.measurement.cross_section.passes import meets_other_pass
from bpc_perception.core.measurement.cross_section.sections.sections import Sections
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Cause, CauseArray, Status

MM = 1e-3
COUNT, SAMPLE = 41, 20  # sections, and the one looked at
PIXEL, SPACING = 0.1 * MM, 0.02 * MM
OFFSET = np.arange(-80, 81) * 0.05 * MM  # half a pixel apart
# The middle third reaches 0.33 mm to either side, and a gap is bare within 0.792 mm.
WIDTH = 1.98 * MM


def flat_sections(foot: Array, along: Array | None = None) -> Sections:
    """Sections along +y across a path at feet (N, 3), on which nothing is amiss."""
    shape = len(foot), len(OFFSET)
    return Sections(
        piece=one_piece(len(foot)),
        along=np.arange(len(foot)) * SPACING if along is None else along, foot=foot,
        lateral=np.tile((0.0, 1.0, 0.0), (len(foot), 1)), lean=np.zeros(len(foot)),
        in_row=np.zeros(len(foot)), offset=OFFSET,
        pixel=PIXEL, spacing=SPACING, inside=np.ones(shape, bool), hidden=np.zeros(shape, bool),
        depth=np.ones(len(foot), bool), raised=np.zeros(len(foot), bool),
        beside=np.zeros(shape, bool), clearance=np.zeros((2, len(foot))),
        foreign=np.zeros(shape, bool), nearing=np.zeros(shape, bool),
        colour=np.zeros((*shape, 3), np.float32),
        height=np.zeros(shape, np.float32), place=np.tile(OFFSET, (len(foot), 1)))


def edges(distance: float = WIDTH / 2) -> Edges:
    """Edges at a distance from the path, with nothing before them."""
    none = np.zeros(COUNT, bool)
    return Edges(np.full(COUNT, distance), np.zeros(COUNT), none, none.copy(), none.copy())


def band(half_width: float, share: float = 1.0) -> Floats:
    """A section's share of ink: so much up to a half width, and bed beyond."""
    return np.where(np.abs(OFFSET) <= half_width + 1e-9, share, 0.0).astype(np.float32)


@dataclass
class Scene:
    """A bead of 1.98 mm along a straight path, of which something may be amiss at one sample."""

    sections: Sections = field(default_factory=lambda: flat_sections(
        np.column_stack((np.arange(COUNT) * SPACING, np.zeros((COUNT, 2))))))
    ink: Floats = field(default_factory=lambda: np.tile(band(WIDTH / 2), (COUNT, 1)))
    left: Edges = field(default_factory=edges)
    right: Edges = field(default_factory=edges)
    untold: CauseArray = field(default_factory=lambda: np.zeros(COUNT, np.uint8))
    faint: Flags = field(default_factory=lambda: np.zeros(COUNT, bool))
    ending: Flags = field(default_factory=lambda: np.zeros(COUNT, bool))

    def judged(self) -> Status:
        """What is known of the sample looked at; all others are as they should be."""
        return self.verdict()[0]

    def verdict(self) -> tuple[Status, Cause]:
        """The same, with its cause."""
        found = judge(self.sections, self.ink, self.left, self.right, self.untold, self.faint,
                      self.ending)
        others = found.of(np.delete(np.arange(COUNT), SAMPLE))
        assert set(others.status.tolist()) == {Status.MEASURED}
        assert not others.cause.any()
        return Status(int(found.status[SAMPLE])), Cause(int(found.cause[SAMPLE]))

    def sample_is(self, ink: Floats) -> Scene:
        """This scene with that ink at the sample."""
        self.ink[SAMPLE] = ink
        return self


def set_flag(flags: Callable[[Scene], Flags]) -> Callable[[Scene], None]:
    """What sets a flag of the sample."""
    def change(scene: Scene) -> None:
        flags(scene)[SAMPLE] = True
    return change


def hide_path(scene: Scene) -> None:
    """Let something stand before the path, and nowhere else."""
    scene.sections.hidden[SAMPLE, len(OFFSET) // 2] = True


def leave_image(scene: Scene) -> None:
    """Let the path lie outside the image."""
    scene.sections.inside[SAMPLE, len(OFFSET) // 2] = False


def lose_depth(scene: Scene) -> None:
    """Let the cloud not know the surface."""
    scene.sections.depth[SAMPLE] = False


def confuse(scene: Scene) -> None:
    """Let ink not be told from the bed."""
    scene.untold[SAMPLE] = Cause.LOW_CONTRAST


# From the one that counts before all others to the one that counts last.
AMISS = {
    'path hidden': (hide_path, Status.OCCLUDED),
    'path outside': (leave_image, Status.NO_DATA),
    'joined on the left': (set_flag(lambda scene: scene.left.joined), Status.JUNCTION),
    'noisy': (confuse, Status.LOW_CONFIDENCE),
    'right edge hidden': (set_flag(lambda scene: scene.right.hidden), Status.OCCLUDED),
    'left edge outside': (set_flag(lambda scene: scene.left.outside), Status.NO_DATA),
    'ending': (set_flag(lambda scene: scene.ending), Status.LOW_CONFIDENCE),
}
# Of the same rank as one above.
ALIKE = {
    'no depth': (lose_depth, Status.NO_DATA),
    'joined on the right': (set_flag(lambda scene: scene.right.joined), Status.JUNCTION),
    'left edge hidden': (set_flag(lambda scene: scene.left.hidden), Status.OCCLUDED),
    'right edge outside': (set_flag(lambda scene: scene.right.outside), Status.NO_DATA),
}
CAUSES = {
    'path outside': Cause.OUTSIDE_IMAGE, 'noisy': Cause.LOW_CONTRAST,
    'left edge outside': Cause.OUTSIDE_IMAGE, 'ending': Cause.INK_ENDS,
    'no depth': Cause.NO_DEPTH, 'right edge outside': Cause.OUTSIDE_IMAGE,
}


def test_a_bead_with_both_edges_is_measured() -> None:
    assert Scene().judged() == Status.MEASURED


@pytest.mark.parametrize(('half_width', 'status'), [
    (WIDTH / 2, Status.MEASURED), (WIDTH / 2 * 0.8, Status.LOW_CONFIDENCE)])
def test_under_glare_a_bead_is_as_wide_as_around(half_width: float, status: Status) -> None:
    """A spot of glare on bare bed has edges as well."""
    scene = Scene().sample_is(np.full(len(OFFSET), np.nan, np.float32))
    scene.left.distance[SAMPLE] = scene.right.distance[SAMPLE] = half_width
    assert scene.judged() == status


@pytest.mark.parametrize('name', AMISS | ALIKE)
def test_what_is_amiss_is_the_reason(name: str) -> None:
    scene = Scene()
    change, status = (AMISS | ALIKE)[name]
    change(scene)
    assert scene.verdict() == (status, CAUSES.get(name, Cause.NONE))


@pytest.mark.parametrize(('first', 'second'), list(combinations(AMISS, 2)))
def test_of_two_reasons_the_first_counts(first: str, second: str) -> None:
    scene = Scene()
    for name in (first, second):
        AMISS[name][0](scene)
    assert scene.judged() == AMISS[first][1]


@pytest.mark.parametrize('name', ['path hidden', 'path outside', 'noisy', 'ending'])
def test_of_a_gap_the_same_holds(name: str) -> None:
    scene = Scene().sample_is(band(0.0, 0.0))
    assert scene.judged() == Status.GAP
    change, status = AMISS[name]
    change(scene)
    assert scene.judged() == status


@pytest.mark.parametrize('name', [
    'joined on the left', 'right edge hidden', 'left edge outside', 'joined on the right',
    'left edge hidden', 'right edge outside'])
def test_what_lies_beyond_a_gap_does_not_matter(name: str) -> None:
    scene = Scene().sample_is(band(0.0, 0.0))
    (AMISS | ALIKE)[name][0](scene)
    assert scene.judged() == Status.GAP


def test_without_an_edge_nothing_is_measured() -> None:
    scene = Scene()
    scene.left.distance[SAMPLE] = np.nan
    assert scene.verdict() == (Status.LOW_CONFIDENCE, Cause.NO_EDGE)
    scene.faint[SAMPLE] = True
    assert scene.verdict() == (Status.LOW_CONFIDENCE, Cause.FAINT_EDGES)
    scene.ink[SAMPLE, -3] = np.nan  # what shines there may be bed
    assert scene.verdict() == (Status.LOW_CONFIDENCE, Cause.GLARE)


@pytest.mark.parametrize(('share', 'status'), [
    (1.3, Status.MEASURED), (0.605, Status.MEASURED), (0.595, Status.LOW_CONFIDENCE),
    (0.405, Status.LOW_CONFIDENCE), (0.395, Status.GAP), (0.0, Status.GAP), (-0.395, Status.GAP),
    (-0.405, Status.LOW_CONFIDENCE)])
def test_from_which_share_ink_is_ink_and_bed_is_bed(share: float, status: Status) -> None:
    assert Scene().sample_is(band(WIDTH / 2, share)).judged() == status


@pytest.mark.parametrize(('half_width', 'status'), [
    (0.15, Status.MEASURED), (0.10, Status.LOW_CONFIDENCE)])
def test_the_middle_third_decides(half_width: float, status: Status) -> None:
    # Within 0.33 mm there are 13 samples, of which 7 and 5 are ink.
    assert Scene().sample_is(band(half_width * MM)).judged() == status


def test_glare_on_the_path_does_no_harm() -> None:
    ink = band(WIDTH / 2)
    ink[np.abs(OFFSET) <= 0.25 * MM] = np.nan
    assert Scene().sample_is(ink).judged() == Status.MEASURED


@pytest.mark.parametrize(('first', 'count', 'status'), [
    (0.60, 4, Status.LOW_CONFIDENCE), (0.60, 3, Status.GAP),
    (0.65, 4, Status.GAP)])  # the fourth lies at 0.80 mm
@pytest.mark.parametrize('side', [1, -1])
def test_a_gap_is_bare_nearby(first: float, count: int, status: Status, side: int) -> None:
    # Less than 0.165 mm of ink, that is 3 samples, is allowed within 0.792 mm.
    ink = band(0.0, 0.0)
    ink[80 + side * (round(first / 0.05) + np.arange(count))] = 1.0
    assert Scene().sample_is(ink).judged() == status


@pytest.mark.parametrize(('share', 'status'), [
    (0.605, Status.LOW_CONFIDENCE), (0.595, Status.GAP)])
def test_from_which_share_there_is_ink_in_a_gap(share: float, status: Status) -> None:
    ink = band(0.0, 0.0)
    ink[(OFFSET > 0.35 * MM) & (OFFSET < 0.7 * MM)] = share
    assert Scene().sample_is(ink).judged() == status


def test_what_stands_above_the_bed_is_no_gap() -> None:
    scene = Scene().sample_is(band(0.0, 0.0))
    scene.sections.raised[SAMPLE] = True
    assert scene.verdict() == (Status.LOW_CONFIDENCE, Cause.RAISED)


def test_what_is_neither_ink_nor_bed_says_so() -> None:
    scene = Scene().sample_is(band(WIDTH / 2, 0.5))
    assert scene.verdict() == (Status.LOW_CONFIDENCE, Cause.PARTLY_INK)


def test_the_width_to_be_expected_is_the_median_within_5_mm() -> None:
    # Six of the eleven within 5 mm are wide, but four of nine within 4 mm, and six of 13 within 6.
    width = np.ones(21)
    width[[5, 7, 8, 12, 13, 15]] = 2.0
    along = np.arange(21) * MM
    sections = replace(flat_sections(np.outer(along, (1.0, 0.0, 0.0)), along), spacing=1 * MM)
    assert typical_width(width, sections)[10] == 2.0


@pytest.mark.parametrize(('lean', 'leaning'), [
    (0.011, [19]), (0.009, []), (-0.011, [21]), (0.031, [18, 19]), (0.029, [19])])
def test_a_ridge_that_leans_over_a_gap_hides_it(lean: float, leaning: list[int]) -> None:
    """Sections are 0.02 mm apart, and half of that is added; 0.01 mm is a tenth of a pixel."""
    scene = Scene()
    gap = np.arange(COUNT) == SAMPLE
    sections = replace(scene.sections, lean=np.where(gap, 0.0, lean * MM))
    assert np.flatnonzero(leans_over_gap(sections, gap)).tolist() == leaning
    assert not leans_over_gap(sections, np.zeros(COUNT, bool)).any()


@pytest.mark.parametrize(('lean', 'leaning'), [
    (0.0101, [15, 16, 17, 18, 19]), (0.0099, [])])
def test_a_ridge_that_leans_by_less_than_a_tenth_of_a_pixel_hides_nothing(
        lean: float, leaning: list[int]) -> None:
    """Sections are 0.002 mm apart: five of them are within 0.0111 mm."""
    gap = np.arange(COUNT) == SAMPLE
    sections = Scene().sections
    sections = replace(sections, along=sections.along / 10, spacing=SPACING / 10,
                       lean=np.where(gap, 0.0, lean * MM))
    assert np.flatnonzero(leans_over_gap(sections, gap)).tolist() == leaning


@pytest.mark.parametrize(('noisy', 'before'), [
    (False, Status.LOW_CONFIDENCE), (True, Status.MEASURED)])
def test_what_leans_over_a_gap_is_not_measured(noisy: bool, before: Status) -> None:
    scene = Scene().sample_is(band(0.0, 0.0))
    scene.untold[SAMPLE] = Cause.LOW_CONTRAST if noisy else Cause.NONE  # then it is no gap
    sections = replace(scene.sections, lean=np.full(COUNT, 0.011 * MM))
    status = judge(sections, scene.ink, scene.left, scene.right, scene.untold,
                   scene.faint, scene.ending).status
    assert status[SAMPLE - 1] == before
    assert status[SAMPLE] == (Status.LOW_CONFIDENCE if noisy else Status.GAP)


@pytest.mark.parametrize(('apart', 'met'), [(1.09, True), (1.11, False)])
def test_passes_whose_beads_touch_meet(apart: float, met: bool) -> None:
    """Two beads of 1 mm touch from 1 mm, and a pixel of 0.1 mm, between their middles."""
    along = np.tile(np.arange(20) * SPACING, 2)
    foot = np.column_stack((along, np.repeat((0.0, apart * MM), 20), np.zeros(40)))
    sections = flat_sections(
        foot, np.concatenate((np.arange(20), 5000 + np.arange(20))) * SPACING)
    found = meets_other_pass(sections, np.full(40, 1 * MM), np.ones(40, bool))
    assert found[10] == found[30] == met
    assert not meets_other_pass(sections, np.full(40, 1 * MM), np.arange(40) < 20).any()


@pytest.mark.parametrize(('longer', 'met'), [(0.99, False), (1.01, True)])
def test_a_bend_of_one_pass_meets_nothing(longer: float, met: bool) -> None:
    """Half a circle on a chord of 0.8 mm, and 1 mm of width: 2.257 mm of path, no more."""
    steps = round(longer * (np.pi / 2 * 0.8 + 1.0) * MM / SPACING)
    foot = np.array(((0.0, 0.0, 0.0), (0.0, 0.8 * MM, 0.0)))
    sections = flat_sections(foot, np.array((0, steps)) * SPACING)
    assert meets_other_pass(sections, np.full(2, 1 * MM), np.ones(2, bool)).tolist() == [met] * 2


@pytest.mark.parametrize(('spot', 'wide'), [(0, False), (2, False), (3, True)])
def test_ink_ends_within_half_a_pixel_along_the_path(spot: int, wide: bool) -> None:
    """Between the last column of ink, 100, and the next the image is half ink at 100.5.

    Bed within two rows of five beside the path is a spot, and more is bed.
    """
    image = band_image(rows=(50, 60), columns=(30, 100))
    image[55 - spot // 2:55 + (spot + 1) // 2, 30:101] = BED
    columns = np.array((80.0, 99.95, 100.05, 100.95, 101.05, 120.0))
    sections = replace(flat_sections(surface(np.stack((columns, np.full(6, 55.0)), axis=1))),
                       pixel=IMAGE_PIXEL)
    step = np.subtract(INK, BED).astype(float)
    appearance = Appearance(
        bed=np.tile(np.array(BED, float), (2, 6, 1)), weight=np.tile(step / (step @ step), (6, 1)),
        noise=np.zeros(6), clipped=np.zeros(6, bool), like_ink=np.zeros(6, bool),
        glare_from=np.full((2, 6), np.inf), contrast=None)
    found = ends_within_pixel(View(capture_of(image), DOWN), sections, appearance,
                              np.array((0.0, 0.0, 1.0)))
    assert found.tolist() == [False, False, not wide, not wide, False, False]
