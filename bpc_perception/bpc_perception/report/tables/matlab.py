"""Tables as variables of a MAT-file (version 5), for MATLAB, Octave and scipy.io.loadmat."""

from __future__ import annotations

from collections.abc import Sequence
import io
import re

import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from bpc_perception.report.tables.table import Column, Table

LONGEST_NAME = 63  # letters [MATLAB, namelengthmax]
MOST_BYTES = 2**31 - 1  # of a variable in a file of version 5 [MATLAB, MAT-file versions]


def mat_file(tables: Sequence[Table]) -> bytes:
    """Return a file with a struct for each table, whose fields are columns (N, 1).

    Numbers are double, and NaN where they are not known; texts are in a cell array. With
    ``struct2table(prints)`` MATLAB makes a table of it.

    Raises ValueError if a table is larger than a variable can be.
    """
    variables = {}
    for table in tables:
        if 8 * len(table.rows) * len(table.columns) > MOST_BYTES:
            raise ValueError(f'{table.name}: expected a table of less than 2 GB for MATLAB, found '
                             f'{len(table.rows)} rows; leave out --mat')
        variables[matlab_name(table.name)] = {
            matlab_name(column.name): _values(table, column) for column in table.columns}
    stream = io.BytesIO()
    savemat(stream, variables, long_field_names=True, do_compression=True, oned_as='column')
    return stream.getvalue()


def matlab_name(name: str) -> str:
    """Return a name for MATLAB: letters, digits and underscores, a letter first, 63 at most."""
    plain = re.sub(r'[^0-9A-Za-z_]', '_', name)
    return (plain if re.match('[A-Za-z]', plain) else f'x{plain}')[:LONGEST_NAME]


def _values(table: Table, column: Column) -> NDArray[np.generic]:
    """Return the values (N, 1) of a column."""
    values = [row[column.name] for row in table.rows]
    if column.kind is str:
        texts = np.empty((len(values), 1), object)
        # A file name need not be valid Unicode.
        texts[:, 0] = ['' if value is None else value.encode('utf-8', 'replace').decode()
                       for value in values]
        return texts
    return np.array([np.nan if value is None else value for value in values], float)[:, None]
