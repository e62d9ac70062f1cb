"""Other tools beside both of our methods, on easy and on hard prints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
import time

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status
from bpc_sim.scene.planar_capture import planar_capture
from bpc_sim.stress.catalogue import PLANAR
from bpc_sim.stress.stress_scene import STAMP_NS, StressScene
from bpc_sim.stress.truth import classify_samples
from bpc_sim.studies.paper.cases import paper_cases
from bpc_sim.studies.paper.drawing import DRAWINGS
from bpc_sim.studies.peers.methods import import_optional, PEER_METHODS
from bpc_sim.studies.peers.picture import Picture, picture_of
from bpc_sim.studies.study_runner import METHODS, Row, Study
from bpc_sim.studies.truth_comparison import compare_scene, Comparison, merge

REPEATS = 3  # of which the median time counts
PAPER_CASE = 3  # row of the paper's table
SCENES = ('case 3 clean', 'case 3 camera', 'glare_ridge', 'low_contrast_30', 'ring', 'mesh',
          'tight_meander', 'spills', 'lamp_35')


@dataclass(frozen=True)
class MeasuredScene:
    """A scene, measured by each tool.

    Attributes:
        scene: name of the scene.
        comparisons: the comparison with the truth by tool.
    """

    scene: str
    comparisons: dict[str, Comparison]


def tasks(seeds: int) -> list[tuple[str, int]]:
    """Return scene and seed of each task. Raises ValueError if a package is missing."""
    for module in ('skimage', 'skan'):  # at once, not in the middle of the study
        import_optional(module)
    return [(scene, seed) for scene in SCENES for seed in range(seeds)]


def build_scene(name: str, seed: int) -> StressScene:
    """Return a stress scene, or the paper's third case as a stress scene."""
    drawing = {'case 3 clean': 'area', 'case 3 camera': 'camera'}.get(name)
    if drawing is None:
        return PLANAR[name](seed)
    case = list(paper_cases(seed))[PAPER_CASE - 1]
    capture, T_base_camera = planar_capture(DRAWINGS[drawing].image(case, seed),
                                            case.pixel_size, STAMP_NS)
    return StressScene(name, capture, T_base_camera, case.path, case.arc_length, case.thickness,
                       classify_samples(case.deposit, case.arc_length, case.pixel_size),
                       case.pixel_size)


def measure_scene(task: tuple[str, int]) -> MeasuredScene:
    """Build a scene and measure it with each tool, several times to take the time."""
    name, seed = task
    scene = build_scene(name, seed)
    tools: dict[str, Callable[[], Comparison]] = {
        f'bpc {method}': partial(compare_scene, scene, method) for method in METHODS}
    tools.update({peer: partial(compare_peer, scene, method)
                  for peer, method in PEER_METHODS.items()})
    comparisons = {}
    for tool, run in tools.items():
        runs = [run() for _ in range(REPEATS)]
        middle = np.array((np.median([one.time[0] for one in runs]),))
        comparisons[tool] = replace(runs[0], time=middle)
    return MeasuredScene(name, comparisons)


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


def rows(found: list[MeasuredScene]) -> list[Row]:
    """Return a row for each scene and tool, with all seeds together."""
    table = []
    for scene in dict.fromkeys(one.scene for one in found):
        for tool in found[0].comparisons:
            all_of = merge([one.comparisons[tool] for one in found if one.scene == scene])
            table.append({
                'scene': scene, 'method': tool, 'time_ms': float(all_of.time.mean()) * 1e3,
                'MAE_mm': all_of.mae * 1e3, 'max_mm': all_of.largest_error * 1e3,
                'answered': all_of.answered, 'confidently_wrong': all_of.confidently_wrong,
                'unknowable': all_of.unknowable, 'guessed': all_of.guessed})
    return table


PEERS = Study('Other tools, told the path, beside bpc', tasks, measure_scene, rows)
