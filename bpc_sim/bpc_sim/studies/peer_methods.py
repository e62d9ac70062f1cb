"""What others use to measure width along a known path, each with one setting for all scenes.

Every method takes a picture of a plane bed, and gives a width (N,) in pixels: 0 where it finds no
ink at the path, NaN where it does not answer. All are told the path and how far from it an edge
may be. They share what a careful user would do first: the colour channel is chosen by Otsu's
own measure, smoothed by a pixel, and turned so that ink along the path is bright.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert, transform
from bpc_sim.stress.truth import StressScene

REACH = 4e-3  # from the path to the farthest edge, as in our own method [m]
STEP = 0.25  # along a cut [pixels]
SMALLEST = 64  # smaller holes and specks of a mask are taken for noise [pixels]
SPUR = 15  # shorter ends of a skeleton are pruned [pixels]
SEEDED = 15  # width of the line along the path that seeds GrabCut [pixels]
ROUNDS = 5  # of GrabCut
FLAT = 0.3  # a cut with less than this share of the usual contrast is a gap

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Picture:
    """A scene as the other tools take it.

    Attributes:
        image: (H, W, 3) RGB.
        uv: (N, 2) pixels of the path.
        normal: (N, 2) unit vectors across it in the image.
        pixel: length of a pixel's side on the bed [m].
    """

    image: Image
    uv: Array
    normal: Array
    pixel: float

    @property
    def reach(self) -> float:
        """How far from the path an edge may be [pixels]."""
        return REACH / self.pixel

    @cached_property
    def grey(self) -> Image:
        """The channel (H, W) in which ink and bed differ most, smoothed, with ink bright."""
        channels = cv2.split(cv2.GaussianBlur(self.image, (0, 0), 1.0))
        best = np.asarray(max(channels, key=separability), np.uint8)
        level, _ = cv2.threshold(best, 0, 1, cv2.THRESH_OTSU)
        return best if np.median(self.at(best)) > level else 255 - best

    @cached_property
    def level(self) -> float:
        """Otsu's threshold of ``grey``."""
        return float(cv2.threshold(self.grey, 0, 1, cv2.THRESH_OTSU)[0]) + 0.5

    @cached_property
    def mask(self) -> Mask:
        """Otsu's ink (H, W), without small holes and specks."""
        return clean(self.grey > self.level)

    def at(self, values: NDArray[Any]) -> Array:
        """Values (H, W) at the path (N,)."""
        return sample(values, self.uv, order=0)

    def cuts(self, values: NDArray[Any]) -> Array:
        """Values (H, W) along the cuts across the path, (N, M) from right to left."""
        offset = np.arange(-self.reach, self.reach + STEP, STEP)
        return sample(values, self.uv[:, None] + offset[:, None] * self.normal[:, None], order=1)


