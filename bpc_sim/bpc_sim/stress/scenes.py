"""Hard scenes of known truth, by name: what breaks measurements that look good on easy ones."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bpc_sim.stress import planar, solid
from bpc_sim.stress.truth import judge, StressScene, Truth

__all__ = ['PLANAR', 'SOLID', 'STRESS', 'StressScene', 'Truth', 'judge']

Builder = Callable[[int], StressScene]

PLANAR: dict[str, Builder] = {
    'plain': planar.plain,
    'glare_ridge': planar.glare_ridge,
    'glare_spots': planar.glare_spots,
    'low_contrast_30': partial(planar.low_contrast, levels=30),
    'low_contrast_15': partial(planar.low_contrast, levels=15),
    'lamp_35': planar.lamp_35,
    'blur_25': planar.blur_25,
    'bed_texture': planar.bed_texture,
    'bed_bars': planar.bed_bars,
    'light_on_dark': planar.light_on_dark,
    'red_on_green': planar.red_on_green,
    'translucent': planar.translucent,
    'ring': planar.closed_ring,
    'frame': planar.frame,
    'mesh': planar.mesh,
    'tight_meander': planar.tight_meander,
    'touching_meander': planar.touching_meander,
    'figure_eight': planar.figure_eight,
    'spills': planar.spills,
    'path_offset_02': partial(planar.path_offset, tenths=2),
    'path_offset_04': partial(planar.path_offset, tenths=4),
    'path_offset_06': partial(planar.path_offset, tenths=6),
    'gaps_and_ends': planar.gaps_and_ends,
}

SOLID: dict[str, Builder] = {
    **{name: partial(spiral.scene, name) for name, spiral in solid.SPIRALS.items()},
    'nozzle_in_view': solid.nozzle_in_view,
    'hardware_line': solid.hardware_line,
    'hardware_fermat': solid.hardware_fermat,
    'hardware_archimedean': solid.hardware_archimedean,
    'hardware_archimedean_gaps': solid.hardware_archimedean_gaps,
}

# From a seed to the scene; the same seed gives the same scene, to the bit.
STRESS: dict[str, Builder] = {**PLANAR, **SOLID}
