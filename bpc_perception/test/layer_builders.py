"""Prints of equal layers, whose bead follows from the mass balance.

A bead of width w that gets the share g of the flow Q at a constant speed has w^2 = c g Q; the
constant is that for which FLOW makes TARGET.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from perception_builders import path_through, profile_of, SECOND, START_NS

from bpc_perception.core.arrays import Array
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

TARGET, FLOW = 2e-3, 1e-8
SPACING = 2e-4
STRANDS = ((0, 0), (30, 0), (30, 6), (0, 6), (0, 12), (30, 12))  # [mm]
LAYER_HEIGHT_M = 3e-4
GAIN = float(np.log(TARGET**2 / (FLOW / 0.01)))  # w^2 per volume, at the builders' speed


def way(corners: tuple[tuple[float, float], ...] = STRANDS) -> Array:
    """Points (N, 3) along a line through corners [mm], SPACING apart."""
    ends = np.array(corners, float) * 1e-3
    legs = np.linalg.norm(np.diff(ends, axis=0), axis=1)
    arc = np.concatenate(([0.0], np.cumsum(legs)))
    s = np.arange(0, arc[-1], SPACING)
    return np.column_stack((np.interp(s, arc, ends[:, 0]), np.interp(s, arc, ends[:, 1]),
                            np.zeros(len(s))))


def lacking(place: Array) -> Array:
    """The share that arrives: 0.8, and on 20 mm of each layer a third less."""
    return np.where((place > 0.03) & (place < 0.05), 0.8 / 1.5, 0.8)


class Stack:
    """A print of layers above each other, with travel between them.

    Attributes:
        path: of the print, complete.
        layer: (N,) of each point; -1 = travel.
        width: (N,) as it lies [m].
        place: (N,) from the first ink of the layer on [m].
    """

    def __init__(self, *ways: Array, share: Callable[[Array], Array] = lacking,
                 print_id: str = 'print', start_ns: int = START_NS) -> None:
        points, layers = [], []
        for number, one in enumerate(ways):
            raised = np.add(one, (0, 0, number * LAYER_HEIGHT_M))
            if points:
                between = np.linspace(points[-1][-1], raised[0], 200)[1:-1]
                points.append(between)
                layers.append(np.full(len(between), -1))
            points.append(raised)
            layers.append(np.full(len(one), number))
        self.layer = np.concatenate(layers)
        ink = self.layer >= 0
        path = path_through(np.concatenate(points), start_ns, print_id=print_id, extruding=ink)
        self.place = np.zeros(len(path))
        flow, self.width = np.zeros(len(path)), np.full(len(path), np.nan)
        for number in range(len(ways)):
            mine = np.flatnonzero(self.layer == number)
            place = self.place[mine] = path.arc_length[mine] - path.arc_length[mine[0]]
            flow[mine] = FLOW
            self.width[mine] = TARGET * np.sqrt(share(place))
        self.path = replace(path, flow_rate=flow, plunger_velocity=np.where(ink, 1e-4, 0.0))

    def until(self, layer: int, place: float) -> tuple[ThicknessProfile, DepositionPath]:
        """What a capture shows when the nozzle is there [m], but for the newest 3 mm."""
        last = int(np.flatnonzero((self.layer == layer) & (self.place <= place))[-1])
        kept = np.arange(len(self.layer)) <= last
        return self.profile(last + 1), replace(self.path.where(kept), finished=False)

    def finished(self) -> tuple[ThicknessProfile, DepositionPath]:
        """What a capture shows of the print that is over."""
        return self.profile(len(self.layer), hidden=0), self.path

    def profile(self, count: int, hidden: int = 15) -> ThicknessProfile:
        """What is seen of the first points."""
        layer, width, path = self.layer[:count], self.width[:count], self.path
        status = np.where(layer < 0, Status.BARE, Status.MEASURED).astype(np.uint8)
        status[count - hidden:] = Status.OCCLUDED
        stroke = np.where(layer < 0, 0, layer + 1)
        seen = np.where(status == Status.MEASURED, width, np.nan)
        return replace(
            profile_of(seen.tolist(), status.tolist(), spacing=SPACING),
            stamp_ns=path.start_ns + round((path.time[count - 1] + 0.01) * SECOND),
            print_id=path.print_id, print_start_ns=path.start_ns, time=path.time[:count],
            arc_length=path.arc_length[:count], points=path.points[:count], layer=layer,
            extruding=path.extruding[:count], stroke=stroke)
