"""The table of a batch, as others read it."""

from __future__ import annotations

import csv
import os
from pathlib import Path

from pyarrow import parquet

from bpc_perception.batch.table import failed, SCHEMA, write_table


def test_no_cell_is_a_formula_and_numbers_stay_numbers(tmp_path: Path) -> None:
    odd = os.fsdecode(b'vase-\xff')
    rows = [failed('=HYPERLINK("http://x")', 2, '@SUM(1+1)'), failed(odd, 2, 'a\x1b[2J'),
            {**dict.fromkeys(SCHEMA.names), 'bag': 'a', 'exit_status': 0, 'print_id': '-2',
             'offset_mean_mm': -0.25}]
    _, table = write_table(tmp_path, rows)
    with (tmp_path / 'prints.csv').open(encoding='utf-8', newline='') as stream:
        formula, control, fine = csv.DictReader(stream)
    assert (formula['bag'], formula['reason']) == ('\'=HYPERLINK("http://x")', "'@SUM(1+1)")
    assert (control['bag'], control['reason']) == (r'vase-\udcff', r'a\x1b[2J')
    assert (fine['print_id'], fine['offset_mean_mm']) == ('-2', '-0.25')
    stored = parquet.read_table(table).to_pylist()
    assert [row['bag'] for row in stored] == ['=HYPERLINK("http://x")', 'vase-?', 'a']