def picture_of(scene: StressScene) -> Picture:
    """A scene on a plane bed seen from straight above."""
    uv = scene.capture.camera.pixels(transform(invert(scene.T_base_camera), scene.points))
    tangent = np.gradient(uv, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    return Picture(scene.capture.image, uv, tangent[:, ::-1] * (1, -1), scene.pixel)


def medial_axis(picture: Picture) -> Array:
    """scikit-image's medial axis of Otsu's mask: twice its distance to the bed."""
    skeleton, distance = optional('skimage.morphology').medial_axis(
        picture.mask, return_distance=True)
    return from_skeleton(picture, np.argwhere(skeleton), 2 * distance[skeleton])


def skeletonize(picture: Picture) -> Array:
    """scikit-image's skeleton and OpenCV's distance transform of Otsu's mask."""
    skeleton = optional('skimage.morphology').skeletonize(picture.mask)
    return from_skeleton(picture, np.argwhere(skeleton), 2 * distances(picture.mask)[skeleton])


def skan(picture: Picture) -> Array:
    """Branches, by skan, of that skeleton, without its short ends."""
    graph = optional('skan').Skeleton(
        optional('skimage.morphology').skeletonize(picture.mask))
    table = optional('skan').summarize(graph, separator='_')
    long = (table['branch_type'] != 1) | (table['branch_distance'] >= SPUR)
    pixels = np.concatenate([graph.path_coordinates(index)
                             for index in np.flatnonzero(long.to_numpy())]).astype(np.intp)
    return from_skeleton(picture, pixels, 2 * distances(picture.mask)[tuple(pixels.T)])


def grab_cut(picture: Picture) -> Array:
    """GrabCut seeded with the path, as in earlier work, then cut across the path."""
    label = np.full(picture.image.shape[:2], cv2.GC_BGD, np.uint8)
    line = [np.rint(picture.uv).astype(np.int32)]
    cv2.polylines(label, line, False, cv2.GC_PR_BGD, round(2 * picture.reach))
    # A surer seed would make ink of every gap.
    cv2.polylines(label, line, False, cv2.GC_PR_FGD, SEEDED)
    ink, bed = np.zeros((2, 1, 65))
    cv2.setRNGSeed(0)
    cv2.grabCut(cv2.GaussianBlur(picture.image, (0, 0), 1.0), label, (0, 0, 0, 0), bed, ink,
                ROUNDS, cv2.GC_INIT_WITH_MASK)
    mask = clean(np.isin(label, (cv2.GC_FGD, cv2.GC_PR_FGD)))
    return first_edges(picture.cuts(mask.astype(np.float64)) - 0.5)


def otsu_cut(picture: Picture) -> Array:
    """The grey levels along the cuts, at Otsu's threshold."""
    return first_edges(picture.cuts(picture.grey) - picture.level)


def half_level(picture: Picture) -> Array:
    """The grey levels along each cut, half-way between its own ink and its own bed."""
    cuts = picture.cuts(picture.grey)
    middle, margin = cuts.shape[1] // 2, round(3 / STEP)
    ink = np.median(cuts[:, middle - margin:middle + margin + 1], axis=1)
    # Not the median, since the next strand may be there as well.
    bed = np.stack([np.percentile(side, 10, axis=1)
                    for side in (cuts[:, :middle - margin], cuts[:, middle + margin:])])
    contrast = ink - bed.mean(axis=0)
    usual = np.median(contrast)
    if usual < 5 * cuts[:, :margin].std(axis=1).mean():
        return np.full(len(cuts), np.nan)
    sides = np.repeat((ink + bed) / 2, (middle, cuts.shape[1] - middle), axis=0).T
    return np.where(contrast < FLAT * usual, 0.0, first_edges(cuts - sides))


def canny_cut(picture: Picture) -> Array:
    """Canny's edges, the nearest within a pixel of each cut on either side."""
    # The thresholds come from the step between ink and bed, of which Sobel's sum is about 1.7.
    step = float(picture.grey[picture.mask].mean() - picture.grey[~picture.mask].mean())
    edges = cv2.Canny(cv2.GaussianBlur(picture.grey, (0, 0), 1.5), 0.5 * step, step)
    places = np.argwhere(edges)[:, ::-1].astype(np.float64)
    if not len(places):
        return np.full(len(picture.uv), np.nan)
    near = cKDTree(places).query_ball_point(picture.uv, picture.reach)
    width = np.full(len(picture.uv), np.nan)
    for index, (found, foot, normal) in enumerate(
            zip(near, picture.uv, picture.normal, strict=True)):
        apart = places[found] - foot
        across = apart @ normal
        across = across[np.abs(apart @ (-normal[1], normal[0])) <= 0.75]
        left, right = across[across > 0], -across[across < 0]
        if len(left) and len(right):
            width[index] = left.min() + right.min()
        elif not len(across):
            width[index] = 0.0
    return width


PEERS: dict[str, Callable[[Picture], Array]] = {
    'medial axis': medial_axis, 'skeleton + EDT': skeletonize, 'skan': skan,
    'GrabCut from the path': grab_cut, 'Otsu + cut': otsu_cut, 'half-level cut': half_level,
    'Canny + cut': canny_cut}


def from_skeleton(picture: Picture, pixels: NDArray[np.intp], width: Array) -> Array:
    """Widths (N,) at the path of widths at a skeleton's pixels (K, 2) as (v, u)."""
    if not len(pixels):
        return np.full(len(picture.uv), np.nan)
    distance, nearest = cKDTree(pixels[:, ::-1]).query(picture.uv)
    found = width[nearest]
    # Within the ink that the path point is in, and no farther.
    found = np.where(distance <= np.maximum(found / 2, 2), found, np.nan)
    return np.where(picture.at(picture.mask) > 0, found, 0.0)


def first_edges(cuts: Array) -> Array:
    """Width (N,) between the first changes of sign of cuts (N, M) to either side of the middle.

    0 where the middle is not positive, NaN where there is no change.
    """
    middle = cuts.shape[1] // 2
    total = np.zeros(len(cuts))
    for side in (cuts[:, middle:], cuts[:, middle::-1]):
        negative = side <= 0
        first = np.argmax(negative, axis=1)
        row = np.arange(len(side))
        inner, outer = side[row, first - 1], side[row, first]
        edge = first - 1 + inner / np.where(inner > outer, inner - outer, 1.0)
        total += np.where(negative.any(axis=1), edge, np.nan)
    return np.where(cuts[:, middle] > 0, total * STEP, 0.0)


def sample(values: NDArray[Any], uv: Array, order: int) -> Array:
    """Values (H, W) at pixels uv (..., 2)."""
    return np.asarray(map_coordinates(values.astype(np.float64), (uv[..., 1], uv[..., 0]),
                                      order=order, mode='nearest'))


def separability(channel: NDArray[Any]) -> float:
    """Otsu's measure: the share of a channel's variance that lies between its two classes."""
    level, _ = cv2.threshold(channel, 0, 1, cv2.THRESH_OTSU)
    above = channel > level
    share = float(above.mean())
    if share in (0.0, 1.0):
        return 0.0
    step = float(channel[above].mean() - channel[~above].mean())
    return share * (1 - share) * step**2 / float(channel.var())


def clean(mask: Mask) -> Mask:
    """A mask (H, W) without holes and specks smaller than SMALLEST."""
    cleaned = mask.astype(np.uint8)
    for inverted in (0, 1):  # specks, holes
        _, label, stats, _ = cv2.connectedComponentsWithStats(cleaned ^ inverted)
        small = stats[:, cv2.CC_STAT_AREA] < SMALLEST
        small[0] = False
        cleaned[small[label]] = inverted
    return cleaned > 0


def distances(mask: Mask) -> Array:
    """Distance (H, W) of ink from the bed [pixels]."""
    return np.asarray(cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2,
                                            cv2.DIST_MASK_PRECISE), np.float64)


def optional(module: str) -> Any:
    """A module of scikit-image or skan, which nothing but this study needs."""
    try:
        return import_module(module)
    except ImportError:
        raise ValueError('study peers: expected scikit-image and skan, found no '
                         f'{module.split(".")[0]} (pip install scikit-image skan)') from None
