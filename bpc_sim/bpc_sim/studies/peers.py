"""Other tools beside both of our methods, on prints that are easy and on prints that are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
import time

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status
from bpc_sim.scene.planar import planar_capture
from bpc_sim.stress.scenes import PLANAR
from bpc_sim.stress.truth import judge, STAMP_NS, StressScene
from bpc_sim.studies.cases import DRAWINGS
from bpc_sim.studies.comparison import compare, Comparison, together
from bpc_sim.studies.paper_cases import paper_cases
from bpc_sim.studies.peer_methods import optional, PEERS, Picture, picture_of
from bpc_sim.studies.study import METHODS, Row, Study

REPEATS = 3
CASE = 3  # of the paper's table
SCENES = ('case 3 clean', 'case 3 camera', 'glare_ridge', 'low_contrast_30', 'ring', 'mesh',
          'tight_meander', 'spills', 'lamp_35')


@dataclass(frozen=True)
class Measured:
    """A scene, measured by each tool."""

    scene: str
    measured: dict[str, Comparison]


def tasks(seeds: int) -> list[tuple[str, int]]:
    """Scene and seed."""
    for module in ('skimage', 'skan'):  # rather at once than in the middle
        optional(module)
    return [(scene, seed) for scene in SCENES for seed in range(seeds)]


def build(name: str, seed: int) -> StressScene:
    """A stress scene, or the paper's third case as one."""
    drawing = {'case 3 clean': 'area', 'case 3 camera': 'camera'}.get(name)
    if drawing is None:
        return PLANAR[name](seed)
    case = list(paper_cases(seed))[CASE - 1]
    capture, T_base_camera = planar_capture(DRAWINGS[drawing].image(case, seed),
                                            case.pixel_size, STAMP_NS)
    return StressScene(name, capture, T_base_camera, case.path, case.arc_length, case.thickness,
                       judge(case.deposit, case.arc_length, case.pixel_size), case.pixel_size)


def work(task: tuple[str, int]) -> Measured:
    """Build a scene and measure it with each tool, several times for the time."""
    name, seed = task
    scene = build(name, seed)
    tools: dict[str, Callable[[], Comparison]] = {
        f'bpc {method}': partial(compare, scene, method) for method in METHODS}
    tools.update({peer: partial(compare_peer, scene, method) for peer, method in PEERS.items()})
    measured = {}
    for tool, run in tools.items():
        runs = [run() for _ in range(REPEATS)]
        middle = np.array((np.median([one.time[0] for one in runs]),))
        measured[tool] = replace(runs[0], time=middle)
    return Measured(name, measured)


def compare_peer(scene: StressScene, method: Callable[[Picture], Array]) -> Comparison:
    """Measure a scene with another tool; only its own time counts."""
    picture = picture_of(scene)
    started = time.perf_counter()
    thickness = method(picture) * scene.pixel
    taken = time.perf_counter() - started
    status = np.select([np.isnan(thickness), thickness > 0],
                       [Status.LOW_CONFIDENCE, Status.MEASURED], Status.GAP).astype(np.uint8)
    return Comparison(scene.thickness, scene.expected, status, thickness,
                      np.full(len(scene), np.nan), np.array((taken,)))


def rows(found: list[Measured]) -> list[Row]:
    """A row for each scene and tool, its seeds taken together."""
    table = []
    for scene in dict.fromkeys(one.scene for one in found):
        for tool in found[0].measured:
            all_of = together([one.measured[tool] for one in found if one.scene == scene])
            table.append({
                'scene': scene, 'method': tool, 'time_ms': float(all_of.time.mean()) * 1e3,
                'MAE_mm': all_of.mae * 1e3, 'max_mm': all_of.largest_error * 1e3,
                'answered': all_of.answered, 'confidently_wrong': all_of.confidently_wrong,
                'unknowable': all_of.unknowable, 'guessed': all_of.guessed})
    return table


PEERS_STUDY = Study('Other tools, told the path, beside bpc', tasks, work, rows)
