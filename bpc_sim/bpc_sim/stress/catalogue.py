"""All stress scenes by name: hard scenes that break measurements which look good on easy ones.

Each is built from a seed; the same seed gives the same scene, to the bit.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bpc_sim.stress import hardware_prints, planar_appearance, planar_geometry, solid_prints
from bpc_sim.stress.stress_scene import StressScene

Builder = Callable[[int], StressScene]

PLANAR: dict[str, Builder] = {
    'plain': planar_appearance.plain,
    'glare_ridge': planar_appearance.glare_ridge,
    'glare_spots': planar_appearance.glare_spots,
    'low_contrast_30': partial(planar_appearance.low_contrast, levels=30),
    'low_contrast_15': partial(planar_appearance.low_contrast, levels=15),
    'lamp_35': planar_appearance.lamp_35,
    'blur_25': planar_appearance.blur_25,
    'bed_texture': planar_appearance.bed_texture,
    'bed_bars': planar_appearance.bed_bars,
    'light_on_dark': planar_appearance.light_on_dark,
    'red_on_green': planar_appearance.red_on_green,
    'translucent': planar_appearance.translucent,
    'ring': planar_geometry.closed_ring,
    'frame': planar_geometry.frame,
    'mesh': planar_geometry.mesh,
    'tight_meander': planar_geometry.tight_meander,
    'touching_meander': planar_geometry.touching_meander,
    'figure_eight': planar_geometry.figure_eight,
    'spills': planar_geometry.spills,
    'path_offset_02': partial(planar_geometry.path_offset, tenths=2),
    'path_offset_04': partial(planar_geometry.path_offset, tenths=4),
    'path_offset_06': partial(planar_geometry.path_offset, tenths=6),
    'gaps_and_ends': planar_geometry.gaps_and_ends,
}

SOLID: dict[str, Builder] = {
    **{name: partial(spiral.scene, name) for name, spiral in solid_prints.SPIRALS.items()},
    'nozzle_in_view': solid_prints.nozzle_in_view,
    'hardware_line': hardware_prints.line_print,
    'hardware_fermat': hardware_prints.fermat_print,
    'hardware_archimedean': hardware_prints.archimedean_print,
    'hardware_archimedean_gaps': hardware_prints.archimedean_print_with_gaps,
}

STRESS: dict[str, Builder] = {**PLANAR, **SOLID}
