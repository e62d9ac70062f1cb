"""What prints were set up with, kept on disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.advice.setup import Setup
from bpc_perception.files.setup_file import load_setup, LONGEST_KEPT_NS, save_setup

NOW_NS = 1_800_000_000 * 10**9


def test_it_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    file, setup = tmp_path / 'new' / 'setup.json', Setup(float(np.pi), -0.1)
    save_setup(file, setup, NOW_NS)
    assert load_setup(file, NOW_NS) == setup
    assert load_setup(file, NOW_NS + LONGEST_KEPT_NS) == setup
    assert [path.name for path in file.parent.iterdir()] == ['setup.json']


@pytest.mark.parametrize('age_ns', [-1, LONGEST_KEPT_NS + 1])
def test_what_is_too_old_or_of_the_future_is_forgotten(tmp_path: Path, age_ns: int) -> None:
    file = tmp_path / 'setup.json'
    save_setup(file, Setup(1.0), NOW_NS)
    assert np.isnan(load_setup(file, NOW_NS + age_ns).gain)


@pytest.mark.parametrize('content', ['', 'no', '[]', '{"gain": 1}', '{"stamp_ns": "then"}'])
def test_a_spoilt_file_is_none(tmp_path: Path, content: str) -> None:
    file = tmp_path / 'setup.json'
    file.write_text(content)
    assert np.isnan(load_setup(file, NOW_NS).gain)


def test_no_file_is_none(tmp_path: Path) -> None:
    assert np.isnan(load_setup(tmp_path / 'setup.json', NOW_NS).gain)
