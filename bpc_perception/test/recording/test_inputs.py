"""What is read of a recording before it is measured."""

from __future__ import annotations

from pathlib import Path

import pytest

from bpc_perception.recording.inputs import load, PRINT_ID

pytestmark = pytest.mark.ros
STROKES = Path(__file__).parents[3] / 'bags' / 'strokes'


def test_the_folder_of_a_print_stands_for_its_recording(tmp_path: Path) -> None:
    recording = tmp_path / 'recording'
    recording.mkdir()
    for file in STROKES.iterdir():
        (recording / file.name).symlink_to(file)
    assert load(tmp_path, None, None).print_id == ''
    (recording / PRINT_ID).write_text('20260711T122333.088Z\n')
    given = load(tmp_path, None, None)
    assert given.bag.path == recording
    assert given.print_id == '20260711T122333.088Z'
    (tmp_path / 'recording_2').mkdir()
    with pytest.raises(ValueError, match='expected one recording, found recording and '
                                         'recording_2; name one'):
        load(tmp_path, None, None)
