"""Printability of a real photo, compared with what the eye counts and measures in it."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.printability.assess import assess, Conditions, Printability
from bpc_perception.core.printability.pores import Pore
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.offline import measure_bag
from bpc_system_tests.accuracy import photo_of_lines as photo

pytestmark = [pytest.mark.accuracy, pytest.mark.ros]

RIGHT = 2  # the panel whose frame is whole
FRAMES = len(photo.PANEL_STARTS_MM)  # strokes that are laid before the lines
LINES = [(panel, line) for panel in range(FRAMES) for line in range(photo.LINE_COUNT)]
THREAD = {(0, 7)}  # torn, or so thin that the eye is not sure


@pytest.fixture(scope='module')
def found(tmp_path_factory: pytest.TempPathFactory) -> Printability:
    picture = photo.find_photo()
    if picture is None:
        pytest.skip(f'{photo.PHOTO} is not beside the repository')
    bag, hand_eye = photo.write_bag(tmp_path_factory.mktemp('photo'), picture, frames=True)
    result, = measure_bag(Bag(bag), load_hand_eye(hand_eye), ThicknessConfig(), RecorderConfig())
    assert result.profile is not None, result.refusal
    return assess(result.profile, Conditions())


def enclosed(found: Printability, panel: int) -> list[Pore]:
    """The pores of a panel that ink encloses, from the lowest on."""
    start = photo.PANEL_STARTS_MM[panel]
    pores = [pore for pore in found.pores if pore.note != 'ink does not enclose it'
             and start < 1e3 * pore.centre[0] < start + photo.LINE_LENGTH_MM]
    return sorted(pores, key=lambda pore: float(pore.centre[1]))


def middle(between: Array | tuple[int, ...]) -> float:
    """Where the middle of the pores above some lines lies [mm]."""
    return photo.LINE_PITCH_MM * (float(np.mean(between)) + 0.5)


@pytest.mark.parametrize('panel', range(FRAMES))
def test_pores_counted_by_hand(found: Printability, panel: int) -> None:
    pores, counted = enclosed(found, panel), photo.PORES[panel]
    assert [pore.intended for pore in pores] == [len(lines) for lines in counted]
    for pore, lines in zip(pores, counted, strict=True):
        assert 1e3 * pore.centre[1] == pytest.approx(middle(lines), abs=0.2)


@pytest.mark.parametrize(('line', 'size'), photo.PORE_SIZES_MM.items())
def test_pores_measured_by_hand(found: Printability, line: int,
                                size: tuple[float, float]) -> None:
    pore = enclosed(found, RIGHT)[line + 1]
    height, length = size
    assert 1e6 * pore.area == pytest.approx(height * length, rel=photo.PIXEL_MM / 2 / height)
    assert pore.printability == pytest.approx(
        (height + length)**2 / (4 * height * length), abs=2 * pore.printability_sigma)


def test_strands_counted_by_hand(found: Printability) -> None:
    """All lines are told; torn are those in which the eye sees bed, by as much."""
    continuity = {metric.of: metric.value for metric in found.metrics
                  if metric.name == 'continuity' and metric.of.startswith('stroke ')}
    assert len(continuity) == FRAMES + len(LINES)
    for number, line in enumerate(LINES, start=FRAMES + 1):
        start, end = photo.GAPS.get(line, (0.0, 0.0))
        bare = 1 - continuity[f'stroke {number}']
        if line in THREAD:
            assert bare < 0.05
        elif line in photo.GAPS:  # a hair at the end of the ink may count as ink, see there
            assert 0.65 * (end - start) < bare * photo.LINE_LENGTH_MM < end - start + 0.8, line
        else:
            assert bare == pytest.approx(0, abs=1e-6), line
