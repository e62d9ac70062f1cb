"""Makes the CMake exports of the message wheels name this environment's Python.

The exports name the Python of the machine that built the wheels. A package that depends on them
would not find Python.h and NumPy's headers.
"""

from pathlib import Path
import re

BUILDERS_PYTHON = r'/opt/(?:python/cp\d+-cp\d+|_internal/[^/";]+)'
PYTHON_INCLUDE = re.compile(BUILDERS_PYTHON + r'/include/python\d\.\d+')
NUMPY_INCLUDE = re.compile(
    BUILDERS_PYTHON + r'/lib/python\d\.\d+/site-packages/numpy/(?:_core|core)/include'
)


def repaired(text: str, python_include: str, numpy_include: str) -> str:
    """Return a CMake export with the builder's include folders replaced."""
    text = NUMPY_INCLUDE.sub(lambda _: numpy_include, text)
    return PYTHON_INCLUDE.sub(lambda _: python_include, text)


def repair_exports(prefix: Path, python_include: str, numpy_include: str) -> int:
    """Repair all exports below a prefix; return how many files changed."""
    changed = 0
    for export in sorted(prefix.glob('share/*/cmake/*.cmake')):
        before = export.read_text()
        after = repaired(before, python_include, numpy_include)
        if after != before:
            export.unlink()  # it may be a link into the cache of the installer
            export.write_text(after)
            changed += 1
    return changed
