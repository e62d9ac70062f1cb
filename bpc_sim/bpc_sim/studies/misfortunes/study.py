"""Search for input that makes valid advice rise above what the truth of the print allows.

Each print goes through one to three misfortunes, and then through all that a recording goes
through: conversion, clocks, path, measurement and advice.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bpc_perception.messages import topics
from bpc_perception.recording.bag import BagError, BagMessage
from bpc_perception.recording.offline import measure_bag
from bpc_sim.studies.misfortunes.misfortunes import exposed, MISFORTUNES
from bpc_sim.studies.misfortunes.small_print import CONFIG, hand_eye, random_print, RECORDER
from bpc_sim.studies.study_runner import Row, Study

PRINTS_EACH = 50  # of one task, which has one seed
TOLERANCE = 0.1  # by which advice may exceed what the truth allows
NONE = 'none'  # no misfortune, for comparison


@dataclass(frozen=True)
class Trial:
    """What became of a print.

    Attributes:
        number: of the print; it makes the same print again.
        misfortunes: their names.
        results: how many captures were measured.
        valid: how many advices were valid.
        excess: by how much, as a ratio, the largest valid advice is above what the truth allows,
            of flow or of what a slower robot does; -1 = no advice was valid.
    """

    number: int
    misfortunes: tuple[str, ...]
    results: int
    valid: int
    excess: float


class MessagesBag:
    """Messages in memory, to be read like a recording."""

    def __init__(self, messages: list[BagMessage]) -> None:
        self.path = Path('print')
        self.others: dict[str, str] = {}
        self.topics = {entry.topic: topics.type_name(type(entry.message)) for entry in messages}
        self._messages = messages

    def messages(self, wanted: set[str],
                 light: bool = False) -> Iterator[BagMessage]:  # noqa: ARG002 (see Bag)
        """Yield the messages of these topics."""
        return (entry for entry in self._messages if entry.topic in wanted)

    def count(self, topic: str) -> int:
        """Return the number of messages of a topic."""
        return sum(entry.topic == topic for entry in self._messages)


def try_print(number: int) -> Trial:
    """Measure the print of this number."""
    rng = np.random.default_rng(number)
    made = random_print(rng)
    messages = made.messages()
    names = tuple(rng.choice([NONE, *MISFORTUNES], rng.integers(1, 4)).tolist())
    # A camera clips once: what was clipped and darkened afterwards nobody can tell.
    once = [name for place, name in enumerate(names)
            if name != exposed.__name__ or place == names.index(name)]
    for name in once:
        if name != NONE and messages:
            messages = MISFORTUNES[name](messages, rng)
    results, excess = 0, []
    try:
        bag: Any = MessagesBag(messages)
        for result in measure_bag(bag, hand_eye(), CONFIG, RECORDER):
            results += result.profile is not None
            if result.advice is not None and result.advice.valid:
                scale = max(result.advice.flow_rate_scale, 1 / result.advice.speed_scale)
                excess.append(scale / max(made.allowed_scale, 1.0) - 1)
    except BagError:
        pass  # a topic was lost altogether
    return Trial(number, names, results, len(excess), max(excess, default=-1.0))


def work(seed: int) -> list[Trial]:
    """Measure the prints of one seed."""
    return [try_print(seed * PRINTS_EACH + number) for number in range(PRINTS_EACH)]


def rows(found: list[list[Trial]]) -> list[Row]:
    """Return a row for each misfortune, and one of all together."""
    trials = [trial for task in found for trial in task]
    table = [_row(name, [trial for trial in trials if name in trial.misfortunes
                         and (name != NONE or set(trial.misfortunes) == {NONE})])
             for name in (NONE, *MISFORTUNES)]
    return [*table, _row('all', trials)]


def _row(name: str, trials: list[Trial]) -> Row:
    above = [trial for trial in trials if trial.excess > TOLERANCE]
    return {'misfortune': name, 'prints': len(trials),
            'measured': sum(trial.results for trial in trials),
            'valid': sum(trial.valid for trial in trials),
            'largest_excess': max((trial.excess for trial in trials), default=-1.0),
            'above_tolerance': len(above),
            'worst_print': max(trials, key=lambda trial: trial.excess).number if trials else -1}


MISFORTUNE_SEARCH = Study('Advice on prints whose messages were spoiled', range, work, rows,
                          seeds=4, processes=2)
