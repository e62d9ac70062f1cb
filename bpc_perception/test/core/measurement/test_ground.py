"""Ink that lay there before is no measurement of what was laid on it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray
from perception_builders import (
    at_ns,
    bed,
    capture_of,
    DOWN,
    INK,
    path_through,
    PIXEL,
    SPEED,
    surface,
)
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig, ThicknessConfig
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.ahead import arc_ahead
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.result import Result
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.session import Session

Picture = NDArray[np.uint8]
BED = Plane(np.array((0.0, 0.0, 1.0)), 0.0)
WIDTH_PX = 10  # of a strand
ROW = 60
LINE = np.column_stack((np.linspace(20, 140, 481), np.full(481, ROW)))  # [pixels]
ANGLE = np.linspace(0, 1.9 * np.pi, 601)
RING = np.column_stack((80 + 30 * np.cos(ANGLE), 60 + 30 * np.sin(ANGLE)))
CORNERS = ((60, 25), (60, 95), (20, 95), (20, ROW), (140, ROW))
OVER = np.concatenate([np.linspace(one, other, 200)[1:] for one, other in pairwise(CORNERS)])
RESIDUE = LINE[300:380]
MARGIN = 4 * WIDTH_PX // 2 + 8  # path points to the end of its ink, and two pixels


def path_of(pixels: Array, seconds: float, print_id: str = 'print',
            start: float = 0.0) -> DepositionPath:
    """The path along pixels that is known after some time, going on."""
    whole = path_through(surface(pixels), start_ns=at_ns(start), speed=SPEED, print_id=print_id,
                         finished=False)
    return replace(whole.until(at_ns(start + seconds)), complete_until=seconds)


def drawn(*strands: Array, width: int = WIDTH_PX) -> Picture:
    """The bed with strands along pixels (N, 2), a little blurred and noisy."""
    image = bed()
    for strand in strands:
        cv2.polylines(image, [np.rint(strand * 16).astype(np.int32)], False, INK, width,
                      cv2.LINE_AA, 4)
    noise = np.random.default_rng(1).normal(0, 1, image.shape)
    return np.clip(cv2.GaussianBlur(image, (0, 0), 0.8) + noise, 0, 255).astype(np.uint8)


def with_spot(image: Picture, index: int, side: int) -> Picture:
    """An image with a square of ink on the line."""
    u, v = np.rint(LINE[index]).astype(int) - side // 2
    image[v:v + side, u:u + side] = INK
    return image


def laid(pixels: Array, seconds: float) -> Array:
    """The part of a strand that is laid by then."""
    return pixels[:len(path_of(pixels, seconds))]


def assert_only_residue_is_doubted(profile: ThicknessProfile) -> None:
    doubted = profile.status != Status.MEASURED
    assert doubted[300:380].all()
    assert not doubted[:300 - MARGIN].any()
    assert not doubted[380 + MARGIN:].any()


class Print:
    """A session on a print along pixels."""

    def __init__(self, pixels: Array, method: str = 'cross_section') -> None:
        self.pixels = pixels
        self.session = Session(ThicknessConfig(method=method, advice=AdviceConfig(
            target_thickness=WIDTH_PX * PIXEL)), HandEye(True, DOWN))

    def captured(self, image: Picture, seconds: float, start: float = 0.0,
                 print_id: str = 'print') -> Result:
        """The result of a capture so long after the start."""
        self.session.set_path(path_of(self.pixels, seconds, print_id, start))
        self.session.add_capture(capture_of(image, at_ns(start + seconds)))
        result, = self.session.results(finish=True)
        return result

    def captured_before(self, image: Picture, seconds: float) -> None:
        """Give a capture of before the print, which is refused."""
        self.session.add_capture(capture_of(image, at_ns(-seconds)))
        result, = self.session.results(finish=True)
        assert result.profile is None


def measured(result: Result) -> float:
    """The share of samples that are MEASURED."""
    assert result.profile is not None
    return float((result.profile.status == Status.MEASURED).mean())


@pytest.mark.parametrize(('pixels', 'method'), [
    (LINE, 'cross_section'), (RING, 'cross_section'), (LINE, 'paper')])
def test_a_print_along_an_old_one_measures_nothing(pixels: Array, method: str) -> None:
    made, old = Print(pixels, method), drawn(pixels)
    for seconds in (0.9, 1.4, 1.9):
        result = made.captured(old, seconds)
        assert measured(result) == 0
        assert result.advice is not None
        assert not result.advice.valid
        assert 'found that of before' in result.warning


@pytest.mark.parametrize(('pixels', 'method', 'least'), [
    (LINE, 'cross_section', 0.99), (RING, 'cross_section', 0.99), (OVER, 'cross_section', 0.6),
    (LINE, 'paper', 0.95)])
def test_on_a_clean_bed_all_is_measured(pixels: Array, method: str, least: float) -> None:
    made = Print(pixels, method)
    for share in (0.3, 0.6, 0.8, 0.97):
        seconds = share * float(path_of(pixels, 99).time[-1])
        result = made.captured(drawn(laid(pixels, seconds)), seconds)
        assert result.warning == ''
        assert measured(result) > least  # nothing is told where it crosses itself


def test_what_lies_on_residue_is_not_measured_and_the_rest_is() -> None:
    made, residue = Print(LINE), RESIDUE
    for seconds in (0.6, 1.2, 1.8, 2.4):
        result = made.captured(drawn(residue, laid(LINE, seconds)), seconds)
    assert result.profile is not None
    assert_only_residue_is_doubted(result.profile)
    assert 'found that of before' in result.warning


def test_what_a_capture_before_the_print_shows_was_there_before() -> None:
    made = Print(LINE)
    made.captured_before(drawn(RESIDUE), 2.0)
    result = made.captured(drawn(LINE), 2.4)
    assert result.profile is not None
    assert_only_residue_is_doubted(result.profile)


def test_a_print_on_the_print_before_is_not_measured_but_on_a_new_bed_it_is() -> None:
    for pause, share in ((2.0, 0.0), (60.0, 1.0)):
        made = Print(LINE)
        assert measured(made.captured(drawn(LINE), 2.4)) > 0.95
        second = drawn(laid(LINE, 1.2)) if share else drawn(LINE)
        result = made.captured(second, 1.2, start=2.4 + pause, print_id='second')
        assert measured(result) == pytest.approx(share, abs=0.05)


def test_old_ink_under_a_part_stays_no_measurement() -> None:
    made, residue = Print(LINE), LINE[200:280]
    for seconds in (0.6, 1.8):
        made.captured(drawn(residue, laid(LINE, seconds)), seconds)
    result = made.captured(drawn(LINE), 2.4)
    assert result.profile is not None
    assert (result.profile.status[205:275] == Status.LOW_CONFIDENCE).all()


def test_what_lies_on_residue_stays_doubted_when_the_next_layer_begins() -> None:
    made = Print(LINE)
    made.captured_before(drawn(LINE[100:180]), 1.0)
    made.captured(drawn(LINE), 2.4)
    # Back, half a millimetre higher.
    back = surface(LINE[:-100:-1]) + np.array((0.0, 0.0, 5e-4))
    path = path_through(np.concatenate((surface(LINE), back)), start_ns=at_ns(0), speed=SPEED)
    made.session.set_path(path)
    made.session.add_capture(capture_of(drawn(LINE), at_ns(path.complete_until)))
    result, = made.session.results(finish=True)
    assert result.profile is not None
    assert result.profile.layer.max() == 1
    assert (result.profile.status[105:175] == Status.LOW_CONFIDENCE).all()
    assert (result.profile.status[:100 - MARGIN] == Status.MEASURED).all()
    assert 'found that of before' in result.warning


def test_a_speck_of_ink_does_no_harm() -> None:
    made, speck = Print(LINE), 4
    for seconds in (0.6, 1.8):
        result = made.captured(with_spot(drawn(laid(LINE, seconds)), 320, speck), seconds)
    assert measured(result) > 0.97


@pytest.mark.parametrize('radius', [0.01, -0.006, np.inf])
def test_a_path_goes_on_along_its_arc(radius: float) -> None:
    def at(length: Array) -> Array:
        if np.isinf(radius):
            return np.column_stack((length, 0 * length, 0 * length))
        return np.column_stack((radius * np.sin(length / radius),
                                radius * (1 - np.cos(length / radius)), 0 * length))

    distances = np.linspace(0.002, 0.006, 9)
    path = at(np.arange(0, 0.02, 0.0002))
    ahead = arc_ahead(path, BED, distances)
    assert np.abs(ahead - at(0.0198 + distances)).max() < 1e-4
    np.testing.assert_allclose(arc_ahead(path[-2:], BED, distances)[:, 2], 0, atol=1e-12)
    assert np.isnan(arc_ahead(np.zeros((5, 3)), BED, distances)).all()
