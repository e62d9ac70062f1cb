"""Tables of studies and benchmarks."""

from __future__ import annotations

import pytest

from bpc_perception.cli.parts.terminal import Terminal
from bpc_sim.cli.parts.rows import table


def test_a_table_is_rather_too_wide_than_cut_short(monkeypatch: pytest.MonkeyPatch,
                                                   capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv('COLUMNS', '40')
    rows = [{f'number_{name}': 0.1 + number for name in 'abcdefgh'} for number in range(9)]
    Terminal().show(table('nine', rows))
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines if '.100' in line] == [
        [f'{number}.100'] * 8 for number in range(9)]
    assert any(line.split() == list('abcdefgh') for line in lines)  # below "number"
