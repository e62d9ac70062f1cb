"""Hard scenes on a plane bed; bpc_sim.stress.sheet says what they have in common."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import meander, ring, turtle
from bpc_sim.ink.deposit import Deposit
from bpc_sim.scene.imaging import mix
from bpc_sim.scene.raster import pixel_centres
from bpc_sim.stress.sheet import (
    along,
    coloured,
    IMAGING,
    PIXEL,
    seeded,
    Sheet,
    SIZE,
    spiral,
    WIDTH,
)
from bpc_sim.stress.truth import StressScene


def plain(seed: int) -> StressScene:
    """Nothing but the usual imperfections."""
    return spiral(seeded('plain', seed)).scene('plain')


def glare_ridge(seed: int) -> StressScene:
    """A bright line along the wet bead, 3.5 pixels wide, 4 off its middle."""
    rng = seeded('glare_ridge', seed)
    sheet = spiral(rng)
    offset = sheet.location.offset * rng.choice((-1.0, 1.0)) / PIXEL - 4
    ridge = 120 * np.exp(-(np.nan_to_num(offset, nan=np.inf) / 1.5)**2 / 2)
    return sheet.scene('glare_ridge', ink=sheet.imaging.ink + ridge.reshape(SIZE, SIZE, 1))


def glare_spots(seed: int) -> StressScene:
    """13 bright spots on the bead, of 2.5 pixels sigma."""
    rng = seeded('glare_spots', seed)
    sheet = spiral(rng)
    v, u = np.mgrid[0:SIZE, 0:SIZE]
    light = np.zeros((SIZE, SIZE))
    for spot in rng.choice(np.flatnonzero(sheet.coverage > 0.99), 13, replace=False):
        light += 110 * np.exp(-((u - spot % SIZE)**2 + (v - spot // SIZE)**2) / (2 * 2.5**2))
    return sheet.scene('glare_spots', ink=sheet.imaging.ink + light[..., None])


def low_contrast(seed: int, levels: float) -> StressScene:
    """Ink a few grey levels darker or brighter than the bed."""
    name = f'low_contrast_{levels:g}'
    rng = seeded(name, seed)
    bed = rng.uniform(120, 180) + rng.uniform(-12, 12, 3)
    ink = bed + levels * rng.choice((-1.0, 1.0))
    return spiral(rng, replace(IMAGING, ink=tuple(ink.tolist()), bed=tuple(bed.tolist()))
                  ).scene(name)


def lamp_35(seed: int) -> StressScene:
    """A lamp that falls from +35 % to -35 %, without saturation."""
    rng = seeded('lamp_35', seed)
    look = coloured(rng)
    dimmed = 180 / max(look.bed)
    ink, bed = (tuple((dimmed * np.array(colour)).tolist()) for colour in (look.ink, look.bed))
    return spiral(rng, replace(look, ink=ink, bed=bed, lamp_gradient=0.35)).scene('lamp_35')


def blur_25(seed: int) -> StressScene:
    """Out of focus."""
    rng = seeded('blur_25', seed)
    return spiral(rng, replace(coloured(rng), blur=2.5)).scene('blur_25')


def bed_texture(seed: int) -> StressScene:
    """A woven bed with grain."""
    rng = seeded('bed_texture', seed)
    sheet = spiral(rng)
    v, u = np.mgrid[0:SIZE, 0:SIZE]
    angle, period = rng.uniform(0, np.pi), rng.uniform(5, 9)
    cos, sin = np.array((np.cos(angle), np.sin(angle))) * 2 * np.pi / period
    weave = 5 * (np.sin(cos * u + sin * v) + np.sin(cos * v - sin * u))
    grain = gaussian_filter(rng.normal(0, 1, (SIZE, SIZE)), 2.0)
    texture = weave + 6 * grain / grain.std()
    return sheet.scene('bed_texture', bed=sheet.imaging.bed + texture[..., None])


def bed_bars(seed: int) -> StressScene:
    """A reflection across the bed, and a shadow across bed and ink."""
    rng = seeded('bed_bars', seed)
    sheet = spiral(rng)
    v, u = np.mgrid[0:SIZE, 0:SIZE] - SIZE / 2
    reflection, shadow = (
        1 / (1 + np.exp((np.abs(np.cos(angle) * u + np.sin(angle) * v - place) - 25) / 3))
        for angle, place in zip(rng.uniform(0, np.pi, 2), rng.uniform(-120, 120, 2), strict=True))
    return sheet.scene('bed_bars', bed=sheet.imaging.bed + 40 * reflection[..., None],
                       shade=1 - 0.3 * shadow[..., None])


def light_on_dark(seed: int) -> StressScene:
    """Light ink on a dark bed."""
    rng = seeded('light_on_dark', seed)
    look = coloured(rng)
    return spiral(rng, replace(look, ink=look.bed, bed=look.ink)).scene('light_on_dark')


def red_on_green(seed: int) -> StressScene:
    """Only the hue differs: both have the same grey level, by 0.299 R + 0.587 G + 0.114 B."""
    rng = seeded('red_on_green', seed)
    red, low = rng.uniform(170, 200), rng.uniform(50, 70)
    green = low + 0.299 / 0.587 * (red - low)
    colours = [(red, low, low), (low, green, low)]
    rng.shuffle(colours)
    return spiral(rng, replace(IMAGING, ink=colours[0], bed=colours[1])).scene('red_on_green')


def translucent(seed: int) -> StressScene:
    """Ink through which half of the bed is seen, with a brighter rim 0.25 mm wide."""
    rng = seeded('translucent', seed)
    sheet = spiral(rng)
    half = (np.array(sheet.imaging.ink) + sheet.imaging.bed) / 2
    rim = 15.0 * (sheet.location.margin > -0.25e-3).reshape(SIZE, SIZE, 1)
    return sheet.scene('translucent', ink=half + rim)


def closed_ring(seed: int) -> StressScene:
    """A closed circle; its outer contour alone would fill it."""
    return along(ring(18e-3), seeded('ring', seed)).scene('ring')


def frame(seed: int) -> StressScene:
    """A closed square of 36 mm with sharp corners, round on the outside."""
    half = 18e-3
    corner = (0.0, np.pi / 2)
    curve = turtle(((half, 0), corner, *(((2 * half, 0), corner) * 3), (half, 0)),
                   (0.0, -half), closed=True)
    sheet = along(curve, seeded('frame', seed))
    discs = [(x, y, WIDTH / 2) for x in (-half, half) for y in (-half, half)]
    return replace(sheet, fills=np.array(discs)).scene('frame')


def mesh(seed: int) -> StressScene:
    """Four strands across four, 8 mm apart, as one path that crosses itself 16 times."""
    run, radius = 30e-3, 4e-3
    left, right = (np.pi * radius, np.pi), (np.pi * radius, -np.pi)
    strands = ((run, 0), left, (run, 0), right, (run, 0), left, (run, 0))
    # From the end of the fourth strand, heading -x, three quarters of a circle to the fifth.
    over = (1.5 * np.pi * 3e-3, -1.5 * np.pi)
    curve = turtle((*strands, over, *strands), (-15e-3, -12e-3))
    return along(curve, seeded('mesh', seed)).scene('mesh')


def tight_meander(seed: int) -> StressScene:
    """Strands 0.5 mm apart from edge to edge."""
    return along(meander(WIDTH + 0.5e-3, 34e-3, 12),
                 seeded('tight_meander', seed)).scene('tight_meander')


def touching_meander(seed: int) -> StressScene:
    """Strands that touch, but for the 12 mm on which the path leads in and out."""
    turn, run, lead = np.pi * WIDTH / 2, 20e-3, 12e-3
    left, right = (turn, np.pi), (turn, -np.pi)
    between = ((run, 0), right, (run, 0), left)
    curve = turtle(((lead + run, 0), left, *(between * 4), (run, 0), right, (run + lead, 0)),
                   (-run / 2 - lead, -10e-3))
    return along(curve, seeded('touching_meander', seed)).scene('touching_meander')


def figure_eight(seed: int) -> StressScene:
    """A closed path that crosses itself once, at a right angle."""
    radius = 9e-3
    loop = 1.5 * np.pi
    straight = (2 * radius, 0.0)
    curve = turtle(((radius * loop / 2, loop / 2), straight, (radius * loop, -loop), straight,
                    (radius * loop / 2, loop / 2)),
                   (-radius * (1 + np.sqrt(2)), 0.0), -np.pi / 2, closed=True)
    return along(curve, seeded('figure_eight', seed)).scene('figure_eight')


def spills(seed: int) -> StressScene:
    """Drops of ink beside the path and against the bead's side, and specks of dirt.

    Where a drop meets or nearly meets a cross segment its width has no meaning: EDGE. Dirt
    keeps 0.3 mm away from the bead's edges.
    """
    rng = seeded('spills', seed)
    sheet = spiral(rng)
    drops = np.concatenate((_touching_drops(sheet, 6), _free_discs(sheet, 14, 0.4e-3, 1.5e-3)))
    sheet = replace(sheet, drops=drops)
    ink, bed = (np.tile(colour, (SIZE * SIZE, 1))
                for colour in (sheet.imaging.ink, sheet.imaging.bed))
    centres = pixel_centres(SIZE, PIXEL)
    for x, y, radius in _free_discs(sheet, 60, 0.1e-3, 0.3e-3):
        beyond = np.hypot(centres[:, 0] - x, centres[:, 1] - y) - radius
        share = np.clip(0.5 - beyond / PIXEL, 0, 1)
        colour = rng.uniform(20, 230, 3)
        ink, bed = mix(colour, ink, share), mix(colour, bed, share)
    return sheet.scene('spills', ink=ink.reshape(SIZE, SIZE, 3), bed=bed.reshape(SIZE, SIZE, 3))


def path_offset(seed: int, tenths: int) -> StressScene:
    """A path some tenths of a millimetre beside the bead's middle."""
    name = f'path_offset_{tenths:02}'
    rng = seeded(name, seed)
    return spiral(rng, amplitude=0.0).scene(
        name, path_shift=1e-4 * tenths * float(rng.choice((-1.0, 1.0))))


