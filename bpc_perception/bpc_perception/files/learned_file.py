"""What prints taught, kept for the next in a file that a user can read and throw away."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig, LearningConfig
from bpc_perception.core.learning.layer_schedule import LayerSchedule, ScheduleReason
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_perception.files.yaml_file import FileError, read_yaml

HEAD = '''\
# What prints of this path, ink and nozzle taught. Factors are on the flow per length of path that
# the first layer learned from began with. Throw this file away to learn anew.
'''
MOST_BYTES = 10_000_000
MM, MM2 = 1e-3, 1e-6
ROW = 'place_mm', 'factor', 'x_mm', 'y_mm', 'z_mm'
NUMBERS = {'sigma': 1.0, 'level_sigma': 1.0, 'reference_mm2': MM2, 'advance_s': 1.0,
           'retreat_s': 1.0}


def save_learned(file: Path, told: LayerSchedule, config: LearningConfig) -> None:
    """Write a valid schedule whole, in the place of what was kept before. Raises OSError."""
    schedule = told.schedule
    assert schedule is not None
    head = {'ink': config.ink, 'nozzle': config.nozzle,
            'sigma': schedule.sigma, 'level_sigma': schedule.level_sigma,
            'reference_mm2': schedule.reference / MM2, 'advance_s': schedule.advance,
            'retreat_s': schedule.retreat,
            'based_on': [{'print': name, 'layer': layer} for name, layer in told.based_on]}
    rows = np.column_stack((schedule.place / MM, schedule.factor, told.points / MM))
    lines = [f'- [{", ".join(f"{value:.6g}" for value in row)}]' for row in rows.tolist()]
    table = '\n'.join((f'table:  # {", ".join(ROW)}', *lines, ''))
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(file.name + '.part')
    part.write_text(HEAD + yaml.safe_dump(head, sort_keys=False) + table, 'utf-8')
    part.replace(file)


def load_learned(config: LearningConfig, limits: AdviceConfig) -> LayerSchedule | None:
    """Return the schedule that is kept for the next print; None = there is no file yet.

    Raises:
        FileError: it is no such file, or of another ink or nozzle.
    """
    file = Path(config.file)
    if not file.exists():
        return None
    try:
        content = read_yaml(file, MOST_BYTES)
        for name in ('ink', 'nozzle'):
            found = content.get(name) if isinstance(content, dict) else None
            if found != getattr(config, name):
                raise FileError(f'expected {name} {getattr(config, name)!r}, found {found!r}; '
                                'name another file for each ink and nozzle')
        return _schedule(content, limits)
    except FileError as error:
        raise FileError(f'{file}: {error}') from None


def _schedule(content: dict[str, Any], limits: AdviceConfig) -> LayerSchedule:
    try:
        place, factor, *axes = _table(content['table'])
        numbers = {name: float(content[name]) * unit for name, unit in NUMBERS.items()}
        based_on = tuple((str(one['print']), int(one['layer'])) for one in content['based_on'])
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f'expected what bpc writes, found another: {error!r}; throw it away to '
                        'learn anew') from None
    if not (np.isfinite(list(numbers.values())).all() and min(numbers.values()) >= 0
            and numbers['reference_mm2'] > 0):
        raise FileError('expected numbers of 0 or more, found others; throw it away to learn anew')
    if not ((factor >= limits.minimum_scale * (1 - 1e-5))
            & (factor <= limits.maximum_scale * (1 + 1e-5))).all():
        raise FileError(
            f'expected factors from {limits.minimum_scale:g} to {limits.maximum_scale:g}, found '
            f'{factor.min():g} to {factor.max():g}; throw it away to learn anew')
    factor = np.clip(factor, limits.minimum_scale, limits.maximum_scale)
    sigma, level_sigma, reference, advance, retreat = numbers.values()
    return LayerSchedule(
        0, '', 0, ScheduleReason.LEARNED,
        RateSchedule(place * MM, factor, sigma, level_sigma, factor * reference, reference,
                     advance, retreat, len(based_on)),
        np.column_stack(axes) * MM, based_on)


def _table(rows: Any) -> Array:
    """Return the columns (5, K) of a table. Raises ValueError."""
    table = np.array(rows, float)
    if table.ndim != 2 or table.shape[1] != len(ROW) or len(table) < 2:
        raise ValueError(f'a table of {table.shape}')
    if not np.isfinite(table).all() or not (np.diff(table[:, 0]) > 0).all():
        raise ValueError('places that are not in order, or no numbers')
    return table.T
