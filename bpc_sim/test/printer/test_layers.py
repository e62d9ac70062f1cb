"""Prints in layers: what lies where, by geometry that can be checked by hand."""

from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.geometry import invert, transform
from bpc_sim.printer.layers import Strands
from bpc_sim.printer.print_job import PLUNGER_AREA_M2
from bpc_sim.printer.scenarios import lattice, lattice_curved, parallel_lines, stack, wall
from bpc_sim.scene.imaging import Imaging
from bpc_sim.scene.scene import Sensor
from bpc_sim.scene.surfaces import Cylinder

PERFECT = Sensor(Imaging(), shading=0, gloss=0, depth_noise=0, dropout=0, rim_dropout=0)
MM = 1e-3
ALONG = parallel_lines(3, 4 * MM, 20 * MM)
CROSSED = Strands(np.concatenate((ALONG, ALONG[..., ::-1])), np.repeat((0, 1), 3), 0.4 * MM,
                  0.1 * MM)


def test_strands_on_the_bed_lie_flat() -> None:
    feet = CROSSED.feet()
    for start, end in CROSSED.arcs[:3]:
        np.testing.assert_allclose(feet(np.linspace(start + 1e-6, end - 1e-6, 50)), 0)


def test_strands_above_rest_where_they_cross_and_hang_between() -> None:
    feet = CROSSED.feet()
    start = CROSSED.arcs[4, 0]
    rests = np.array((6, 10, 14)) * MM  # of a strand of 20 mm, across lines at -4, 0 and 4 mm
    np.testing.assert_allclose(feet(start + rests), 0.4 * MM, atol=2e-6)
    np.testing.assert_allclose(feet(start + rests[:2] + 2 * MM), 0.3 * MM, atol=1e-6)
    np.testing.assert_allclose(feet(start + np.array((2, 18)) * MM), 0.4 * MM)  # beyond them


def test_strands_on_top_of_each_other_lie_on_each_other() -> None:
    job = stack()
    for number, (start, end) in enumerate(job.layers):
        np.testing.assert_allclose(job.commanded.base(np.linspace(start + 1e-6, end - 1e-6, 99)),
                                   number * 0.5 * MM, atol=1e-9)


@pytest.mark.parametrize('job', [stack(0.02), wall(0.02), lattice(0.02), lattice_curved(0.02)])
def test_the_nozzle_goes_a_layer_higher_above_each_strand(job) -> None:
    t = np.linspace(job.dwell_before + 0.01, job.end_of_path - 0.01, 2000)
    t = t[job.extruding(t)]
    points = transform(invert(job.T_base_surface), job.tip(t))
    if isinstance(job.surface, Cylinder):
        radius = job.surface.radius
        height = np.hypot(points[:, 1], points[:, 2] + radius) - radius
    else:
        height = points[:, 2]
    s = job.laid(t)
    layer = np.searchsorted(job.layers[:, 0], s, side='right') - 1
    step = {10: 0.4, 3: 0.5, 4: 0.35}[len(job.layers)] * MM
    np.testing.assert_allclose(height, job.tip_height + layer * step, atol=1e-9)


def tops(job, places):
    """The highest ink (N,) above places (N, 2) on the bed [m], strand by strand."""
    highest = np.zeros(len(places))
    curve, base = job.commanded.curve, job.commanded.base
    for start, end in job.commanded.runs:
        first, last = curve.points(np.array((start + 1e-9, end - 1e-9)))
        way = (last - first) / np.linalg.norm(last - first)
        along = (places - first) @ way
        across = (places - first) @ np.array((-way[1], way[0]))
        width = job.commanded.max_width
        height = base(start + along) + 0.3 * width * (1 - (2 * across / width)**2)
        on = (along > 0) & (along < end - start) & (np.abs(across) < width / 2)
        highest = np.where(on, np.fmax(highest, height), highest)
    return highest


@pytest.mark.parametrize('job', [stack(0.02), lattice(0.02)])
def test_the_cloud_lies_on_the_highest_ink(job) -> None:
    """From straight above, so that no strand hides another."""
    view = job.view
    eye = transform(job.T_base_surface, np.array((0.0, 0.0, 0.34)))
    job = replace(job, sensor=PERFECT, view=replace(view, T_base_camera=looking_down(job, eye)))
    shot = job.capture(job.duration, 0)
    points = transform(invert(job.T_base_surface) @ job.view.T_base_camera,
                       shot.cloud.reshape(-1, 3).astype(float))
    points = points[points[:, 2] < 10 * MM]  # without the nozzle, which is lifted
    expected = tops(job, points[:, :2])
    off = np.abs(points[:, 2] - expected)
    # A ray that grazes a rim or an end meets its side.
    assert np.mean(off < 2e-6) > 0.97
    assert expected.max() > len(job.layers) * 0.3 * MM
    assert points[:, 2].max() == pytest.approx(expected.max(), abs=5e-6)


def looking_down(job, eye):
    pose = job.T_base_surface @ np.diag((1.0, -1.0, -1.0, 1.0))
    pose[:3, 3] = eye
    return pose


@pytest.mark.parametrize('job', [stack(0.02), wall(0.02), lattice(0.02)])
def test_as_much_ink_is_commanded_as_lies_there(job) -> None:
    strokes = np.diff(job.commanded.runs).sum()
    width = job.commanded.max_width
    lies = 2 / 3 * width * 0.3 * width * strokes  # of a parabola
    pushed = (job.plunger_position(job.duration) - job.plunger_position(0.0)) * PLUNGER_AREA_M2
    assert pushed == pytest.approx(lies, rel=1e-4)
    t = np.linspace(0, job.duration, 200001)
    assert np.trapezoid(job.flow_rate(t), t) == pytest.approx(lies, rel=2e-3)


def test_layers_grow_while_they_are_laid() -> None:
    job = stack(0.02)
    amid_second = job.dwell_before + np.interp(
        job.layers[1].mean(), job.laid(t := np.linspace(0, job.duration, 9999)), t)
    assert len(job.laid_layers(0.0)) == 1
    assert len(job.laid_layers(float(amid_second))) == 2
    assert len(job.laid_layers(job.duration)) == 3
