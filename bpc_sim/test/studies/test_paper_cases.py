"""The paper's cases: sizes, areas, truth, and the planar capture."""

from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.geometry import transform
from bpc_sim.scene.imaging import Imaging
from bpc_sim.scene.planar_capture import planar_capture
from bpc_sim.studies.paper.cases import make_case, paper_cases
from bpc_sim.studies.paper.drawing import area_coverage, area_raster, polygon_raster

CASES = list(paper_cases(seed=0))


def test_table():
    assert [case.number for case in CASES] == list(range(1, 9))
    assert ''.join(case.curve_type for case in CASES) == 'AFAFAFAF'
    assert CASES[3].reported is not None
    assert CASES[3].reported.mae == pytest.approx(0.057e-3)
    assert CASES[0].path.shape == (1000, 3)
    np.testing.assert_allclose(CASES[0].thickness, 4e-3)
    np.testing.assert_allclose(CASES[4].thickness, np.linspace(1e-3, 4e-3, 1000))
    assert [len(case.deposit.gaps) for case in CASES] == [0] * 6 + [10] * 2
    gaps = np.mean(CASES[7].thickness == 0)
    assert 0.1 < gaps <= 0.2


@pytest.mark.parametrize('case', CASES, ids=lambda case: case.label)
def test_coverage_is_the_area(case):
    area = area_coverage(case).sum() * case.pixel_size**2
    assert area == pytest.approx(case.deposit.area, rel=1e-4)


@pytest.mark.parametrize('case', CASES, ids=lambda case: case.label)
def test_polygons_have_the_area(case):
    image = polygon_raster(case)
    assert image.shape == (512, 512, 3)
    ink = (image == np.array((40, 80, 170))).all(axis=2)
    # Vertices are up to half a pixel off to both sides, which averages out along the edge. But
    # each run of ink ends at the last path sample in it, on average half a sample early.
    spacing = case.deposit.curve.length / 999
    short = len(case.deposit.runs) * spacing * case.deposit.max_width
    area = ink.sum() * case.pixel_size**2
    assert -1.0 * short <= area - case.deposit.area <= 0.01 * case.deposit.area


@pytest.mark.parametrize('ratio', [0.25, 1.0, 1.37])
def test_resolution(ratio):
    case = make_case('F', 0.4e-3, 0.4e-3, 10, rng=np.random.default_rng(0), ratio=ratio)
    assert case.size == int(512 * ratio)
    coverage = area_coverage(case)
    assert coverage.shape == (case.size, case.size)
    assert coverage.sum() * case.pixel_size**2 == pytest.approx(case.deposit.area, rel=1e-3)


def test_gaps_need_a_generator():
    with pytest.raises(ValueError, match='random generator'):
        make_case('A', 2e-3, 2e-3, 10)


def test_image_and_cloud_agree_with_the_path():
    case = CASES[2]
    capture, T_base_camera = planar_capture(area_raster(case), case.pixel_size, stamp_ns=7)
    assert capture.stamp_ns == 7
    points = transform(T_base_camera, capture.cloud.astype(np.float64))
    assert np.abs(points[..., 2]).max() == 0
    np.testing.assert_allclose(points[0, 0], (-25.55e-3, 25.55e-3, 0), atol=2e-9)
    np.testing.assert_allclose(points[255, 256] - points[255, 255], (1e-4, 0, 0), atol=2e-9)
    np.testing.assert_allclose(points[254, 255] - points[255, 255], (0, 1e-4, 0), atol=2e-9)
    covered = case.deposit.height(points[..., :2].reshape(-1, 2)) > 0
    ink = capture.image[..., 0].ravel() < 122
    assert np.mean(covered == ink) > 0.999
    uv = capture.camera.pixels((case.path - T_base_camera[:3, 3]) * (1, -1, -1))
    pixel = np.rint(uv).astype(int)
    assert (capture.image[pixel[:, 1], pixel[:, 0], 0] == 40)[2:-2].all()


def test_imperfections_are_repeatable_and_have_their_size():
    case = replace(CASES[2], ratio=0.5)
    plain = area_raster(case).astype(float)
    noisy = area_raster(case, Imaging(noise=5.0), seed=3)
    np.testing.assert_array_equal(noisy, area_raster(case, Imaging(noise=5.0), seed=3))
    assert np.std(noisy - plain) == pytest.approx(5, rel=0.02)
    lit = area_raster(case, Imaging(lamp_gradient=0.1))
    assert lit[0, 0, 0] > 220 > 190 > lit[-1, -1, 0]
    assert (area_raster(case, Imaging(glare_spots=5)).min(axis=2) == 255).any()
