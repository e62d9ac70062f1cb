"""Stress scenes on a plane bed that are hard by light, colour, blur or texture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter

from bpc_sim.stress.planar_print import (
    IMAGE_SIZE_PX,
    PIXEL_M,
    random_imaging,
    seeded,
    spiral,
    USUAL_IMAGING,
)
from bpc_sim.stress.stress_scene import StressScene


def plain(seed: int) -> StressScene:
    """Return a scene with the usual imperfections only."""
    return spiral(seeded('plain', seed)).scene('plain')


def glare_ridge(seed: int) -> StressScene:
    """Return a bead with a bright line along it, 3.5 pixels wide, 4 pixels off its middle."""
    rng = seeded('glare_ridge', seed)
    printed = spiral(rng)
    offset = printed.location.offset * rng.choice((-1.0, 1.0)) / PIXEL_M - 4
    ridge = 120 * np.exp(-(np.nan_to_num(offset, nan=np.inf) / 1.5)**2 / 2)
    ridge = ridge.reshape(IMAGE_SIZE_PX, IMAGE_SIZE_PX, 1)
    return printed.scene('glare_ridge', ink=printed.imaging.ink + ridge)


def glare_spots(seed: int) -> StressScene:
    """Return a bead with 13 bright spots of 2.5 pixels standard deviation."""
    rng = seeded('glare_spots', seed)
    printed = spiral(rng)
    v, u = np.mgrid[0:IMAGE_SIZE_PX, 0:IMAGE_SIZE_PX]
    light = np.zeros((IMAGE_SIZE_PX, IMAGE_SIZE_PX))
    for spot in rng.choice(np.flatnonzero(printed.coverage > 0.99), 13, replace=False):
        squared = (u - spot % IMAGE_SIZE_PX)**2 + (v - spot // IMAGE_SIZE_PX)**2
        light += 110 * np.exp(-squared / (2 * 2.5**2))
    return printed.scene('glare_spots', ink=printed.imaging.ink + light[..., None])


def low_contrast(seed: int, levels: float) -> StressScene:
    """Return ink that is a few grey levels darker or brighter than the bed."""
    name = f'low_contrast_{levels:g}'
    rng = seeded(name, seed)
    bed = rng.uniform(120, 180) + rng.uniform(-12, 12, 3)
    ink = bed + levels * rng.choice((-1.0, 1.0))
    return spiral(rng, replace(USUAL_IMAGING, ink=tuple(ink.tolist()), bed=tuple(bed.tolist()))
                  ).scene(name)


def lamp_35(seed: int) -> StressScene:
    """Return a scene whose lamp falls from +35 % to -35 %, without saturation."""
    rng = seeded('lamp_35', seed)
    look = random_imaging(rng)
    dimmed = 180 / max(look.bed)
    ink, bed = (tuple((dimmed * np.array(colour)).tolist()) for colour in (look.ink, look.bed))
    return spiral(rng, replace(look, ink=ink, bed=bed, lamp_gradient=0.35)).scene('lamp_35')


def blur_25(seed: int) -> StressScene:
    """Return a scene that is out of focus."""
    rng = seeded('blur_25', seed)
    return spiral(rng, replace(random_imaging(rng), blur=2.5)).scene('blur_25')


def bed_texture(seed: int) -> StressScene:
    """Return a woven bed with grain."""
    rng = seeded('bed_texture', seed)
    printed = spiral(rng)
    v, u = np.mgrid[0:IMAGE_SIZE_PX, 0:IMAGE_SIZE_PX]
    angle, period = rng.uniform(0, np.pi), rng.uniform(5, 9)
    cos, sin = np.array((np.cos(angle), np.sin(angle))) * 2 * np.pi / period
    weave = 5 * (np.sin(cos * u + sin * v) + np.sin(cos * v - sin * u))
    grain = gaussian_filter(rng.normal(0, 1, (IMAGE_SIZE_PX, IMAGE_SIZE_PX)), 2.0)
    texture = weave + 6 * grain / grain.std()
    return printed.scene('bed_texture', bed=printed.imaging.bed + texture[..., None])


def bed_bars(seed: int) -> StressScene:
    """Return a reflection across the bed, and a shadow across bed and ink."""
    rng = seeded('bed_bars', seed)
    printed = spiral(rng)
    v, u = np.mgrid[0:IMAGE_SIZE_PX, 0:IMAGE_SIZE_PX] - IMAGE_SIZE_PX / 2
    reflection, shadow = (
        1 / (1 + np.exp((np.abs(np.cos(angle) * u + np.sin(angle) * v - place) - 25) / 3))
        for angle, place in zip(rng.uniform(0, np.pi, 2), rng.uniform(-120, 120, 2), strict=True))
    return printed.scene('bed_bars', bed=printed.imaging.bed + 40 * reflection[..., None],
                       shade=1 - 0.3 * shadow[..., None])


def light_on_dark(seed: int) -> StressScene:
    """Return light ink on a dark bed."""
    rng = seeded('light_on_dark', seed)
    look = random_imaging(rng)
    return spiral(rng, replace(look, ink=look.bed, bed=look.ink)).scene('light_on_dark')


def red_on_green(seed: int) -> StressScene:
    """Return ink that differs in hue only; the grey level 0.299 R + 0.587 G + 0.114 B is equal."""
    rng = seeded('red_on_green', seed)
    red, low = rng.uniform(170, 200), rng.uniform(50, 70)
    green = low + 0.299 / 0.587 * (red - low)
    colours = [(red, low, low), (low, green, low)]
    rng.shuffle(colours)
    imaging = replace(USUAL_IMAGING, ink=colours[0], bed=colours[1])
    return spiral(rng, imaging).scene('red_on_green')


def translucent(seed: int) -> StressScene:
    """Return ink that shows half of the bed, with a brighter rim 0.25 mm wide."""
    rng = seeded('translucent', seed)
    printed = spiral(rng)
    half = (np.array(printed.imaging.ink) + printed.imaging.bed) / 2
    rim = 15.0 * (printed.location.margin > -0.25e-3).reshape(IMAGE_SIZE_PX, IMAGE_SIZE_PX, 1)
    return printed.scene('translucent', ink=half + rim)
