"""Prints whose measurement is timed, and pictures of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_sim.ink.curves import archimedean, meander
from bpc_sim.ink.deposit import constant_width, Deposit
from bpc_sim.scene.imaging import expose, Imaging, mix
from bpc_sim.scene.planar_capture import planar_capture
from bpc_sim.scene.raster import coverage
from bpc_sim.stress.stress_scene import NOZZLE_SPEED_M_PER_S, STAMP_NS

PIXEL_M = 1e-4  # length of a pixel's side on the bed
BEAD_WIDTH_M = 2e-3
IMAGING = Imaging(blur=1.0, noise=2.0, lamp_gradient=0.12)
LEAST_ANSWERED = 0.95  # share of the samples
LONGEST_STEP_S = 0.1  # from point to point of a path
IGNORED_LENGTH_M = 4e-3  # next to ends and gaps, where nothing is compared


@dataclass(frozen=True)
class DrawnPrint:
    """A print on a plane bed and a picture of it.

    Attributes:
        deposit: the ink.
        capture: what the camera delivers.
        T_base_camera: (4, 4) pose of the camera.
    """

    deposit: Deposit
    capture: Capture
    T_base_camera: Array

    def path(self, s: Array) -> DepositionPath:
        """Return the path at arc lengths s (N,) [m]."""
        points = np.column_stack((self.deposit.curve.points(s), np.zeros(len(s))))
        unknown = np.full(len(s), np.nan)
        # Of a path heard of less often it is not known what lies between its points.
        slowness = min(1 / NOZZLE_SPEED_M_PER_S, LONGEST_STEP_S / float(np.diff(s).max()))
        return DepositionPath('print', 0, STAMP_NS * 1e-9, True, s * slowness, s,
                              points, unknown, unknown, np.ones(len(s), bool),
                              np.ones(len(s), bool))

    def error_mm(self, arc_length: Array, thickness: Array) -> float:
        """Return the mean absolute error of thickness (N,) [m] at arc lengths (N,) [m].

        Samples near ends and gaps do not count. Infinite where too few have an answer.
        """
        borders = np.abs(arc_length[:, None] - self.deposit.runs.ravel()).min(axis=1)
        inner = (borders > IGNORED_LENGTH_M) & (self.deposit.width(arc_length) > 0)
        error = np.abs(thickness[inner] - BEAD_WIDTH_M) * 1e3
        given = np.isfinite(error)
        return float(error[given].mean()) if given.mean() >= LEAST_ANSWERED else np.inf


def spiral(width: int, height: int, side: int) -> DrawnPrint:
    """Draw a spiral with two gaps into the middle ``side`` x ``side`` pixels of a picture."""
    curve = archimedean(12 * PIXEL_M * side / 512, np.pi, 6 * np.pi)
    gaps = np.array(((0.2, 0.22), (0.6, 0.63))) * curve.length
    deposit = Deposit(curve, constant_width(BEAD_WIDTH_M), gaps)
    return draw_print(deposit, width, height, side)


def long_print(length: float, seed: int) -> DrawnPrint:
    """Draw the first ``length`` [m] of a meander of 2 m on 0.1 m x 0.1 m."""
    curve = meander(4e-3, 0.088, 22)
    deposit = replace(Deposit(curve, constant_width(BEAD_WIDTH_M)), laid=length)
    return draw_print(deposit, 1000, 1000, 1000, seed)


def draw_print(deposit: Deposit, width: int, height: int, side: int, seed: int = 0) -> DrawnPrint:
    """Draw ink into the middle ``side`` x ``side`` pixels of a picture of width x height."""
    covered = np.zeros((height, width))
    v, u = (height - side) // 2, (width - side) // 2
    covered[v:v + side, u:u + side] = coverage(lambda places: deposit.locate(places).margin,
                                               side, PIXEL_M, 4)
    # The path's origin is the middle of that square, half a pixel off the image's if odd.
    image = expose(mix(IMAGING.ink, IMAGING.bed, covered), covered, IMAGING,
                   np.random.default_rng(seed))
    capture, T_base_camera = planar_capture(image, PIXEL_M, STAMP_NS)
    return DrawnPrint(deposit, capture, T_base_camera)
