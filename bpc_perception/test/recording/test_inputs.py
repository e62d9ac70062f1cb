"""What is read of a recording before it is measured."""

from __future__ import annotations

from pathlib import Path

import pytest

from bpc_perception.recording.bag import Bag
from bpc_perception.recording.inputs import load, PRINT_ID

pytestmark = pytest.mark.ros
STROKES = Path(__file__).parents[3] / 'bags' / 'strokes'


def linked(target: Path) -> Path:
    """A recording there, of the files of the sample."""
    target.mkdir()
    for file in STROKES.iterdir():
        (target / file.name).symlink_to(file)
    return target


def test_the_folder_of_a_print_stands_for_its_recording(tmp_path: Path) -> None:
    recording = linked(tmp_path / 'recording')
    assert load(tmp_path, None, None).print_id == ''
    (recording / PRINT_ID).write_text('20260711T122333.088Z\n')
    given = load(tmp_path, None, None)
    assert [file.parent for file in given.bag.files] == [recording]
    assert given.hand_eye_file == recording / 'hand_eye.calib'
    assert given.print_id == '20260711T122333.088Z'


def test_after_a_crash_it_stands_for_all_of_them_in_their_order(tmp_path: Path) -> None:
    names = ['recording', 'recording_2', 'recording_10']
    for name in reversed(names):
        linked(tmp_path / name)
    bag = load(tmp_path, None, None).bag
    assert [file.parent.name for file in bag.files] == names
    image = '/color/image_color'
    each = Bag(STROKES).count(image)
    assert each is not None
    assert bag.count(image) == 3 * each
