"""The table of a batch, as others read it."""

from __future__ import annotations

import csv
import os
from pathlib import Path

from pyarrow import parquet

from bpc_perception.batch.table import csv_and_parquet, failed, prints_table


def test_no_cell_is_a_formula_and_numbers_stay_numbers(tmp_path: Path) -> None:
    odd = os.fsdecode(b'vase-\xff')
    rows = [failed('=HYPERLINK("http://x")', 2, '@SUM(1+1)'), failed(odd, 2, 'a\x1b[2J'),
            {**failed('a', 0, ''), 'print_id': '-2', 'offset_mean_mm': -0.25}]
    for name, data in csv_and_parquet(prints_table(rows)):
        (tmp_path / name).write_bytes(data)
    with (tmp_path / 'prints.csv').open(encoding='utf-8', newline='') as stream:
        formula, control, fine = csv.DictReader(stream)
    assert (formula['bag'], formula['reason']) == ('\'=HYPERLINK("http://x")', "'@SUM(1+1)")
    assert (control['bag'], control['reason']) == (r'vase-\udcff', r'a\x1b[2J')
    assert (fine['print_id'], fine['offset_mean_mm']) == ('-2', '-0.25')
    stored = parquet.read_table(tmp_path / 'prints.parquet').to_pylist()
    assert [row['bag'] for row in stored] == ['=HYPERLINK("http://x")', 'vase-?', 'a']
