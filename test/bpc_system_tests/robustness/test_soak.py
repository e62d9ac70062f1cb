"""Faults at topic level for a few seconds; the script ``soak.py`` does the same for long."""

from __future__ import annotations

from bpc_system_tests.robustness.soak import growth, soaking
from bpc_system_tests.robustness.soak_printer import Load, NODES

LOAD = Load(full_size=False, capture_rate=8.0, pose_rate=200.0, print_time=30.0,
            camera_faults=0.7, robot_faults=20.0, extruder_faults=5.0, silences=0.5, silence=0.3)


def test_every_capture_is_measured_or_refused_with_its_reason() -> None:
    faults: list[str] = []
    with soaking(LOAD, 3, faults.append) as soak:
        soak.run(3.0)
        outcomes = soak.finish()
        refusals = soak.refusals('path_recorder')
    assert soak.least >= 15
    assert soak.least <= sum(outcomes.values()) <= soak.most, (outcomes, faults)
    assert outcomes['profiles'] > 0
    assert len([fault for fault in faults if 'camera: ' in fault]) > 5
    assert refusals > 0
    for name in NODES:
        for quantity in ('threads', 'files'):
            before, after = growth(soak.samples[name], quantity)
            assert after <= before, (name, quantity)