def gaps_and_ends(seed: int) -> StressScene:
    """Strands with short gaps, ends that taper to nothing over 3 mm, and bulges of 1.6 widths."""
    rng = seeded('gaps_and_ends', seed)
    curve = meander(6e-3, 36e-3, 6)
    gaps = np.array((0.3e-3, 0.5e-3, 1e-3, 2e-3, 0.3e-3, 0.5e-3, 1e-3, 2e-3))
    places = np.linspace(0, curve.length, len(gaps) + 5)[1:-1]
    places = rng.permutation(places + rng.uniform(-4e-3, 4e-3, len(places)))
    bulges, starts = places[:3], places[3:]

    def width(s: Array) -> Array:
        widened = np.zeros(np.shape(s))
        for place in bulges:
            widened += 0.6 * np.cos(np.clip((s - place) / WIDTH, -1, 1) * np.pi / 2)**2
        tapered = np.clip(np.minimum(s, curve.length - s) / 3e-3, 0, 1)
        return np.asarray(WIDTH * np.where(tapered < 1, tapered, 1 + widened))

    intervals = np.stack((starts, starts + gaps), axis=1)
    return Sheet(Deposit(curve, width, intervals), coloured(rng), rng).scene('gaps_and_ends')


def _touching_drops(sheet: Sheet, count: int) -> Array:
    """Drops (count, 3) that stick out of the bead's side by most of their size [m]."""
    rng, deposit = sheet.rng, sheet.deposit
    s = rng.choice(deposit.curve.uniform(1000)[50:-50], 10 * count, replace=False)
    s = s[deposit.inked(s)][:count]
    radius = rng.uniform(0.5e-3, 1.2e-3, count)
    beside = rng.choice((-1.0, 1.0), count) * (deposit.width(s) / 2
                                               + rng.uniform(0.2, 0.8, count) * radius)
    return np.column_stack((
        deposit.curve.points(s) + beside[:, None] * deposit.curve.normals(s), radius))


def _free_discs(sheet: Sheet, count: int, smallest: float, largest: float) -> Array:
    """Discs (count, 3) on bare bed or on ink, 0.3 mm or more from every edge [m]."""
    half = SIZE * PIXEL / 2
    centres = sheet.rng.uniform(-half, half, (50 * count, 2))
    radius = sheet.rng.uniform(smallest, largest, len(centres))
    fitting = np.abs(sheet.margin(centres)) >= radius + 0.3e-3
    return np.column_stack((centres, radius))[fitting][:count]
