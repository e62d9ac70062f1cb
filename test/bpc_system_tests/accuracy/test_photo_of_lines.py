"""A real photo measured offline, compared with what the eye sees in it.

The default method has to be right wherever the eye is sure, in all three panels.

The published method is tested only where it is right. It takes for ink whatever edges enclose:
cells of bed within a closed frame (the right panel; the left panel from line 3 on) become ink,
28 to 45 mm wide, and the bed between counts as measured. A bead's shadow becomes part of the bead
where it is as sharp as the bead (left panel, line 2 and parts of line 1). Canny's higher threshold
has to lie between 300 and 340: below, the frame of the middle panel closes as well; above, the
first lines open.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
import pytest

from bpc_perception.core.config import RecorderConfig, SegmentationConfig, ThicknessConfig
from bpc_perception.core.profile import run_extents, Status, ThicknessProfile
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.offline import measure_bag
from bpc_system_tests.accuracy import photo_of_lines as photo

pytestmark = [pytest.mark.accuracy, pytest.mark.ros]

# Edges of the ink have gradients of 240 to 520, those of its shadow 100 to 260. Where the higher
# threshold opens an edge of the ink, the kernel closes it.
PAPER = ThicknessConfig(method='paper', segmentation=SegmentationConfig(
    canny_low=160.0, canny_high=320.0, kernel_size=7))
# (panel, line) to an interval [mm] where bed is open to the outside and shadows are faint.
PAPER_INTERVALS_MM = {(0, 0): (0.0, 30.0), (0, 1): (9.5, 26.0), **{(1, line): (0.0, 30.0)
                                                      for line in range(photo.LINE_COUNT)}}
OPEN_TRAVELS = {(0, 0), (0, 1), (0, 2), *((1, line) for line in range(photo.LINE_COUNT - 1))}


class Lines:
    """A profile, line by line."""

    def __init__(self, profile: ThicknessProfile) -> None:
        self.profile = profile
        self.x, self.y = 1e3 * profile.points[:, 0], 1e3 * profile.points[:, 1]

    def on(self, panel: int, line: int, start: float, end: float) -> NDArray[np.intp]:
        """Return the samples on a line between two distances from its left end [mm]."""
        return self._between(panel, photo.LINE_PITCH_MM * line, start, end, laying=True)

    def after(self, panel: int, line: int, start: float, end: float) -> NDArray[np.intp]:
        """Return the samples on the way back, half-way between a line and the next."""
        return self._between(panel, photo.LINE_PITCH_MM * (line + 0.5), start, end, laying=False)

    def _between(self, panel: int, y: float, start: float, end: float,
                 laying: bool) -> NDArray[np.intp]:
        along = self.x - photo.PANEL_STARTS_MM[panel]
        found = np.flatnonzero((self.profile.extruding == laying) & (np.abs(self.y - y) < 0.1)
                               & (along > start) & (along < end))
        assert len(found) > 4 * (end - start) - 1, 'the path has 5 points a millimetre'
        return found

    def thickness(self, samples: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return the thickness [mm] of samples, all of which have to be measured."""
        assert (self.profile.status[samples] == Status.MEASURED).all(), self.x[samples]
        return 1e3 * self.profile.thickness[samples]


