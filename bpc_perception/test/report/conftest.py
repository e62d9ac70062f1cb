"""Results to report, see report_prints."""

from dataclasses import replace
import math

import numpy as np
import pytest
from report_prints import START_NS, strand_result, vase_profile

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.inspection.defects import Defect, DefectKind
from bpc_perception.core.inspection.verdict import PartVerdict, PrintVerdict, Verdict
from bpc_perception.core.result import Result
from bpc_perception.core.targets import WidthTargets
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import Provenance

MM = 1e-3


@pytest.fixture
def result():
    """A strand with a gap."""
    return strand_result()


@pytest.fixture
def profile():
    """A vase of four samples."""
    return vase_profile()


@pytest.fixture
def advice(profile):
    return RateAdvice(
        stamp_ns=profile.stamp_ns, print_id='vase', valid=True, reason=Reason.OVER_EXTRUSION,
        target_thickness=2.5 * MM, measured_thickness=3 * MM, window=(0.0, 3 * MM),
        sample_count=2, flow_rate_scale=0.7, speed_scale=1.4, confidence=0.5,
        measurement_age=8.5, valid_until_ns=profile.stamp_ns + 5 * 10**9,
        expected_thickness=2.75 * MM, delivery=1.2, delivery_sigma=0.1, lag=0.5,
        flow_rate=0.7 * 5e-9, speed=1.4 * 3 * MM)


@pytest.fixture
def capture(profile):
    """4 x 3 pixels of grey."""
    camera = PinholeCamera(np.array(((4.0, 0, 1.5), (0, 4.0, 1), (0, 0, 1))), np.zeros(5), 4, 3)
    return Capture(profile.stamp_ns, 'camera', np.full((3, 4, 3), 128, np.uint8),
                   np.full((3, 4, 3), np.nan, np.float32), camera)


@pytest.fixture
def verdict(profile):
    """One stroke with one gap."""
    return PrintVerdict(
        profile.stamp_ns, 'vase', False, False, Verdict.FAIL,
        (PartVerdict(1, 0, Verdict.FAIL, 0.75),), (PartVerdict(0, 0, Verdict.FAIL, 0.75),),
        (Defect(DefectKind.GAP, 1, 0, 0.5 * MM, 1.5 * MM, 1 * MM, 0.8 * MM, 1,
                (1 * MM, 0.0, 0.0)),),
        frozenset((DefectKind.GAP, DefectKind.OOZE)), 0.8)


@pytest.fixture
def results(capture, profile, advice, verdict):
    """A capture too early, one measured, one refused."""
    return [Result(replace(capture, stamp_ns=START_NS - 1), refusal='path: none started'),
            Result(capture, np.eye(4), profile, advice, verdict),
            Result(replace(capture, stamp_ns=START_NS + 11 * 10**9), refusal='no deposit')]


@pytest.fixture
def log(results):
    return PrintLog.of(results)


@pytest.fixture
def provenance():
    return Provenance('prints/vase.mcap', 'cell.calib', {
        'method': 'paper', 'advice.dead_band': 0.03, 'offset': (0.0, math.nan)},
        {'bpc': '0.1.0'}, WidthTargets.constant(2.5 * MM), 'abc')
