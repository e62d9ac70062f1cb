"""Results of prints while they are measured."""

from dataclasses import replace
import json

import numpy as np
import pytest

from bpc_perception.core.path.print_id import print_id_of
from bpc_perception.core.result import Result
from bpc_perception.recording.print_folder import print_folder
from bpc_perception.report import outputs
from bpc_perception.report.live_results import LiveResults, seen

FIRST, SECOND = print_id_of(10**18), print_id_of(10**18 + 60 * 10**9)
NAMES = ['profile.csv', 'report.html', 'summary.json']


@pytest.fixture
def capture_of(capture, profile, advice, verdict):
    """A function that returns profile and result of a capture of a print."""
    def make(print_id, number):
        own = replace(profile, print_id=print_id, capture=number)
        picture = seen(capture.stamp_ns, capture.image, capture.camera)
        return own, Result(picture, np.eye(4), own, replace(advice, print_id=print_id),
                           replace(verdict, print_id=print_id))
    return make


def captures_in(folder):
    return [entry['capture'] for entry in
            json.loads((folder / 'summary.json').read_text('utf-8'))['captures']]


def test_files_grow_with_the_print(tmp_path, capture_of, provenance):
    live = LiveResults(tmp_path)
    for number in range(3):
        live.add(*capture_of(FIRST, number))
        assert live.changed
        live.write(provenance)
        assert not live.changed
        folder = print_folder(tmp_path, FIRST)
        assert sorted(file.name for file in folder.iterdir()) == NAMES
        assert captures_in(folder) == list(range(number + 1))


def test_who_was_killed_goes_on_with_what_was_written(tmp_path, capture_of, provenance):
    for number in range(3):
        killed = LiveResults(tmp_path)
        killed.add(*capture_of(FIRST, number))
        killed.write(provenance)
    folder = print_folder(tmp_path, FIRST)
    assert captures_in(folder) == [0, 1, 2]
    report = (folder / 'report.html').read_text('utf-8')
    assert report.count('image/jpeg') >= 2
    for spoiled in ('{', '[]', '{"print_id": "another", "captures": [1]}'):
        (folder / 'summary.json').write_text(spoiled)
        live = LiveResults(tmp_path)
        live.add(*capture_of(FIRST, 7))
        live.write(provenance)
        assert captures_in(folder) == [7]


def test_another_print_has_another_folder(tmp_path, capture_of, provenance):
    live = LiveResults(tmp_path)
    for print_id, count in ((FIRST, 2), (SECOND, 1)):
        assert live.begins_with(print_id)
        for number in range(count):
            live.add(*capture_of(print_id, number))
        assert not live.begins_with(print_id)
        live.write(provenance)
    assert captures_in(print_folder(tmp_path, FIRST)) == [0, 1]
    assert captures_in(print_folder(tmp_path, SECOND)) == [0]


def test_what_was_written_stays_when_the_disk_is_full(tmp_path, capture_of, provenance,
                                                      monkeypatch):
    live = LiveResults(tmp_path)
    live.add(*capture_of(FIRST, 0))
    live.write(provenance)
    folder = print_folder(tmp_path, FIRST)
    before = {file.name: file.read_bytes() for file in folder.iterdir()}

    def full(*_):
        raise OSError('No space left on device')
    live.add(*capture_of(FIRST, 1))
    monkeypatch.setattr(outputs.Path, 'write_bytes', full)
    with pytest.raises(OSError, match='No space'):
        live.write(provenance)
    assert live.changed
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before


def test_an_image_alone_takes_no_memory_for_its_cloud(capture):
    picture = seen(capture.stamp_ns, capture.image, capture.camera)
    assert picture.cloud.shape == capture.image.shape
    assert picture.cloud.strides == (0, 0, 0)
