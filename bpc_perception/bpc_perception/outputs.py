"""What a measurement leaves behind: profile.csv, summary.json and report.html.

People read these files, so lengths are in millimetres here, and nowhere else but in the
report's figures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
import json
import math
import os
from pathlib import Path
import platform
import tempfile
from typing import Any

import cv2
import numpy as np

from bpc_perception import __version__, report
from bpc_perception.core.advice import RateAdvice
from bpc_perception.core.geometry import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.session import Result

MM = 1e3  # [mm/m]
NS = 10**9  # [ns/s]
COLUMNS = ('arc_length_mm', 'time_s', 'x_mm', 'y_mm', 'z_mm', 'thickness_mm', 'sigma_mm',
           'left_mm', 'right_mm', 'status')


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from.

    Attributes:
        bag: the recording, as the user named it.
        hand_eye: file of the hand-eye calibration.
        settings: dotted names and values of the ThicknessConfig.
        versions: see versions().
    """

    bag: str
    hand_eye: str
    settings: dict[str, object]
    versions: dict[str, str]


def versions() -> dict[str, str]:
    """Versions of everything that can change a number."""
    try:
        ros = f'rclpy {metadata.version("rclpy")}'
    except metadata.PackageNotFoundError:
        ros = 'none'
    return {'bpc': __version__, 'python': platform.python_version(), 'numpy': np.__version__,
            'opencv': cv2.__version__, 'ros': ros}


def write_outputs(folder: Path, results: Sequence[Result], provenance: Provenance) -> list[Path]:
    """Write profile.csv, summary.json and report.html of the last measured result.

    A file is either put in place whole or not at all: all three are complete beside their
    place before the first one moves there.

    Args:
        folder: where to; made if missing.
        results: of all captures in order; refused ones are listed in summary and report.
        provenance: where the results come from.

    Raises:
        ValueError: no result was measured.
        OSError: the folder cannot be written to.
    """
    measured = [result for result in results if result.profile is not None]
    if not measured:
        refusals = '; '.join(result.refusal for result in results) or 'no captures'
        raise ValueError(f'expected a measured capture, found none: {refusals}')
    last = measured[-1]
    assert last.profile is not None
    summary = summarize(results, provenance)
    files = {'profile.csv': profile_csv(last.profile),
             'summary.json': json.dumps(summary, indent=2, allow_nan=False) + '\n',
             'report.html': report.render(last, summary)}

    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=folder) as beside:
        for name, text in files.items():
            # A file name need not be valid Unicode; that must not cost the user the result.
            (Path(beside) / name).write_bytes(text.encode('utf-8', 'replace'))
        for name in files:
            os.replace(Path(beside) / name, folder / name)
    return [folder / name for name in files]


def profile_csv(profile: ThicknessProfile) -> str:
    """The profile as a table, one sample a line; an empty cell = unknown.

    Numbers have as many digits as it takes to read the same number back.
    """
    known = np.isin(profile.status, (Status.MEASURED, Status.GAP))
    columns = (
        _cells(profile.arc_length * MM),
        [_seconds(profile.print_start_ns + round(time * NS)) for time in profile.time.tolist()],
        *(_cells(axis * MM) for axis in profile.points.T),
        _cells(np.where(known, profile.thickness, np.nan) * MM),
        *(_cells(values * MM) for values in (profile.sigma, profile.left, profile.right)),
        [Status(value).name for value in profile.status])
    rows = (COLUMNS, *zip(*columns, strict=True))
    return ''.join(','.join(row) + '\n' for row in rows)


def summarize(results: Sequence[Result], provenance: Provenance) -> dict[str, Any]:
    """The content of summary.json: the last measured result, every capture, the provenance."""
    result = next(result for result in reversed(results) if result.profile is not None)
    profile = result.profile
    assert profile is not None
    assert result.advice is not None
    statistics = profile.summary
    content = {
        **_capture(result),
        'method': profile.method,
        'path_length_mm': float(np.ptp(profile.arc_length)) * MM if len(profile) else 0.0,
        'thickness_mean_mm': statistics.thickness_mean * MM,
        'thickness_std_mm': statistics.thickness_std * MM,
        'thickness_q1_mm': statistics.thickness_q1 * MM,
        'thickness_median_mm': statistics.thickness_median * MM,
        'thickness_q3_mm': statistics.thickness_q3 * MM,
        'coverage': statistics.coverage,
        'gap_count': statistics.gap_count,
        'gap_length_mm': statistics.gap_length * MM,
        'gaps': [{'start_mm': start, 'end_mm': end}
                 for start, end in (profile.gaps * MM).tolist()],
        'offset_mean_mm': statistics.offset_mean * MM,
        'offset_rms_mm': statistics.offset_rms * MM,
        'warnings': [result.warning] if result.warning else [],
        'advice': _advice(result.advice),
        'captures': [_capture(result) for result in results],
        'bag': provenance.bag,
        'hand_eye': provenance.hand_eye,
        'settings': provenance.settings,
        'versions': provenance.versions,
    }
    plain = _plain(content)
    assert isinstance(plain, dict)
    return plain


def _capture(result: Result) -> dict[str, object]:
    """What is to be said of one capture; a float of seconds cannot hold all of its stamp."""
    stamp_ns, profile = result.capture.stamp_ns, result.profile
    time = {'time_s': stamp_ns / NS, 'stamp_ns': stamp_ns}
    if profile is None:
        return {'capture': None, **time, 'refusal': result.refusal}
    counts = np.bincount(profile.status, minlength=len(Status))
    return {'print_id': profile.print_id, 'capture': profile.capture, **time,
            'processing_time_s': profile.processing_time, 'samples': len(profile),
            'counts': {status.name: int(counts[status]) for status in Status}}


def _advice(advice: RateAdvice) -> dict[str, object]:
    return {
        'valid': advice.valid,
        'reason': advice.reason.name,
        'flow_rate_scale': advice.flow_rate_scale,
        'speed_scale': advice.speed_scale,
        'target_thickness_mm': advice.target_thickness * MM,
        'measured_thickness_mm': advice.measured_thickness * MM,
        'expected_thickness_mm': advice.expected_thickness * MM,
        'delivery': advice.delivery,
        'delivery_sigma': advice.delivery_sigma,
        'lag_s': advice.lag,
        'window_start_mm': advice.window[0] * MM,
        'window_end_mm': advice.window[1] * MM,
        'sample_count': advice.sample_count,
        'confidence': advice.confidence,
        'measurement_age_s': advice.measurement_age,
        'valid_until_s': advice.valid_until_ns / NS,
        'valid_until_ns': advice.valid_until_ns,
    }


def _cells(values: Array) -> list[str]:
    return ['' if math.isnan(value) else repr(value) for value in values.tolist()]


def _seconds(stamp_ns: int) -> str:
    """Nanoseconds as seconds, to the last digit."""
    whole, rest = divmod(stamp_ns, NS)
    return f'{whole}.{rest:09d}'


def _plain(value: object) -> object:
    """The value in what strict JSON knows: NaN and infinity become None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)
