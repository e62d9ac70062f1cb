"""A calibration board with squares.

Its frame has the origin at the outer corner of the first square, x along a row of squares, y along
a column, and z pointing away from somebody who looks at its face.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.errors import CalibrationError

FEWEST_SQUARES = 4  # a row, a column


@dataclass(frozen=True)
class Board:
    """A checkerboard, or a ChArUco board if it has markers.

    Raises CalibrationError if there is no such board.

    Attributes:
        columns, rows: number of squares; for a checkerboard one is even and the other odd, since
            otherwise it looks the same when turned by 180 degrees.
        square: side of a square [m].
        marker: side of a marker [m]; 0 = checkerboard.
        dictionary: of the markers, a name of OpenCV.
    """

    columns: int
    rows: int
    square: float
    marker: float = 0.0
    dictionary: str = 'DICT_4X4_50'

    def __post_init__(self) -> None:
        if min(self.columns, self.rows) < FEWEST_SQUARES or not self.square > 0:
            raise CalibrationError('board: expected 4 x 4 squares or more of a size, found '
                                   f'{self.columns} x {self.rows} of {self.square * 1e3:g} mm'
                                   '; count and measure them, or print a larger board')
        if self.marker:
            self._check_markers()
        elif (self.columns + self.rows) % 2 == 0:
            raise CalibrationError('board: expected an even and an odd number of squares, since '
                                   'others look the same upside down, found '
                                   f'{self.columns} x {self.rows}'
                                   '; take such a board, or a ChArUco board')

    def _check_markers(self) -> None:
        if not 0 < self.marker < self.square:
            raise CalibrationError(f'board: expected markers smaller than the squares of '
                                   f'{self.square * 1e3:g} mm, found {self.marker * 1e3:g} mm'
                                   '; measure both')
        if not hasattr(cv2.aruco, self.dictionary):
            raise CalibrationError('board: expected a dictionary of OpenCV such as DICT_4X4_50, '
                                   f'found {self.dictionary}'
                                   '; name the one that it was printed with')

    def charuco(self) -> cv2.aruco.CharucoBoard:
        """Return a ChArUco board as OpenCV knows it."""
        markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        return cv2.aruco.CharucoBoard((self.columns, self.rows), self.square, self.marker, markers)

    @property
    def corners(self) -> Array:
        """The inner corners (K, 3), row by row, in the board's frame [m]."""
        y, x = np.mgrid[1:self.rows, 1:self.columns]
        return self.square * np.stack((x, y, np.zeros_like(x)), axis=-1).reshape(-1, 3)
