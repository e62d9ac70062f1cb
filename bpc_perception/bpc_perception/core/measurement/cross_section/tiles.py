"""A capture in squares, to see where it has changed."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.capture.capture import Capture, PinholeCamera

TILE_PX = 8  # side of a square
# A tile has changed if it differs by more than both of these: a multiple of the sigma of all
# tiles, and grey levels.
CHANGE_SIGMAS = 6.0
LEAST_CHANGE = 2.0
JURY = 1000  # tiles that tell the sigma


@dataclass(frozen=True)
class Tiles:
    """A picture in squares of ``TILE_PX`` pixels; NaN where not looked at, or nothing is known.

    Attributes:
        colour: (H, W, 3) their mean RGB.
        depth: (H, W) the least of some depths in each [m].
    """

    colour: Floats
    depth: Floats

    def where_else(self, changed: Flags, other: Tiles) -> Tiles:
        """Return these tiles, but those of another picture where (H, W) they have changed."""
        return Tiles(np.where(changed[..., None], other.colour, self.colour),
                     np.where(changed, other.depth, self.depth))


def picture(capture: Capture, uv: Array, reach: float) -> Tiles:
    """Return a capture as tiles, as far as they are within a reach [pixels] of pixels (N, 2)."""
    rows, columns = capture.camera.height // TILE_PX, capture.camera.width // TILE_PX
    tiles = Tiles(np.full((rows, columns, 3), np.nan, np.float32),
                  np.full((rows, columns), np.nan, np.float32))
    if not len(uv) or not rows or not columns:
        return tiles
    low = np.maximum((uv.min(axis=0) - reach) // TILE_PX, 0).astype(int)
    high = np.minimum((uv.max(axis=0) + reach) // TILE_PX + 1, (columns, rows)).astype(int)
    part = slice(low[1], high[1]), slice(low[0], high[0])
    pixels = (slice(low[1] * TILE_PX, high[1] * TILE_PX),
              slice(low[0] * TILE_PX, high[0] * TILE_PX))
    width, height = high - low
    # In two steps, since OpenCV is much quicker in halving.
    half = cv2.resize(capture.image[pixels], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    tiles.colour[part] = cv2.resize(half, (int(width), int(height)),
                                    interpolation=cv2.INTER_AREA)
    some = capture.cloud[pixels][TILE_PX // 4::TILE_PX // 2, TILE_PX // 4::TILE_PX // 2, 2]
    upper, lower = (np.fmin(some[row::2, ::2], some[row::2, 1::2]) for row in (0, 1))
    tiles.depth[part] = np.fmin(upper, lower)
    return tiles


def changes(before: Tiles, now: Tiles, least_depth: float) -> Flags:
    """Return which tiles (H, W) differ by more than noise, or in depth by more than this [m].

    Those seen for the first time count as well. Those not looked at do not.
    """
    looked = np.isfinite(now.colour[..., 0])
    step = now.colour[looked] - before.colour[looked]
    known = np.isfinite(step[:, 0])
    if known.any():
        some = step[known][::1 + np.count_nonzero(known) // JURY]
        flicker = np.median(some, axis=0)  # of a lamp is no change
        noise = 1.4826 * float(np.median(np.abs(some - flicker)))
        for channel in range(3):
            known &= np.abs(step[:, channel] - flicker[channel]) <= max(
                LEAST_CHANGE, CHANGE_SIGMAS * noise)
    depth, old = now.depth[looked], before.depth[looked]
    known &= (np.abs(depth - old) <= least_depth) | (np.isnan(depth) & np.isnan(old))
    changed = np.zeros(looked.shape, bool)
    changed[looked] = ~known
    return changed


def tiles_of(uv: Array, seen: Flags, camera: PinholeCamera) -> Index:
    """Return the tile (N, 2) as (row, column) of pixels (N, 2); the first where not seen (N,)."""
    last = np.array((camera.width, camera.height)) // TILE_PX - 1
    tile = np.minimum((np.where(seen[:, None], uv, 0.0) / TILE_PX).astype(np.intp), last)
    return tile[:, ::-1]
