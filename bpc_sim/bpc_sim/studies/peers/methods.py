"""Tools that others use to measure width along a path, each with one setting for all scenes.

Every method takes a picture of a plane bed, and returns a width (N,) in pixels: 0 where it finds
no ink at the path, NaN where it does not answer. All know the path and how far from it an edge
may be. They share what a careful user would do first: the colour channel is chosen by Otsu's
own measure, smoothed by a pixel, and inverted if necessary so that ink along the path is bright.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array
from bpc_sim.studies.peers.picture import CUT_STEP_PX, Mask, Picture, remove_specks

SPUR_LENGTH_PX = 15  # shorter ends of a skeleton are pruned
SEED_WIDTH_PX = 15  # of the line along the path that seeds GrabCut
GRAB_CUT_ROUNDS = 5
GAP_CONTRAST_SHARE = 0.3  # a cut with less than this share of the usual contrast is a gap
INK_REACH_PX = 3  # to either side of the path, where a cut shows its own ink
CANNY_REACH_PX = 0.75  # from a cut, within which an edge belongs to it


def medial_axis(picture: Picture) -> Array:
    """Measure twice the distance to the bed on scikit-image's medial axis of Otsu's mask."""
    skeleton, distance = import_optional('skimage.morphology').medial_axis(
        picture.mask, return_distance=True)
    return from_skeleton(picture, np.argwhere(skeleton), 2 * distance[skeleton])


def skeletonize(picture: Picture) -> Array:
    """Measure with scikit-image's skeleton and OpenCV's distance transform of Otsu's mask."""
    skeleton = import_optional('skimage.morphology').skeletonize(picture.mask)
    return from_skeleton(picture, np.argwhere(skeleton), 2 * distances(picture.mask)[skeleton])


def skan(picture: Picture) -> Array:
    """Measure on the branches that skan finds in that skeleton, without the short ends."""
    graph = import_optional('skan').Skeleton(
        import_optional('skimage.morphology').skeletonize(picture.mask))
    table = import_optional('skan').summarize(graph, separator='_')
    long = (table['branch_type'] != 1) | (table['branch_distance'] >= SPUR_LENGTH_PX)
    pixels = np.concatenate([graph.path_coordinates(index)
                             for index in np.flatnonzero(long.to_numpy())]).astype(np.intp)
    return from_skeleton(picture, pixels, 2 * distances(picture.mask)[tuple(pixels.T)])


def grab_cut(picture: Picture) -> Array:
    """Segment with GrabCut, seeded with the path as in earlier work, and cut across the path."""
    label = np.full(picture.image.shape[:2], cv2.GC_BGD, np.uint8)
    line = [np.rint(picture.uv).astype(np.int32)]
    cv2.polylines(label, line, False, cv2.GC_PR_BGD, round(2 * picture.reach))
    # With a definite instead of a probable seed every gap would become ink.
    cv2.polylines(label, line, False, cv2.GC_PR_FGD, SEED_WIDTH_PX)
    ink, bed = np.zeros((2, 1, 65))
    cv2.setRNGSeed(0)
    cv2.grabCut(cv2.GaussianBlur(picture.image, (0, 0), 1.0), label, (0, 0, 0, 0), bed, ink,
                GRAB_CUT_ROUNDS, cv2.GC_INIT_WITH_MASK)
    mask = remove_specks(np.isin(label, (cv2.GC_FGD, cv2.GC_PR_FGD)))
    return first_edges(picture.cuts(mask.astype(np.float64)) - 0.5)


def otsu_cut(picture: Picture) -> Array:
    """Cut the grey levels across the path at Otsu's threshold."""
    return first_edges(picture.cuts(picture.grey) - picture.level)


def half_level(picture: Picture) -> Array:
    """Cut the grey levels half-way between ink and bed of each cut."""
    cuts = picture.cuts(picture.grey)
    middle, margin = cuts.shape[1] // 2, round(INK_REACH_PX / CUT_STEP_PX)
    ink = np.median(cuts[:, middle - margin:middle + margin + 1], axis=1)
    # A low percentile instead of the median: the next strand may be there as well.
    bed = np.stack([np.percentile(side, 10, axis=1)
                    for side in (cuts[:, :middle - margin], cuts[:, middle + margin:])])
    contrast = ink - bed.mean(axis=0)
    usual = np.median(contrast)
    if usual < 5 * cuts[:, :margin].std(axis=1).mean():
        return np.full(len(cuts), np.nan)
    sides = np.repeat((ink + bed) / 2, (middle, cuts.shape[1] - middle), axis=0).T
    return np.where(contrast < GAP_CONTRAST_SHARE * usual, 0.0, first_edges(cuts - sides))


def canny_cut(picture: Picture) -> Array:
    """Measure between the nearest of Canny's edges to either side of the path, on each cut."""
    # The thresholds follow from the step between ink and bed; Sobel's sum is about 1.7 steps.
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
        across = across[np.abs(apart @ (-normal[1], normal[0])) <= CANNY_REACH_PX]
        left, right = across[across > 0], -across[across < 0]
        if len(left) and len(right):
            width[index] = left.min() + right.min()
        elif not len(across):
            width[index] = 0.0
    return width


PEER_METHODS: dict[str, Callable[[Picture], Array]] = {
    'medial axis': medial_axis, 'skeleton + EDT': skeletonize, 'skan': skan,
    'GrabCut from the path': grab_cut, 'Otsu + cut': otsu_cut, 'half-level cut': half_level,
    'Canny + cut': canny_cut}


def from_skeleton(picture: Picture, pixels: NDArray[np.intp], width: Array) -> Array:
    """Return widths (N,) at the path from widths (K,) at a skeleton's pixels (K, 2) as (v, u)."""
    if not len(pixels):
        return np.full(len(picture.uv), np.nan)
    distance, nearest = cKDTree(pixels[:, ::-1]).query(picture.uv)
    found = width[nearest]
    # Only within the ink around the path point.
    found = np.where(distance <= np.maximum(found / 2, 2), found, np.nan)
    return np.where(picture.at(picture.mask) > 0, found, 0.0)


def first_edges(cuts: Array) -> Array:
    """Return the width (N,) between the first changes of sign to either side of the middle.

    Cuts have the shape (N, M). 0 where the middle is not positive, NaN where there is no change.
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
    return np.where(cuts[:, middle] > 0, total * CUT_STEP_PX, 0.0)


def distances(mask: Mask) -> Array:
    """Return the distance (H, W) of ink from the bed [pixels]."""
    return np.asarray(cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2,
                                            cv2.DIST_MASK_PRECISE), np.float64)


def import_optional(module: str) -> Any:
    """Import a module of scikit-image or skan, which only this study needs.

    Raises:
        ValueError: the module is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise ValueError('study peers: expected scikit-image and skan, found no '
                         f'{module.split(".")[0]} (pip install scikit-image skan)') from None
