"""Which recordings a batch finds below a folder, and where their results go."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
import yaml

from bpc_perception.batch.finding import find_bags
from bpc_perception.batch.jobs import find_jobs


def lay(folder: Path, *names: str) -> None:
    """Make files that are named like parts of recordings."""
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(name.encode())


def list_in_metadata(folder: Path, *names: str) -> None:
    """Write a metadata.yaml that lists these files."""
    (folder / 'metadata.yaml').write_text(yaml.safe_dump(
        {'rosbag2_bagfile_information': {'relative_file_paths': list(names)}}))


def found(folder: Path) -> list[str]:
    """The recordings found, by their paths below the folder."""
    return [str(bag.relative_to(folder)) for bag in find_bags(folder)]


def test_recordings_that_lie_in_one_folder_are_one_each(tmp_path: Path) -> None:
    lay(tmp_path, 'week/spiral_0.mcap', 'week/spiral_1.mcap', 'week/line_0.mcap')
    list_in_metadata(tmp_path / 'week', 'spiral_0.mcap', 'spiral_1.mcap')
    assert found(tmp_path) == ['week', 'week/line_0.mcap']
    (tmp_path / 'week' / 'metadata.yaml').write_text('torn: [')
    assert found(tmp_path) == ['week/line_0.mcap', 'week/spiral_0.mcap', 'week/spiral_1.mcap']


def test_files_named_like_their_folder_are_one_recording_if_they_are_its_parts(
        tmp_path: Path) -> None:
    lay(tmp_path, *(f'killed/killed_{number}.mcap' for number in range(12)))
    lay(tmp_path, 'ink/ink_monday.mcap', 'ink/ink_tuesday.mcap', 'run/run_7.mcap',
        'run/run_9.mcap')
    assert found(tmp_path) == ['ink/ink_monday.mcap', 'ink/ink_tuesday.mcap', 'killed',
                               'run/run_7.mcap', 'run/run_9.mcap']


def test_links_are_followed_once(tmp_path: Path) -> None:
    lay(tmp_path, 'far/print/print_0.mcap', 'far/loose.mcap', 'archive/own/own_0.mcap',
        'archive/single.mcap')
    archive = tmp_path / 'archive'
    (archive / 'a_link').symlink_to(archive / 'own')  # beside what it leads to
    (archive / 'also_single.mcap').symlink_to('single.mcap')
    (archive / 'own' / 'round').symlink_to(archive)
    (archive / 'elsewhere').symlink_to(tmp_path / 'far')
    (archive / 'elsewhere_again').symlink_to(tmp_path / 'far' / 'print')
    assert found(archive) == ['elsewhere/loose.mcap', 'elsewhere/print', 'own', 'single.mcap']


def test_a_recording_of_links_to_another_is_that_one(tmp_path: Path) -> None:
    lay(tmp_path, 'b/b_0.mcap')
    (tmp_path / 'a').mkdir()
    (tmp_path / 'a' / 'a_0.mcap').symlink_to(tmp_path / 'b' / 'b_0.mcap')
    (tmp_path / 'c.mcap').symlink_to('nowhere')
    assert found(tmp_path) == ['b', 'c.mcap']  # what is not there is refused by name


def test_a_folder_that_cannot_be_read_is_named(
        tmp_path: Path, caplog: pytest.LogCaptureFixture,
        monkeypatch: pytest.MonkeyPatch) -> None:
    lay(tmp_path, 'mine/mine_0.mcap', 'theirs/theirs_0.mcap')
    real = Path.iterdir

    def refuse(path: Path) -> object:
        if path.name == 'theirs':
            raise PermissionError(13, 'Permission denied')
        return real(path)
    monkeypatch.setattr(Path, 'iterdir', refuse)
    with caplog.at_level(logging.WARNING):
        assert found(tmp_path) == ['mine']
    assert 'theirs: expected a folder to look into, found: Permission denied' in caplog.text


def test_results_of_equal_names_have_folders_of_their_own(tmp_path: Path) -> None:
    lay(tmp_path, 'prints/prints_0.mcap', 'prints/prints/prints_0.mcap',
        'prints/a/a_0.mcap', 'prints/a/print_1/print_1_0.mcap',
        'prints/a/print_1.mcap', 'prints/b/print_1/print_1_0.mcap')
    jobs = find_jobs(tmp_path / 'prints', tmp_path / 'out', None, None)
    outs = [job.out for job in jobs]
    assert len({job.name for job in jobs}) == len(set(outs)) == len(jobs) == 6
    # A result is replaced as a whole: none may lie in the folder of another.
    assert [(out, other) for out in outs for other in outs if out in other.parents] == []


def test_metadata_with_aliases_is_read(tmp_path: Path) -> None:
    """As bpc writes it: what is the same twice is there once."""
    lay(tmp_path, 'b/b_0.mcap', 'b/other.mcap')
    (tmp_path / 'b' / 'metadata.yaml').write_text(
        'rosbag2_bagfile_information:\n  duration: &id001 {nanoseconds: 1}\n'
        '  files: [{duration: *id001}]\n  relative_file_paths: [b_0.mcap]\n')
    assert found(tmp_path) == ['b', 'b/other.mcap']


def test_the_table_does_not_get_beside_the_result_of_a_recording(tmp_path: Path) -> None:
    lay(tmp_path, 'a/a_0.mcap', 'out/summary.json')
    with pytest.raises(ValueError, match='expected a folder without a result right in it'):
        find_jobs(tmp_path / 'a', tmp_path / 'out', None, None)