@pytest.fixture(scope='module')
def recording(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    picture = photo.find_photo()
    if picture is None:
        pytest.skip(f'{photo.PHOTO} is not beside the repository')
    return photo.write_bag(tmp_path_factory.mktemp('photo'), picture)


def measured(recording: tuple[Path, Path], config: ThicknessConfig) -> Lines:
    bag, hand_eye = recording
    results = list(measure_bag(Bag(bag), load_hand_eye(hand_eye), config, RecorderConfig()))
    assert len(results) == 1
    assert results[0].profile is not None, results[0].refusal
    return Lines(results[0].profile)


@pytest.fixture(scope='module')
def lines(recording: tuple[Path, Path]) -> Lines:
    return measured(recording, PAPER)


@pytest.fixture(scope='module')
def default_lines(recording: tuple[Path, Path]) -> Lines:
    return measured(recording, ThicknessConfig())


def within_reach(panel: int, line: int, start: float, end: float) -> bool:
    first, last = PAPER_INTERVALS_MM.get((panel, line), (np.inf, -np.inf))
    return first <= start and end <= last


def test_path_follows_the_lines(lines: Lines) -> None:
    # The fitted camera puts the known geometry on the ink: the ink is centred on the path.
    for line in range(photo.LINE_COUNT):
        for start, end in photo.CONTINUOUS[1, line]:
            at = lines.on(1, line, start, end)
            offset = 1e3 * np.median(lines.profile.left[at] - lines.profile.right[at]) / 2
            assert abs(offset) < photo.PIXEL_MM, (line, start)


def test_continuous_ink_is_measured(lines: Lines) -> None:
    seen = 0
    for (panel, line), stretches in photo.CONTINUOUS.items():
        for start, end in stretches:
            first, last = PAPER_INTERVALS_MM.get((panel, line), (np.inf, -np.inf))
            start, end = max(start, first), min(end, last)
            if end > start:
                width = lines.thickness(lines.on(panel, line, start, end))
                # The narrowest and the widest width by hand, and a pixel at each edge.
                assert width.min() > 0.42 - 2 * photo.PIXEL_MM, (panel, line)
                assert width.max() < 1.27 + 2 * photo.PIXEL_MM, (panel, line)
                seen += len(width)
    assert seen > 1100


@pytest.mark.parametrize(('panel', 'line', 'place'), [
    place for place in photo.WIDTHS_MM if within_reach(place[0], place[1], place[2], place[2])])
def test_width_counted_by_hand(lines: Lines, panel: int, line: int, place: float) -> None:
    width = np.median(lines.thickness(lines.on(panel, line, place - 0.5, place + 0.5)))
    assert width == pytest.approx(photo.WIDTHS_MM[panel, line, place], abs=photo.PIXEL_MM)


@pytest.mark.parametrize(('panel', 'line'), photo.GAPS)
def test_gap_is_found_once_and_whole(lines: Lines, panel: int, line: int) -> None:
    at = lines.on(panel, line, 1.5, 29.0)
    along = lines.x[at] - photo.PANEL_STARTS_MM[panel]
    found = run_extents(lines.profile.status[at] == Status.GAP, along)
    assert len(found) == 1
    (first, last), (start, end) = found[0], photo.GAPS[panel, line]
    assert last == pytest.approx(end, abs=0.4)
    assert first > start - 0.4
    # A hair at the end of the ink may be measured, if its width is that of a hair.
    assert last - first > 0.7 * (end - start)
    hair = at[(along > start + 0.4) & (along < first)]
    assert (lines.thickness(hair) < min(photo.WIDTHS_MM.values())).all()


@pytest.mark.parametrize(('panel', 'line'), sorted(photo.BULGED_LINES & set(PAPER_INTERVALS_MM)))
def test_bulge_is_wider_than_thin_ink(lines: Lines, panel: int, line: int) -> None:
    bulge = lines.thickness(lines.on(panel, line, *photo.BULGE_MM)).max()
    thin = np.median(lines.thickness(lines.on(panel, line, 14.0, 19.0)))
    assert bulge > 2 * thin


def test_bed_between_lines_is_no_ink(lines: Lines) -> None:
    for panel, line in sorted(OPEN_TRAVELS):
        at = lines.after(panel, line, 2.0, 27.0)
        assert (lines.profile.status[at] == Status.BARE).all(), (panel, line)


def test_bed_between_panels_is_no_ink(lines: Lines) -> None:
    for x in (32.5, 67.5):
        at = np.flatnonzero(np.abs(lines.x - x) < 0.1)
        assert len(at) > 150
        assert (lines.profile.status[at] == Status.BARE).all()


def test_default_measures_continuous_ink(default_lines: Lines) -> None:
    at = np.concatenate([default_lines.on(panel, line, start, end)
                         for (panel, line), stretches in photo.CONTINUOUS.items()
                         for start, end in stretches])
    status = default_lines.profile.status[at]
    assert np.isin(status, (Status.MEASURED, Status.LOW_CONFIDENCE)).all()
    assert np.mean(status == Status.MEASURED) > 0.998
    width = 1e3 * default_lines.profile.thickness[at]
    # The narrowest and the widest width by hand, and a pixel at each edge.
    assert np.nanmin(width) > 0.36 - 2 * photo.PIXEL_MM
    assert np.nanmax(width) < 1.27 + 2 * photo.PIXEL_MM


@pytest.mark.parametrize(('panel', 'line', 'place'), photo.WIDTHS_MM)
def test_default_agrees_with_every_width_counted_by_hand(
        default_lines: Lines, panel: int, line: int, place: float) -> None:
    at = default_lines.on(panel, line, place - 0.5, place + 0.5)
    width = np.median(default_lines.thickness(at))
    assert width == pytest.approx(photo.WIDTHS_MM[panel, line, place], abs=photo.PIXEL_MM)


@pytest.mark.parametrize(('panel', 'line'), photo.GAPS)
def test_default_takes_no_gap_for_ink(default_lines: Lines, panel: int, line: int) -> None:
    start, end = photo.GAPS[panel, line]
    status = default_lines.profile.status[default_lines.on(panel, line, start, end)]
    # At its ends, by less than a sample, a gap may count as ink: the eye is not surer.
    assert (status[1:-1] != Status.MEASURED).all()
    # No answer is needed where the ink runs out in a hair, and in the shadow of the drop with
    # which it begins again.
    status = default_lines.profile.status[default_lines.on(panel, line, start + 1.0, end - 0.6)]
    assert (status == Status.GAP).all()


@pytest.mark.parametrize('panel', range(3))
def test_default_finds_the_bed_between_lines(default_lines: Lines, panel: int) -> None:
    for line in range(photo.LINE_COUNT - 1):
        status = default_lines.profile.status[default_lines.after(panel, line, 2.0, 27.0)]
        # Threads and specks lie there; no stretch counts as a strand.
        assert np.mean(status == Status.BARE) > 0.95, line
        assert np.mean(status == Status.OOZE) < 0.02, line
