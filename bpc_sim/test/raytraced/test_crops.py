"""The pictures kept in files are those of their scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.capture.capture import pixel_deviation
from bpc_perception.core.geometry import invert, transform
from bpc_sim.printer.scenarios import bed_pose
from bpc_sim.raytraced.catalogue import SCENES, scenes
from bpc_sim.raytraced.crops import DEPTH_STEP_M, FOLDER, load, save
from bpc_sim.raytraced.looks import Bed, Lamp
from bpc_sim.raytraced.spec import Half, RaytracedScene, Way

MM = 1e-3
scene_of_each = pytest.mark.parametrize('scene', SCENES, ids=[scene.name for scene in SCENES])


def test_half_of_the_scenes_are_only_for_judging_and_see_as_much() -> None:
    assert len(SCENES) >= 40
    assert len({scene.name for scene in SCENES}) == len(SCENES)
    halves = [scenes(half) for half in Half]
    assert len(halves[0]) == len(halves[1])
    for half in halves:
        assert {scene.bed for scene in half} == set(Bed)
        assert {scene.lamp for scene in half} == set(Lamp)
        assert {scene.way for scene in half} == set(Way)
        assert {scene.ink.translucent for scene in half} == {False, True}
        assert {scene.srgb for scene in half} == {False, True}


def test_there_is_a_file_for_each_scene_and_no_other() -> None:
    assert {file.stem for file in FOLDER.glob('*')} == {scene.name for scene in SCENES}


@scene_of_each
def test_points_lie_on_their_pixels_the_bed_where_it_is_and_beads_as_high(
        scene: RaytracedScene) -> None:
    capture = load(scene)
    assert pixel_deviation(capture.cloud, capture.camera) < 0.01
    T_surface_camera = invert(bed_pose()) @ scene.view.T_base_camera
    points = transform(T_surface_camera, capture.cloud.reshape(-1, 3).astype(float))
    points = points[np.isfinite(points).all(axis=1)]
    margin = scene.deposit.locate(points[:, :2]).margin
    bed = points[margin > 2 * scene.pixel, 2]
    assert np.abs(np.median(bed)) < 0.005 * MM
    s = scene.deposit.curve.uniform(60)
    s = s[scene.deposit.inked(s)]
    crest = scene.section.height * scene.deposit.profile(s)
    ridge = np.column_stack((scene.deposit.curve.points(s), crest))
    uv = capture.camera.pixels(transform(invert(T_surface_camera), ridge))
    column, row = np.rint(uv).astype(int).T
    seen = transform(T_surface_camera, capture.cloud[row, column].astype(float))[:, 2]
    below = np.cos(np.radians(scene.tilt_deg)) * 0.2 * MM if scene.ink.translucent else 0.0
    rounding = 0.04 * MM + scene.pixel * 0.3 * np.tan(np.radians(scene.tilt_deg))
    assert np.nanmedian(seen - crest) == pytest.approx(-below, abs=rounding)


def test_what_is_saved_is_loaded_again(tmp_path: Path) -> None:
    scene = SCENES[0]
    capture = load(scene)
    depth = capture.cloud[..., 2].astype(float)
    save(tmp_path, scene, capture.image, depth)
    again = load(scene, tmp_path)
    np.testing.assert_array_equal(again.image, capture.image)
    np.testing.assert_allclose(again.cloud, capture.cloud, atol=DEPTH_STEP_M)
    with pytest.raises(FileExistsError):
        save(tmp_path, scene, capture.image, depth)
