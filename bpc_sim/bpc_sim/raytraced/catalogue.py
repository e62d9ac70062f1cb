"""The ray-traced scenes: half for tuning, half only for judging.

Nothing of the method may be chosen by what it does on the judging half.
"""

from __future__ import annotations

import numpy as np

from bpc_sim.raytraced.looks import Bed, Ink, Lamp
from bpc_sim.raytraced.section import cap, Section, superellipse
from bpc_sim.raytraced.spec import Half, RaytracedScene, Way

WHITE, CREAM = Ink((0.80, 0.80, 0.78)), Ink((0.72, 0.64, 0.45))
GREY = Ink((0.30, 0.30, 0.31), 0.14)
BLACK, BLUE, NAVY = Ink((0.02, 0.02, 0.02)), Ink((0.05, 0.16, 0.60)), Ink((0.02, 0.04, 0.20))
GREEN, OLIVE = Ink((0.08, 0.40, 0.12)), Ink((0.20, 0.22, 0.06), 0.15)
RED, PINK = Ink((0.55, 0.05, 0.06)), Ink((0.75, 0.35, 0.45))
ORANGE, YELLOW = Ink((0.75, 0.28, 0.04)), Ink((0.75, 0.60, 0.08))
VIOLET, TEAL = Ink((0.28, 0.09, 0.42)), Ink((0.05, 0.40, 0.42))
BLUE_GEL = Ink((0.10, 0.35, 0.85), 0.06, translucent=True)
CLEAR_GEL = Ink((0.75, 0.75, 0.72), 0.05, translucent=True, extinction=1200.0)
RED_GEL = Ink((0.80, 0.20, 0.15), 0.08, translucent=True)
MILKY_GEL = Ink((0.97, 0.96, 0.93), 0.06, translucent=True, extinction=4000.0)


def angle(degrees: float) -> Section:
    """Return the arc of a circle with this contact angle."""
    return cap(np.radians(degrees))


LOW, USUAL, ROUND = superellipse(0.22, 2.2), superellipse(0.35, 1.6), superellipse(0.5, 2.0)
FLAT = superellipse(0.15, 2.6)
TUNE, JUDGE = Half.TUNING, Half.JUDGING
S, PAPER, SKIN, TISSUE = RaytracedScene, Bed.PAPER, Bed.SKIN, Bed.TISSUE
METAL, GRID, PLASTIC = Bed.METAL, Bed.GRID, Bed.PLASTIC
SOFT, TUBE, SPOT = Lamp.SOFT, Lamp.TUBE, Lamp.SPOT

