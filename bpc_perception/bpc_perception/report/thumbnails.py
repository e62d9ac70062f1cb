"""Small pictures of every capture of a print, together of a bounded size."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.result import Result
from bpc_perception.display.overlay import draw_samples

BUDGET_BYTES = 1_800_000  # of all pictures together
MOST_PICTURES = 256
LARGEST_PICTURE_BYTES = 200_000
WIDEST_PICTURE_PX = 960
LARGEST_ENLARGEMENT = 4.0
# Of full colour resolution: dots are small. WebP takes half of the room, and 20 times as long.
ENCODING = (cv2.IMWRITE_JPEG_QUALITY, 80,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444)
SMALLEST_SHRINKAGE = 0.7  # of the sides, in one step
# A picture that needs less than this share of its bytes lets the next one be wider.
ROOMY_SHARE, WIDENING = 0.7, 1.1


class Thumbnails:
    """Overlays of captures as JPEG files; the more there are, the smaller each of them is.

    Attributes:
        pictures: by number of the capture, in the order in which they were added. Of more than
            MOST_PICTURES captures there is a picture of every second one, every fourth and so on,
            and of the last.
    """

    def __init__(self, expected: int | None = None, budget: int = BUDGET_BYTES) -> None:
        """Make room for the captures that are expected.

        Args:
            expected: how many; None = not known. If it is wrong or not known, pictures shrink
                later.
            budget: of all pictures together [bytes].
        """
        self._budget = budget
        self._largest = min(LARGEST_PICTURE_BYTES,
                            budget // min(max(expected or 1, 1), MOST_PICTURES))
        self._width = float(WIDEST_PICTURE_PX)
        self._count, self._every = 0, 1
        self.pictures: dict[int, bytes] = {}

    def skip(self, count: int) -> None:
        """Leave out the first captures, of which there are no pictures."""
        self._count = count

    def add(self, result: Result) -> None:
        """Add the overlay of a capture, or its mere image where nothing was measured."""
        if self.pictures and (self._count - 1) % self._every:
            del self.pictures[self._count - 1]  # it was kept only as the last
        data, width = encode(draw(result, self._width), self._largest)
        # Captures are much alike: the next needs about the same width.
        roomy = len(data) < ROOMY_SHARE * self._largest
        self._width = min(WIDEST_PICTURE_PX, width * (WIDENING if roomy else 1.0))
        self.pictures[self._count] = data
        self._count += 1
        if len(self.pictures) > MOST_PICTURES:
            self._keep_every_second()
        while self._largest and sum(map(len, self.pictures.values())) > self._budget:
            self._halve_the_largest()

    def _keep_every_second(self) -> None:
        """Drop every second picture, but never the last."""
        self._every *= 2
        self.pictures = {number: picture for number, picture in self.pictures.items()
                         if number % self._every == 0 or number == self._count - 1}

    def _halve_the_largest(self) -> None:
        """Allow each picture half of the bytes from now on, and shrink those that have more."""
        self._largest //= 2
        self.pictures = {number: picture if len(picture) <= self._largest
                         else encode(decode(picture), self._largest)[0]
                         for number, picture in self.pictures.items()}


def draw(result: Result, width: float) -> NDArray[np.uint8]:
    """Draw a capture's image in this width [pixels] with what came of its samples.

    Small images are enlarged by LARGEST_ENLARGEMENT at most; otherwise the dots would cover all of
    a bead.

    Returns:
        RGB (H, W, 3).
    """
    image = result.capture.image
    scale = min(LARGEST_ENLARGEMENT, width / image.shape[1])
    picture = np.array(cv2.resize(
        image, None, fx=scale, fy=scale,
        interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST), np.uint8)
    if result.profile is not None:
        draw_samples(picture, result)
    return picture


def encode(picture: NDArray[np.uint8], largest: int) -> tuple[bytes, int]:
    """Encode an RGB picture (H, W, 3) as JPEG, shrunk until it has at most ``largest`` bytes.

    A picture of a single pixel is left as it is.

    Returns:
        The file and the final width [pixels].
    """
    while True:
        _, encoded = cv2.imencode('.jpg', cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), ENCODING)
        if len(encoded) <= largest or max(picture.shape[:2]) == 1:
            return encoded.tobytes(), picture.shape[1]
        shrinkage = max(SMALLEST_SHRINKAGE, 0.95 * float(np.sqrt(largest / len(encoded))))
        size = [max(1, int(shrinkage * side)) for side in picture.shape[1::-1]]
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def decode(data: bytes) -> NDArray[np.uint8]:
    """Return the RGB picture (H, W, 3) in an image file of any kind."""
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)
