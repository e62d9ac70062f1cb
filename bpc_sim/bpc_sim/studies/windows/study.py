"""Whether the recommended setting meets its target, for inks of known law."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np

from bpc_sim.studies.study_runner import Row, Study
from bpc_sim.studies.windows.outcome import Outcome

CLOSE = 0.03  # of the target
FIRST_SEED = 3000  # nothing was chosen by looking at these inks


def tasks(seeds: int) -> list[int]:
    """Return the seeds of the inks. Raises ValueError without what fits the laws."""
    if find_spec('statsmodels') is None:
        raise ValueError('study windows: expected the package statsmodels, found none; install '
                         'it, as with pip')
    return list(range(FIRST_SEED, FIRST_SEED + seeds))


def work(seed: int) -> list[Outcome]:
    """Print, measure and judge the sweep of an ink; of some, through the camera as well."""
    # Imported late: statsmodels is an extra.
    from bpc_sim.studies.windows.trial import try_ink

    return try_ink(seed)


def rows(found: list[list[Outcome]]) -> list[Row]:
    """Return a row for each way of driving, one for both, and one through the camera."""
    every = [each for task in found for each in task]
    drawn = [each for each in every if each.by != 'camera']
    groups = {by: [each for each in every if each.by == by] for by in ('flow', 'pressure')}
    groups |= {'both': drawn, 'camera': [each for each in every if each.by == 'camera']}
    return [_row(by, group) for by, group in groups.items() if group]


def _row(by: str, group: list[Outcome]) -> Row:
    told = [each for each in group if not each.refusal]
    error = np.array([abs(each.error) for each in told])

    def percent(name: str) -> float:
        values = np.array([getattr(each, name) for each in told], dtype=float)
        known = values[np.isfinite(values)]
        return 100 * float(known.mean()) if len(known) else np.nan

    return {'by': by, 'inks': len(group), 'refused': len(group) - len(told),
            'within_3_percent': int(np.sum(error <= CLOSE)),
            'mean_error_percent': 100 * float(error.mean()) if told else np.nan,
            'worst_percent': 100 * float(error.max(initial=0.0)),
            'mean_covered_percent': percent('mean_covered'),
            'lines_covered_percent': percent('lines_covered'),
            'chance_percent': percent('chance'), 'lines_within_percent': percent('within'),
            'in_window_percent': percent('in_window'), 'broken_percent': percent('broken')}


WINDOWS = Study('Recommended settings of inks of known law', tasks, work, rows, seeds=100,
                processes=2)
