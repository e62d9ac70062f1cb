"""Which programs tables can be written for, and files of others that must not be lost."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from importlib.util import find_spec
from pathlib import Path
import re
import zipfile

from bpc_perception.report.tables.table import legend, Table

XLSX, MAT = 'xlsx', 'mat'


def table_files(name: str, tables: Sequence[Table], formats: Collection[str]) -> dict[str, bytes]:
    """Return the contents of files by their names: the tables and their legend in each format."""
    files = {}
    shown = (*tables, legend(tables))
    if XLSX in formats:
        # Imported late: openpyxl is an extra.
        from bpc_perception.report.tables.workbook import workbook

        files[f'{name}.{XLSX}'] = workbook(shown)
    if MAT in formats:
        from bpc_perception.report.tables.matlab import mat_file

        files[f'{name}.{MAT}'] = mat_file(shown)
    return files


def chosen_formats(xlsx: bool, mat: bool) -> tuple[str, ...]:
    """Return the formats that are asked for. Raises ValueError if a package for one is missing."""
    if xlsx and find_spec('openpyxl') is None:
        raise ValueError('--xlsx: expected the package openpyxl, found none'
                         '; install it, as with pip, or leave out --xlsx')
    return tuple(name for name, wanted in ((XLSX, xlsx), (MAT, mat)) if wanted)


def expect_no_others(place: Path, formats: Collection[str]) -> None:
    """Raise ValueError if a file to be written is there, and not as bpc left it.

    Args:
        place: path of the files, but for the ends of their names.
        formats: these ends.
    """
    for suffix in formats:
        file = place.with_name(f'{place.name}.{suffix}')
        if file.exists() and not is_ours(file):
            raise ValueError(f'{file}: expected no file but one that bpc wrote, found another, or '
                             'one that was changed; move it, or name another place with --out')


def is_ours(file: Path) -> bool:
    """Return whether bpc wrote a workbook or MAT-file, and no other program changed it since."""
    # Imported late: only who looks at such a file needs it.
    from scipy.io import whosmat
    from scipy.io.matlab import MatReadError

    try:
        if file.suffix == f'.{MAT}':
            return 'legend' in {name for name, *_ in whosmat(file)}
        with zipfile.ZipFile(file) as archive:
            about = archive.read('docProps/core.xml').decode()
    except (OSError, LookupError, ValueError, TypeError, NotImplementedError, MatReadError,
            zipfile.BadZipFile):
        return False
    # Programs for spreadsheets put down who changed a workbook.
    return bool(re.search('<dc:creator>bpc</dc:creator>', about)) and (
        'lastModifiedBy' not in about)
