"""Lines that contradict a smooth law are named; lines that scatter are not."""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
import pytest
from swept_lines import FLOWS, half_circle, MM, SPEEDS, sweep

from bpc_perception.core.window.contradictions import (
    bend,
    CONTRADICTED,
    expect_agreement,
    lack_of_fit,
    strangers,
)
from bpc_perception.core.window.model import fit_model
from bpc_perception.core.window.sweep import Drive, WindowError


def fitted(lines):
    return fit_model(lines, 'width', Drive.FLOW, False)


def test_lines_that_scatter_agree() -> None:
    p = [bend(fitted(sweep(scatter=0.05, seed=seed))) for seed in range(10)]
    assert min(p) > CONTRADICTED
    assert np.mean(p) > 0.3  # uniform from 0 to 1 if the model is right, less what AICc chose
    for seed in range(3):
        expect_agreement(fitted(sweep(scatter=0.02, seed=seed)))
        assert strangers(fitted(sweep(scatter=0.02, seed=seed))) == []


def test_a_law_that_bends_twice_is_a_contradiction() -> None:
    def bent(flow: float, speed: float) -> float:
        return half_circle(flow, speed) * math.exp(0.25 * math.log(flow / speed / 0.2)**3)

    with pytest.raises(WindowError, match=r'lines that contradict it \(p = .*line \d+ \([+-]'):
        expect_agreement(fitted(sweep(bent, scatter=0.02)))


def test_repeated_settings_tell_a_law_that_is_wrong() -> None:
    chance = np.random.default_rng(1)
    shares = {setting: math.exp(0.05 * chance.standard_normal()) for setting in range(25)}
    lines = []
    for seed in range(3):
        once = sweep(scatter=0.003, seed=seed)
        lines += [replace(line, width=shares[number] * line.width)
                  for number, line in enumerate(once)]
    assert lack_of_fit(fitted(lines)) < 1e-6
    again = [line for seed in range(3) for line in sweep(scatter=0.05, seed=seed)]
    assert lack_of_fit(fitted(again)) > CONTRADICTED
    assert lack_of_fit(fitted(sweep(scatter=0.05))) == 1.0


def test_a_line_that_does_not_fit_is_named() -> None:
    lines = sweep(scatter=0.01)
    lines[6] = replace(lines[6], width=1.25 * half_circle(FLOWS[1], SPEEDS[1]) * MM)
    found = strangers(fitted(lines))
    assert [each.name for each in found] == ['line 7']
    assert found[0].deviation == pytest.approx(0.25, abs=0.04)
    assert found[0].p < 1e-6
