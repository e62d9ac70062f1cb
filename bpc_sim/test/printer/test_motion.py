"""A nozzle that travels is lifted, goes fast, and pushes no ink out meanwhile."""

import numpy as np
import pytest

from bpc_sim.printer.motion import Motion, Travel
from bpc_sim.printer.print_job import PLUNGER_AREA_M2
from bpc_sim.printer.scenarios import dense, strokes

MM = 1e-3


def test_strokes_and_travel_follow_each_other_in_time() -> None:
    motion = Motion.with_travel(50 * MM, 10 * MM, (
        Travel(20 * MM, 30 * MM, hop=2 * MM, speed=100 * MM, lift_speed=20 * MM, pause=3.0,
               rise=0.5 * MM),))
    # 2 s of stroke, 0.1 s up, 3 s of pause, 0.1 s of way, 0.075 s down, 2 s of stroke.
    assert motion.duration == pytest.approx(7.275)
    t = np.array((1.0, 2.05, 3.0, 5.15, 5.2, 6.275))
    np.testing.assert_allclose(motion.arc_length(t) / MM, (10, 20, 20, 25, 30, 40))
    np.testing.assert_allclose(motion.height(t) / MM, (0, 1, 2, 2, 2, 0.5), atol=1e-9)
    assert motion.on_stroke(t).tolist() == [True, False, False, False, False, True]


def test_ink_lies_on_strokes_alone() -> None:
    job = strokes(0.01)
    t = np.linspace(job.dwell_before, job.end_of_path, 2000)
    pushed = job.extruding(t)
    assert (job.truth(job.laid(t[pushed])) == 2 * MM).all()
    lifted = job.tip(t)[:, 2] > job.tip(t)[pushed][:, 2].max() + 1 * MM
    assert lifted.any()
    assert not pushed[lifted].any()
    # Ink is commanded for the length of the strokes, and no longer.
    assert pushed.mean() * np.ptp(t) == pytest.approx(5 * 36 * MM / 0.01, abs=0.1)
    np.testing.assert_allclose(np.diff(job.plunger_position(t))[~pushed[1:] & ~pushed[:-1]], 0.0,
                               atol=1e-12)


def test_the_plunger_is_drawn_back_for_travel() -> None:
    motion = Motion.with_travel(50 * MM, 10 * MM, (
        Travel(20 * MM, 30 * MM, hop=2 * MM, speed=100 * MM, lift_speed=20 * MM,
               retraction=0.1 * MM, retraction_speed=0.5 * MM),))
    # 2 s of stroke, 0.2 s back, 0.1 s up, 0.1 s of way, 0.1 s down, 0.2 s forth, 2 s of stroke.
    assert motion.duration == pytest.approx(4.7)
    t = np.array((1.0, 2.1, 2.35, 2.6, 3.0))
    np.testing.assert_allclose(motion.retracted(t) / MM, (0, 0.05, 0.1, 0.05, 0), atol=1e-9)
    np.testing.assert_allclose(motion.pushing(t) / MM, (0, -0.5, 0, 0.5, 0), atol=1e-9)
    np.testing.assert_allclose(motion.height(t) / MM, (0, 0, 2, 0, 0), atol=1e-9)
    assert motion.on_stroke(t).tolist() == [True, False, False, False, True]


def test_the_state_of_the_extruder_tells_of_retractions() -> None:
    job = dense(0.01)
    t = np.linspace(0, job.duration, 200_001)
    velocity, position = job.plunger_velocity(t), job.plunger_position(t)
    moved = np.concatenate(([0.0], np.cumsum(velocity[:-1] * np.diff(t))))
    np.testing.assert_allclose(position, moved, atol=0.001 * MM)
    assert velocity.min() == pytest.approx(-0.2 * MM)
    assert (job.extruding(t) == (velocity > 0)).all()
    # In the end it has moved as far as what it laid.
    laid = np.pi / 4 * (2 * MM)**2 * 9 * 36 * MM
    assert position[-1] == pytest.approx(laid / PLUNGER_AREA_M2)