SCENES: tuple[RaytracedScene, ...] = (
    S('blue_on_paper', TUNE, BLUE, PAPER, SOFT, USUAL),
    S('white_on_plastic', TUNE, WHITE, PLASTIC, SOFT, USUAL),
    S('cream_on_plastic_tube', TUNE, CREAM, PLASTIC, TUBE, angle(70), 7.0),
    S('pink_on_skin', TUNE, PINK, SKIN, SOFT, LOW, 10.0),
    S('red_on_grid_tube', TUNE, RED, GRID, TUBE, USUAL, 8.0),
    S('white_on_tissue_spot', TUNE, WHITE, TISSUE, SPOT, angle(60), 9.0, Way.SPIRAL),
    S('orange_on_metal_tube', TUNE, ORANGE, METAL, TUBE, USUAL, 8.0, srgb=True),
    S('black_on_paper_corners', TUNE, BLACK, PAPER, SPOT, USUAL, 8.0, Way.CORNERS),
    S('green_on_paper_turns', TUNE, GREEN, PAPER, SOFT, angle(90), 9.0, Way.TURNS),
    S('violet_on_tissue_gaps', TUNE, VIOLET, TISSUE, SOFT, LOW, 8.0, Way.GAPS, srgb=True),
    S('blue_gel_on_paper', TUNE, BLUE_GEL, PAPER, SOFT, USUAL),
    S('clear_gel_on_plastic', TUNE, CLEAR_GEL, PLASTIC, SPOT, angle(50), 10.0),
    S('milky_gel_on_skin', TUNE, MILKY_GEL, SKIN, SOFT, USUAL, 9.0),
    S('teal_on_grid_15', TUNE, TEAL, GRID, SOFT, USUAL, 9.0, tilt_deg=15),
    S('yellow_on_paper_32', TUNE, YELLOW, PAPER, SOFT, USUAL, 9.0, tilt_deg=32),
    S('white_on_plastic_30', TUNE, WHITE, PLASTIC, TUBE, angle(80), 9.0, tilt_deg=30),
    S('navy_on_metal_45', TUNE, NAVY, METAL, SOFT, LOW, 9.0, tilt_deg=45),
    S('blue_on_paper_110', TUNE, BLUE, PAPER, SPOT, angle(110), 9.0, tilt_deg=10),
    S('grey_on_skin_coarse', TUNE, GREY, SKIN, SOFT, USUAL, 6.0, pixel_mm=0.34),
    S('red_on_paper_fine', TUNE, RED, PAPER, SOFT, USUAL, 12.0, pixel_mm=0.1),
    S('blue_on_paper_defocus', TUNE, BLUE, PAPER, SOFT, USUAL, 9.0, defocus_px=2.0),
    S('pink_on_grid_defocus', TUNE, PINK, GRID, SOFT, LOW, 10.0, defocus_px=3.0, srgb=True),
    S('white_on_tissue_coarse', TUNE, WHITE, TISSUE, TUBE, ROUND, 5.0, Way.SPIRAL, 0.4),
    S('green_on_plastic_flat', TUNE, GREEN, PLASTIC, SPOT, FLAT, 12.0, srgb=True),

    S('navy_on_paper', JUDGE, NAVY, PAPER, TUBE, LOW, 8.0),
    S('yellow_on_plastic', JUDGE, YELLOW, PLASTIC, SOFT, USUAL, 9.0),
    S('white_on_plastic_spot', JUDGE, WHITE, PLASTIC, SPOT, angle(55), 8.0, srgb=True),
    S('red_on_skin', JUDGE, RED, SKIN, SPOT, USUAL, 9.0),
    S('violet_on_grid', JUDGE, VIOLET, GRID, SOFT, angle(75), 9.0),
    S('cream_on_tissue_tube', JUDGE, CREAM, TISSUE, TUBE, USUAL, 8.0),
    S('teal_on_metal_spot', JUDGE, TEAL, METAL, SPOT, LOW, 9.0),
    S('pink_on_paper_corners', JUDGE, PINK, PAPER, SOFT, angle(65), 8.0, Way.CORNERS, srgb=True),
    S('orange_on_tissue_turns', JUDGE, ORANGE, TISSUE, SOFT, USUAL, 9.0, Way.TURNS),
    S('green_on_skin_gaps', JUDGE, GREEN, SKIN, TUBE, LOW, 8.0, Way.GAPS),
    S('red_gel_on_paper', JUDGE, RED_GEL, PAPER, TUBE, USUAL, 9.0),
    S('milky_gel_on_plastic', JUDGE, MILKY_GEL, PLASTIC, SOFT, angle(65), 9.0),
    S('blue_gel_on_tissue', JUDGE, BLUE_GEL, TISSUE, SPOT, LOW, 10.0),
    S('white_on_grid_20', JUDGE, WHITE, GRID, TUBE, USUAL, 9.0, tilt_deg=20),
    S('blue_on_skin_25', JUDGE, BLUE, SKIN, SOFT, angle(75), 9.0, tilt_deg=25),
    S('cream_on_plastic_35', JUDGE, CREAM, PLASTIC, SOFT, USUAL, 9.0, tilt_deg=35),
    S('red_on_paper_42', JUDGE, RED, PAPER, SPOT, LOW, 9.0, tilt_deg=42, srgb=True),
    S('green_on_paper_120', JUDGE, GREEN, PAPER, SOFT, angle(120), 9.0, tilt_deg=8),
    S('blue_on_metal_coarse', JUDGE, BLUE, METAL, SOFT, USUAL, 6.0, pixel_mm=0.3),
    S('olive_on_grid_fine', JUDGE, OLIVE, GRID, SPOT, USUAL, 12.0, pixel_mm=0.1),
    S('black_on_skin_defocus', JUDGE, BLACK, SKIN, SOFT, USUAL, 9.0, defocus_px=1.5),
    S('yellow_on_tissue_defocus', JUDGE, YELLOW, TISSUE, TUBE, LOW, 10.0, defocus_px=3.0),
    S('grey_on_paper_coarse', JUDGE, GREY, PAPER, TUBE, ROUND, 5.0, Way.SPIRAL, 0.4),
    S('clear_gel_on_plastic_tube', JUDGE, CLEAR_GEL, PLASTIC, TUBE, angle(70), 9.0),
)


def scenes(half: Half | None = None) -> tuple[RaytracedScene, ...]:
    """Return all scenes, or those of a half."""
    return tuple(scene for scene in SCENES if half in (None, scene.half))
