"""Whatever is in a file: a design, or a refusal that says what to do."""

from __future__ import annotations

from pathlib import Path
import random

from hypothesis import given, settings, strategies as st
import pytest

from bpc_perception.core.design.design import Design, DesignError
from bpc_perception.files.design import laid_ink, read
from bpc_perception.files.design.path_table import design_from_table
from bpc_perception.files.design.read import design_from_g_code, read_design

SAMPLES = sorted((Path(__file__).parent / 'samples').iterdir())
LETTERS = 'GMTNXYZEIJRFPKOS0123456789.-+*;()%\n /\x00é_"'


def tried(text: str) -> None:
    """Expect a design or a refusal, as a table as well."""
    for kind in (design_from_g_code, design_from_table,
                 lambda text: design_from_g_code(text, ('G1',), ('G0',))):
        try:
            said = ''
            assert isinstance(kind(text), Design)
        except DesignError as error:
            said = str(error)
        assert not said or '; ' in said


@settings(max_examples=300)
@given(st.text(LETTERS, max_size=200))
def test_letters_of_g_code(text: str) -> None:
    tried('M83\nG0 X0 Y0 Z0\n' + text)


@settings(max_examples=100)
@given(st.text(max_size=300))
def test_any_text(text: str) -> None:
    tried(text)
    tried('x_mm,y_mm,z_mm,stroke\n' + text)


@pytest.mark.parametrize('file', SAMPLES, ids=lambda file: file.name)
def test_samples_that_are_cut_or_damaged(file: Path) -> None:
    text = file.read_text('utf-8')
    rng = random.Random(file.name)
    for _ in range(40):
        tried(text[:rng.randrange(len(text))])
        damaged = list(text)
        for _ in range(rng.randrange(1, 6)):
            damaged[rng.randrange(len(damaged))] = rng.choice(LETTERS)
        tried(''.join(damaged))


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    rng = random.Random(1)
    for number in range(20):
        file = tmp_path / f'{number}.gcode'
        file.write_bytes(rng.randbytes(3000))
        with pytest.raises(DesignError, match=rf'{number}\.gcode: '):
            read_design(file)


def test_too_many_chords_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(laid_ink, 'MOST_POINTS', 10_000)
    text = 'M83\nG0 X9000 Y0 Z0\n' + 100 * 'G2 I-9000 E1\n'
    with pytest.raises(DesignError, match=r'line \d+: expected a design of up to 10000 points, '
                                          'found more; is it the right file'):
        design_from_g_code(text)


def test_a_huge_arc_is_refused() -> None:
    with pytest.raises(DesignError, match='line 3: expected a radius up to 10000 mm, found 1000000'
                                          ' mm; write it as a line'):
        design_from_g_code('M83\nG0 X0 Y0 Z0\nG2 X0 Y0 I-1000000 E1\n')


def test_a_huge_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(read, 'LARGEST_BYTES', 100)
    file = tmp_path / 'design.gcode'
    file.write_text(101 * ' ')
    with pytest.raises(DesignError, match='expected at most 100 bytes, found more; is it'):
        read_design(file)


@pytest.mark.parametrize(('name', 'content', 'message'), [
    ('design.stl', b'solid', r'expected a design that ends in .*found \.stl; rename'),
    ('design', b'', 'found none of them; rename'),
    ('design.gcode', b'GCDE\x01', 'expected text, found a packed file; export'),
    ('design.gcode', b'PK\x03\x04', 'expected text, found a packed file; export')])
def test_other_files_are_refused(name: str, content: bytes, message: str, tmp_path: Path) -> None:
    file = tmp_path / name
    file.write_bytes(content)
    with pytest.raises(DesignError, match=f'{name}: .*{message}'):
        read_design(file)


def test_no_file_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path / 'none.gcode', tmp_path / 'zero\0.gcode', tmp_path / 'folder.csv'):
        if path.name == 'folder.csv':
            path.mkdir()
        with pytest.raises(DesignError, match=r'expected a readable design, found: .*; name'):
            read_design(path)
