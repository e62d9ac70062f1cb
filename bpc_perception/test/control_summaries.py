"""Summaries of prints for the tests of control charts, by hand."""

from typing import Any

SETTINGS = {
    'method': 'cross_section', 'advice.target_thickness': 0.002, 'advice.target_file': '',
    'tolerance.width': 0.15, 'tolerance.target_height': 0.0, 'tolerance.height': 0.25,
    'path_recorder.nozzle_offset': [0.0, 0.0, 0.15], 'watch.warn_after': 0.2}
HOUR_NS = 3_600_000_000_000


def summary_of(hour: int, width: float | None, height: float | None = None,
               verdict: str = 'PASS', **settings: object) -> dict[str, Any]:
    """A print at an hour since 1970, of a mean width and height [mm]."""
    return {'print_id': f'p{hour}', 'stamp_ns': hour * HOUR_NS, 'thickness_mean_mm': width,
            'ink': {'height_mean_mm': height}, 'verdict': {'verdict': verdict},
            'settings': SETTINGS | settings,
            'camera': {'width_px': 304, 'height_px': 228, 'focal_length_px': 400.0}}
