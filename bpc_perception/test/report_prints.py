"""Two prints for the tests of reports that can be checked by hand: a strand and a vase."""

import math

import numpy as np
from perception_builders import on_one_layer

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.result import Result

MM = 1e-3
NASTY = '</script><script>alert("1")</script>&<b>'  # the name of the strand
START_NS = 1_700_000_000_123_456_789  # of the vase; a float of seconds cannot hold all digits


def strand_result():
    """Twenty samples along x, 2 mm wide, a pixel each millimetre; its third sample is a gap."""
    count = 20
    x = np.arange(count) * MM
    points = np.column_stack((x, np.zeros(count), np.full(count, 0.1)))
    status = np.full(count, Status.MEASURED, np.uint8)
    status[2] = Status.GAP
    measured = np.where(status == Status.MEASURED, 1.0, np.nan)
    camera = PinholeCamera(np.array(((100.0, 0, 5), (0, 100.0, 12), (0, 0, 1))), np.zeros(5),
                           32, 24)
    image = np.zeros((24, 32, 3), np.uint8)
    image[:, :16] = (200, 40, 10)
    return Result(
        Capture(10**9, 'camera', image, np.full((24, 32, 3), np.nan, np.float32), camera),
        np.eye(4),
        ThicknessProfile(
            stamp_ns=10**9, print_id=NASTY, print_start_ns=0, capture=0, method='paper',
            time=x, arc_length=x, points=points, extruding=np.ones(count, bool),
            extruder_known=np.ones(count, bool), stroke=np.ones(count, np.intp), status=status,
            thickness=np.where(status == Status.GAP, 0.0, 2 * MM), sigma=0.1 * MM * measured,
            left=MM * measured, right=MM * measured,
            left_points=(points - (0, MM, 0)) * measured[:, None],
            right_points=(points - (0, -MM, 0)) * measured[:, None],
            **on_one_layer(count), processing_time=0.1),
        RateAdvice(10**9, NASTY, True, Reason.UNDER_EXTRUSION, 2.078 * MM, 2 * MM,
                   (5 * MM, 19 * MM), 14, 1.0795, 0.926, 0.9, 0.5, 6 * 10**9),
        PrintVerdict.none(10**9))


def vase_profile():
    """Four samples 1 mm apart along x: 2 mm, a gap, glare, 4 mm."""
    nan = math.nan
    sides = np.full((4, 3), nan)
    return ThicknessProfile(
        stamp_ns=START_NS + 10 * 10**9, print_id='vase', print_start_ns=START_NS, capture=1,
        method='paper', time=np.array((0.0, 0.5, 1.000000001, 1.5)),
        arc_length=np.arange(4) * MM, points=np.outer(np.arange(4), (MM, 0, 0)),
        extruding=np.ones(4, bool), extruder_known=np.ones(4, bool), stroke=np.ones(4, np.intp),
        status=np.array((Status.MEASURED, Status.GAP, Status.NO_DATA, Status.MEASURED), np.uint8),
        thickness=np.array((2 * MM, 0.0, nan, 4 * MM)), sigma=np.array((0.1 * MM, nan, nan, MM)),
        left=np.array((1.5 * MM, nan, nan, 2.5 * MM)),
        right=np.array((0.5 * MM, nan, nan, 1.5 * MM)),
        left_points=sides, right_points=sides, **on_one_layer(4), processing_time=0.25)
