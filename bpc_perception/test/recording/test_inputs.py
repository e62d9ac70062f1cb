"""What is read of a recording before it is measured."""

from __future__ import annotations

from pathlib import Path

import pytest

from bpc_perception.recording.bag import Bag
from bpc_perception.recording.inputs import kept_beside, load, PRINT_ID

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


@pytest.mark.parametrize('name', ['vase.csv', 'vase.gcode', 'vase.NC'])
def test_a_design_is_kept_with_a_recording_and_read_from_there(tmp_path: Path, name: str) -> None:
    """The user's file may have been moved or changed since; another one may be told."""
    design, told = tmp_path / name, tmp_path / 'cell.yaml'
    design.write_text('as it was')
    told.write_text('thickness:\n  ros__parameters:\n'
                    f"    design: {{file: '{design}', ink_on: M42 P32 S255}}\n")
    recording = linked(tmp_path / 'recording')
    (recording / 'params.yaml').unlink()
    for file, content in kept_beside('', str(told)).items():
        (recording / file).write_bytes(content)
    design.write_text('changed since')
    found = load(recording, None, None).thickness.design
    assert Path(found.file).read_text() == 'as it was'
    assert (Path(found.file).parent, found.ink_on) == (recording, 'M42 P32 S255')
    assert load(recording, None, told).thickness.design.file == str(design)
    another = tmp_path / 'another.csv'
    another.write_text('another')
    kept = kept_beside('', str(told), str(another))
    assert kept['design.csv'] == b'another'
