"""What is kept of a print: one capture in full, an entry of each."""

from dataclasses import replace
import weakref

import numpy as np

from bpc_perception.core.result import Result
from bpc_perception.report.print_log import PrintLog


def test_a_log_keeps_one_capture(results, capture):
    log = PrintLog(expected=3)
    for result in results:
        log.add(result)
    assert log.reported is results[1]
    captures = [weakref.ref(result.capture) for result in results]
    del results[:], result, capture
    # pytest holds what fixtures returned, but not what they made on the way.
    assert [kept() is not None for kept in captures] == [False, True, False]


def test_a_log_reports_the_capture_wanted(results, profile, advice, capture):
    later = Result(capture, np.eye(4), replace(profile, capture=2), advice)
    log = PrintLog(wanted=1)
    for result in (*results, later):
        log.add(result)
    assert log.reported is results[1]
    assert log.place == 1
    assert log.numbers == [1, 2]
    assert log.refusals == ['path: none started', 'no deposit']
