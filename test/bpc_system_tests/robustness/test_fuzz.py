"""Some hundreds of spoiled inputs for each target; the script ``fuzz.py`` tries a million."""

from __future__ import annotations

from collections import Counter
import logging
import random

import pytest

from bpc_system_tests.robustness.fuzz import execute, input_of, spoil
from bpc_system_tests.robustness.fuzz_targets.target import Target
from bpc_system_tests.robustness.fuzz_targets.targets import targets

NAMES = ('bag', 'sqlite bag', 'calibration', 'parameters', 'targets', 'g-code', 'design table',
         'extruder line', 'tic', 'messages', 'captures')
EXECUTIONS = 800


@pytest.fixture(scope='module')
def every_target(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Target]:
    """All targets by name."""
    return targets(tmp_path_factory.mktemp('fuzz'))


@pytest.mark.parametrize('name', NAMES)
def test_spoiled_input_is_refused_as_documented(every_target: dict[str, Target], name: str,
                                                caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.CRITICAL)
    target = every_target[name]
    for data in target.seeds:
        assert execute(target, data)
    outcomes = Counter(execute(target, input_of(target, 1, number))
                       for number in range(max(EXECUTIONS // target.cost, 20)))
    # Otherwise the inputs would not be spoiled at all, or beyond recognition.
    if target.refused:
        assert outcomes[True] > 0
        assert outcomes[False] > 0


def test_nothing_is_left_out(every_target: dict[str, Target]) -> None:
    assert set(every_target) == set(NAMES)


def test_an_input_of_a_number_is_always_the_same() -> None:
    target = Target([b'some words', b'and others'], len, ())
    inputs = [input_of(target, 7, number) for number in range(50)]
    assert inputs == [input_of(target, 7, number) for number in range(50)]
    assert len(set(inputs)) > 40
    assert inputs != [input_of(target, 8, number) for number in range(50)]
    assert spoil([b''], True, random.Random(1)) is not None
