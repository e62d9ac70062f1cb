"""Small pictures of every capture of a print, together of a bounded size."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.session import Result
from bpc_perception.display.overlay import draw_samples

BUDGET = 1_800_000  # of all pictures together [bytes]
MOST = 256  # pictures
LARGEST = 200_000  # of one [bytes]
WIDEST = 960  # [pixels]
ENLARGE = 4.0
QUALITY = 80  # of WebP, in percent
SHRINK = 0.7  # at most at once
ROOM = 0.7  # below this share of what it may have, the next picture is larger
GROW = 1.1


class Thumbnails:
    """Overlays of captures as WebP files; the more there are, the smaller each of them is.

    Attributes:
        pictures: of the captures by number, as they were added; beyond MOST of every second one,
            every fourth and so on, and of the last.
    """

    def __init__(self, expected: int | None = None, budget: int = BUDGET) -> None:
        """Expect so many captures; where that is wrong or not known, pictures shrink later."""
        self._budget = budget
        self._largest = min(LARGEST, budget // min(max(expected or 1, 1), MOST))
        self._width = float(WIDEST)
        self._count, self._every = 0, 1
        self.pictures: dict[int, bytes] = {}

    def add(self, result: Result) -> None:
        """Add the overlay of a capture, or its mere image where nothing was measured."""
        if self._count and (self._count - 1) % self._every:
            del self.pictures[self._count - 1]
        data, width = encode(draw(result, self._width), self._largest)
        # Captures are much alike: what the one needed the next will need as well.
        self._width = min(WIDEST, width * (GROW if len(data) < ROOM * self._largest else 1.0))
        self.pictures[self._count] = data
        self._count += 1
        if len(self.pictures) > MOST:
            self._every *= 2
            self.pictures = {number: picture for number, picture in self.pictures.items()
                             if number % self._every == 0 or number == self._count - 1}
        while self._largest and sum(map(len, self.pictures.values())) > self._budget:
            self._largest //= 2
            self.pictures = {number: picture if len(picture) <= self._largest
                             else encode(decode(picture), self._largest)[0]
                             for number, picture in self.pictures.items()}


def draw(result: Result, width: float) -> NDArray[np.uint8]:
    """The capture's image, RGB (H, W, 3), as wide as this, with what came of its samples.

    Small images are enlarged, or else the dots would cover all of a bead, but by ENLARGE at most.
    """
    image = result.capture.image
    scale = min(ENLARGE, width / image.shape[1])
    picture = np.array(cv2.resize(
        image, None, fx=scale, fy=scale,
        interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST), np.uint8)
    if result.profile is not None:
        draw_samples(picture, result)
    return picture


def encode(picture: NDArray[np.uint8], largest: int) -> tuple[bytes, int]:
    """An RGB picture (H, W, 3) as WebP, made smaller until it has no more than ``largest`` bytes.

    A picture of a single pixel is left as it is. Also tells the width that it has in the end.
    """
    while True:
        _, encoded = cv2.imencode('.webp', cv2.cvtColor(picture, cv2.COLOR_RGB2BGR),
                                  (cv2.IMWRITE_WEBP_QUALITY, QUALITY))
        if len(encoded) <= largest or max(picture.shape[:2]) == 1:
            return encoded.tobytes(), picture.shape[1]
        shrink = max(SHRINK, 0.95 * float(np.sqrt(largest / len(encoded))))
        size = [max(1, int(shrink * side)) for side in picture.shape[1::-1]]
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def decode(data: bytes) -> NDArray[np.uint8]:
    """The RGB picture (H, W, 3) in a file of any kind."""
    found = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert found is not None
    return np.asarray(cv2.cvtColor(found, cv2.COLOR_BGR2RGB), np.uint8)
