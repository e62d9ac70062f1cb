"""The simulated unevenness beside the published lines that its constants were taken from.

The series lie in ``data/ink_lines`` of the folder ``shared`` beside the repository, with their own
licence: places of an ink's surface in the frames of a video, of lines laid at a known speed. The
first line is left out where lines are compared: half of it is calm.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import detrend

from bpc_perception.core.arrays import Array
from bpc_sim.closed_loop.situations import make_situation
from bpc_sim.ink.measured_series import MeasuredSeries, read_series
from bpc_sim.ink.unevenness import MeasuredUnevenness
from bpc_sim.studies.closed_loop.outcome import rms
from bpc_sim.studies.closed_loop.trial import run_print
from bpc_system_tests.accuracy.published import beside_repository

SPEEDS_M_PER_S = {1: 4.5e-3, 4: 5.5e-3, 7: 6.5e-3}  # by the number of the line
STEP_M = 1e-4
WAVELENGTHS_M = np.arange(1e-3, 8e-3, 2e-5)
HEIGHT_COLUMN = 'up right sub dist (mm)'  # of the same place of the ink, above the bed
MODEL = MeasuredUnevenness()


def published(column: str | None = None) -> MeasuredSeries:
    """The three lines; the test is skipped where they are not."""
    files = [beside_repository(Path(f'shared/data/ink_lines/grasPositions3_line{line}.csv'))
             for line in SPEEDS_M_PER_S]
    if None in files:
        pytest.skip('the published lines are not beside the repository')
    found = [file for file in files if file]
    speeds = list(SPEEDS_M_PER_S.values())
    return read_series(found, speeds, column) if column else read_series(found, speeds)


def level(line: tuple[Array, Array]) -> tuple[Array, Array]:
    """Arc lengths (K,) in even steps [m], and the deviation (K,) from the line's trend."""
    s = np.arange(0, line[0][-1], STEP_M)
    return s, detrend(np.interp(s, *line))


def power(s: Array, deviation: Array, wavelength: float) -> float:
    """The share of the variance at a wavelength [m]."""
    wave = np.exp(-2j * np.pi * s / wavelength)
    return float(2 * np.abs(np.mean(deviation * wave))**2 / deviation.var())


@pytest.mark.parametrize('number', [1, 2])
def test_the_lines_wave_as_the_model_does(number: int) -> None:
    s, deviation = level(published().lines[number])
    strongest = WAVELENGTHS_M[np.argmax([power(s, deviation, one) for one in WAVELENGTHS_M])]
    assert strongest == pytest.approx(MODEL.wavelength, rel=0.1)
    # A wave apart the lines are alike, half a wave apart they are opposite.
    half = round(MODEL.wavelength / 2 / STEP_M)
    for apart, sign in ((half, -1), (2 * half, 1)):
        found = np.corrcoef(deviation[apart:], deviation[:-apart])[0, 1]
        assert sign * found > 0.3
    assert 0.9 * MODEL.wave < deviation.std() < 1.5 * MODEL.wave  # it waves, and jumps besides


@pytest.mark.accuracy
@pytest.mark.parametrize('column', [None, HEIGHT_COLUMN])
@pytest.mark.parametrize('controller', ['advice', 'advice_speed'])
def test_advice_leaves_real_unevenness_alone(controller: str, column: str | None) -> None:
    lines, ratios = published(column), []
    for seed in range(6):
        print_ = make_situation('measured_noise', seed)
        print_ = replace(print_, behaviour=replace(
            print_.behaviour, unevenness=lines, layer=1 + seed % 3))
        followed, without = (rms(run_print(print_, name).error) for name in (controller, 'none'))
        ratios.append(followed / without)
    assert np.mean(ratios) < 1.03
    assert max(ratios) < 1.08
