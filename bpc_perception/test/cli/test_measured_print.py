"""Prints that are read from their results, with what was wanted of them."""

from __future__ import annotations

import json
from pathlib import Path

from design_builders import MM, printed, profile_along, stroke_of
import numpy as np
import pytest

from bpc_perception.cli.printability.measured_print import read_result
from bpc_perception.core.design.comparison import compare_with_design, WantedDesign
from bpc_perception.core.design.design import Design
from bpc_perception.report.profile_table import profile_csv


@pytest.mark.parametrize(('width', 'wanted'), [(0.8, 0.8), (np.nan, 2.0)])
def test_the_width_that_a_design_tells_is_wanted(width: float, wanted: float,
                                                 tmp_path: Path) -> None:
    """And not the 2 mm of the settings, which hold where it tells none."""
    design = Design((stroke_of(((0, 0, 0.3), (20, 0, 0.3), (20, 9, 0.3)), width=width),))
    profile = profile_along(*printed(design))
    found = compare_with_design(profile, WantedDesign('vase.csv', design))
    assert not found.findings.registration.refusal
    (tmp_path / 'profile.csv').write_text(profile_csv(profile, found))
    (tmp_path / 'summary.json').write_text(json.dumps(
        {'print_id': 'vase', 'settings': {'advice.target_thickness': 2 * MM}}))
    target = read_result(tmp_path, None).target
    assert target is not None
    np.testing.assert_allclose(target, wanted * MM)
