"""What prints taught, there and back in its file, and which files are not used."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.config import AdviceConfig, LearningConfig, ThicknessConfig
from bpc_perception.core.learning.layer_schedule import LayerSchedule, ScheduleReason
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_perception.files.learned_file import load_learned, save_learned
from bpc_perception.files.yaml_file import FileError
from bpc_perception.nodes.parts.kept_learning import KeptLearning

LIMITS = AdviceConfig()
TOLD = LayerSchedule(
    17, '', 0, ScheduleReason.LEARNED,
    RateSchedule(np.array((0.0, 5e-4, 1e-3)), np.array((1.2, 0.9, 1.0)), 0.03, 0.01,
                 np.array((1.2, 0.9, 1.0)) * 1e-6, 1e-6, 0.2, 0.1, 2),
    np.array(((0.1, 0, 0.01), (0.1005, 0, 0.01), (0.101, 0, 0.01))), (('one', 0), ('two', 0)))


@pytest.fixture
def config(tmp_path: Path) -> LearningConfig:
    """The settings of prints of which something is kept."""
    config = LearningConfig(file=str(tmp_path / 'learned' / 'way.yaml'), ink='seven',
                            nozzle='22G')
    save_learned(Path(config.file), TOLD, config)
    return config


def test_it_survives_there_and_back(config: LearningConfig) -> None:
    back = load_learned(config, LIMITS)
    assert back is not None
    assert back.schedule is not None
    assert TOLD.schedule is not None
    assert (back.print_id, back.layer, back.based_on) == ('', 0, TOLD.based_on)
    np.testing.assert_allclose(back.points, TOLD.points, atol=1e-8)
    for name in vars(TOLD.schedule):
        np.testing.assert_allclose(getattr(back.schedule, name), getattr(TOLD.schedule, name),
                                   rtol=1e-5)


def test_a_user_can_read_it(config: LearningConfig) -> None:
    text = Path(config.file).read_text()
    for words in ('ink: seven', 'nozzle: 22G', 'reference_mm2: 1.0', '- print: two',
                  'table:  # place_mm, factor, x_mm, y_mm, z_mm',
                  '- [0.5, 0.9, 100.5, 0, 10]'):
        assert words in text


def test_the_newer_takes_the_place_of_the_older_whole(config: LearningConfig) -> None:
    assert TOLD.schedule is not None
    save_learned(Path(config.file), replace(TOLD, schedule=replace(
        TOLD.schedule, advance=0.4)), config)
    back = load_learned(config, LIMITS)
    assert back is not None
    assert back.schedule is not None
    assert back.schedule.advance == pytest.approx(0.4)
    assert [file.name for file in Path(config.file).parent.iterdir()] == ['way.yaml']


def test_without_a_file_nothing_is_kept_yet(tmp_path: Path) -> None:
    assert load_learned(LearningConfig(file=str(tmp_path / 'no.yaml'), ink='a', nozzle='b'),
                        LIMITS) is None


@pytest.mark.parametrize(('name', 'words'), [
    ('ink', "expected ink 'other', found 'seven'"),
    ('nozzle', "expected nozzle 'other', found '22G'")])
def test_of_another_ink_or_nozzle_it_is_not_used(config: LearningConfig, name: str,
                                                 words: str) -> None:
    with pytest.raises(FileError, match=f'{words}; name another file'):
        load_learned(replace(config, **{name: 'other'}), LIMITS)


@pytest.mark.parametrize(('before', 'after', 'words'), [
    ('- [0.5, 0.9,', '- [0.5, 9.0,', 'found 1 to 9'), ('- [0.5, 0.9,', '- [0.5, -0.9,', 'factors'),
    ('- [0.5, 0.9,', '- [0.5, .nan,', 'bpc writes'), ('- [0.5, 0.9,', '- [0.5,', 'bpc writes'),
    ('- [0.5, 0.9,', '- [7, 0.9,', 'not in order'), ('- [0.5, 0.9,', '- [a, 0.9,', 'bpc writes'),
    ('advance_s: 0.2', 'advance_s: -0.2', 'numbers of 0 or more'),
    ('advance_s: 0.2', 'advance_s: .inf', 'numbers of 0 or more'),
    ('advance_s: 0.2', 'advance_s: soon', 'bpc writes'), ('advance_s: 0.2\n', '', 'bpc writes'),
    ('reference_mm2: 1.0', 'reference_mm2: 0', 'numbers of 0 or more'),
    ('based_on:', 'based_off:', 'bpc writes'), ('ink: seven', 'ink: [', 'readable YAML'),
    ('ink: seven', '', 'found None'), ('layer: 0', 'layer: x', 'bpc writes')])
def test_a_spoiled_file_is_refused_in_one_line_with_what_to_do(
        config: LearningConfig, before: str, after: str, words: str) -> None:
    file = Path(config.file)
    text = file.read_text()
    assert before in text
    file.write_text(text.replace(before, after))
    with pytest.raises(FileError, match=words) as refused:
        load_learned(config, LIMITS)
    said = str(refused.value)
    assert said.startswith(f'{file}: expected ')
    assert ';' in said or 'correct it' in said
    assert '\n' not in said


@pytest.mark.parametrize('text', ['', '7', '[]', 'a: b', '\0', '%'])
def test_what_is_no_such_file_is_refused(config: LearningConfig, text: str) -> None:
    Path(config.file).write_text(text)
    with pytest.raises(FileError, match='expected'):
        load_learned(config, LIMITS)


def test_a_file_needs_the_names_of_ink_and_nozzle(config: LearningConfig) -> None:
    nameless = ThicknessConfig(learning=replace(config, nozzle=''))
    said: list[str] = []
    assert KeptLearning(nameless, said.append).told is None
    assert len(said) == 1
    assert 'expected learning.ink and learning.nozzle' in said[0]
