"""What `bpc measure` refuses before it measures."""

from __future__ import annotations

from pathlib import Path

import pytest

from bpc_perception.cli.measure import measure
from bpc_perception.recording.offline import measure_bag

SAMPLE = Path(__file__).resolve().parents[3] / 'bags' / 'spiral_gaps'


@pytest.mark.parametrize('wanted', [5, 9])
def test_a_capture_that_is_not_there_is_refused_before_the_first_is_measured(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wanted: int) -> None:
    def begin(*_: object) -> None:
        raise AssertionError('it measures')
    monkeypatch.setattr(f'{measure.__module__}.{measure_bag.__name__}', begin)
    with pytest.raises(ValueError, match=rf'found --capture {wanted} of 5; name one of 0 to 4'):
        measure(SAMPLE, tmp_path / 'out', capture=wanted)
    assert not (tmp_path / 'out').exists()
