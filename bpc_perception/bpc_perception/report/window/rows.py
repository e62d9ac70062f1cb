"""The window of an ink as rows and as values, in the units of people."""

from __future__ import annotations

from collections.abc import Sequence
import csv
import io
import json
import math
from typing import Any

import numpy as np

from bpc_perception.core.window.assess import InkWindow
from bpc_perception.core.window.model import LEVEL, Model, Prediction
from bpc_perception.core.window.sweep import Drive
from bpc_perception.core.window.window import MET, on_target
from bpc_perception.display.plain_json import plain
from bpc_perception.display.units import MM_PER_M

KELVIN = 273.15
DRIVES = {Drive.FLOW: ('flow', 'mm3_s', 1e9), Drive.PRESSURE: ('pressure', 'kpa', 1e-3)}
SIZES = {'width': ('mm', MM_PER_M), 'height': ('mm', MM_PER_M), 'area': ('mm2', MM_PER_M**2)}
DIGITS = 5  # of a number: more are noise
Row = dict[str, Any]


def drive_name(drive: Drive) -> str:
    """Return the name of the column of a drive, with its unit."""
    name, unit, _ = DRIVES[drive]
    return f'{name}_{unit}'


def shown_drive(drive: Drive, value: float) -> float:
    """Return a flow [m^3/s] or pressure [Pa] in its shown unit."""
    return shortened(value * DRIVES[drive][2])


def shortened(value: float) -> float:
    """Return a number with DIGITS digits."""
    return float(f'{value:.{DIGITS}g}')


def ticks(low: float, high: float) -> list[float]:
    """Return round numbers about a logarithmic axis from one value to another."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [shortened(share * 10.0**decade) for decade in decades
            for share in (1, 1.5, 2, 3, 4, 5, 7)]


def speed_rows(window: InkWindow) -> list[Row]:
    """Return, for each speed, between which drives the window is, and what is expected on target.

    NaN = there is none.
    """
    drive, grid = window.proven.drive, window.grid
    name, unit, _ = DRIVES[drive]
    drives, speeds = on_target(grid, window.wanted.width)
    proven = window.proven.holds(drives, speeds) if len(drives) else np.zeros(0, bool)
    rows = []
    for speed, met in zip(grid.speed.tolist(), grid.met, strict=True):
        own = drives[proven & (speeds == speed)]
        row = {'speed_mm_s': speed * MM_PER_M,
               f'{name}_low_{unit}': math.nan, f'{name}_{unit}': math.nan,
               f'{name}_high_{unit}': math.nan}
        if met.any():
            low, high = grid.drive[met][[0, -1]].tolist()
            row |= {f'{name}_low_{unit}': shown_drive(drive, low),
                    f'{name}_high_{unit}': shown_drive(drive, high)}
        if len(own):
            row[f'{name}_{unit}'] = shown_drive(drive, float(own[0]))
        for of, model in window.models.items():
            expected = model.predict(own[:1], np.full(len(own[:1]), speed),
                                     window.wanted.temperature)
            row |= size_values(of, expected)
            if of == 'width':
                row['chance'] = float(expected.chance(*window.wanted.band)[0]
                                      ) if len(own) else math.nan
        rows.append(row)
    return rows


def size_values(of: str, expected: Prediction) -> Row:
    """Return what is expected of a size at the first setting, with uncertainties; NaN = none."""
    unit, factor = SIZES[of]
    if not len(expected.value):
        value = sigma = spread = low = high = math.nan
    else:
        value = factor * float(expected.value[0])
        sigma, spread = (value * float(share[0]) for share in (
            expected.mean_sigma, expected.spread))
        low, high = (factor * expected.interval[0]).tolist()
    return {f'{of}_{unit}': value, f'{of}_sigma_{unit}': sigma, f'{of}_spread_{unit}': spread,
            f'{of}_low_{unit}': low, f'{of}_high_{unit}': high}


def settings(window: InkWindow) -> Row:
    """Return the recommended setting and what to expect of it."""
    drive = window.proven.drive
    values: Row = {drive_name(drive): shown_drive(drive, window.drive),
                   'speed_mm_s': window.speed * MM_PER_M}
    if math.isfinite(window.wanted.temperature):
        values['temperature_c'] = window.wanted.temperature - KELVIN
    for of, expected in window.expected.items():
        values |= {f'expected_{key}': value for key, value in size_values(of, expected).items()}
    share, sigma = window.delivered
    others = {'chance': window.chance, 'delivered_share': share, 'delivered_share_sigma': sigma,
              'start_lag_s': window.start_lag, 'stop_lag_s': window.stop_lag}
    return {key: shortened(value) for key, value in (values | others).items()
            if math.isfinite(value)}


def law(model: Model) -> str:
    """Return the law of a model in words: powers of drive and speed, and what bends them."""
    _, factor = SIZES[model.of]
    drive, unit = model.drive.value, {Drive.FLOW: 'mm³/s', Drive.PRESSURE: 'kPa'}[model.drive]
    terms = model.coefficients
    at_drive = f'({drive} / {shown_drive(model.drive, model.scale.drive):.3g} {unit})'
    at_speed = f'(speed / {model.scale.speed * MM_PER_M:.3g} mm/s)'
    shares = {'d': 0.0, 'v': 0.0}
    for name, share in (('d', 1), ('v', 1)):
        shares[name] += share * terms[name][0] if name in terms else 0.0
    if 'd-v' in terms:
        shares = {'d': terms['d-v'][0], 'v': -terms['d-v'][0]}
    bent = ', bent' if any('²' in name or '·' in name for name in terms) else ''
    size = f'{factor * math.exp(terms["1"][0]):.3f} {SIZES[model.of][0].replace("2", "²")}'
    return (f'{model.of} = {size} × {at_drive}^{shares["d"]:.2f} × '
            f'{at_speed}^{shares["v"]:.2f}{bent}')


def window_csv(window: InkWindow) -> str:
    """Return a row for each speed as CSV with a header; an empty cell = there is none."""
    rows = speed_rows(window)
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator='\n')
    writer.writeheader()
    writer.writerows({key: '' if math.isnan(value) else f'{value:.6g}'
                      for key, value in row.items()} for row in rows)
    return text.getvalue()


def window_json(window: InkWindow, sources: Sequence[str]) -> str:
    """Return all that is known of a window as JSON; null = not known.

    Args:
        window: of an ink.
        sources: the sweeps that it is from.
    """
    wanted = window.wanted
    without = [line.name for line in window.lines if not math.isfinite(line.width)]
    content = {
        'sweeps': list(sources), 'target_mm': wanted.width * MM_PER_M,
        'tolerance': wanted.tolerance, 'level_of_intervals': LEVEL, 'least_chance': MET,
        'lines': len(window.lines), 'lines_without_width': without,
        'settings': settings(window),
        'models': {of: {
            'law': law(model), 'lines': len(model.lines), 'scatter': model.scatter,
            'weights': {each.name: each.weight for each in model.candidates},
            'coefficients': {name: {'value': value, 'sigma': sigma}
                             for name, (value, sigma) in model.coefficients.items()},
        } for of, model in window.models.items()},
        'strangers': [{'line': each.name, 'deviation': each.deviation, 'p': each.p}
                      for each in window.strangers]}
    return json.dumps(plain(content), indent=2, allow_nan=False, ensure_ascii=False) + '\n'
