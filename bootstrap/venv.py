"""Makes the virtual environment: the locked packages, and CMake exports that fit this machine."""

from dataclasses import dataclass
import importlib.util
import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig

from bootstrap import cmake_repair, path_order, places, stamps
from bootstrap.installing import lock, packages
from bootstrap.installing.packages import Packages
from bootstrap.progress import note, run_logged, SetupError

NEEDED_SPACE_BYTES = 2.0e9  # for the environment, the build, and what is downloaded meanwhile

# Files of requirements whose packages are installed at first; see installing/extras.py for others.
AT_FIRST = ('requirements.in', 'stock.in', 'run.in', 'build.in')


@dataclass(frozen=True)
class Venv:
    """A virtual environment of a checkout.

    Attributes:
        root: the checkout
        rclpy: the rclpy of a sourced stock Jazzy; None: ROS is installed as wheels
        path: folder of the environment
    """

    root: Path
    rclpy: Path | None
    path: Path

    @property
    def python(self) -> Path:
        """Interpreter of the environment."""
        return self.path / 'bin' / 'python'

    @property
    def lock(self) -> Path:
        """Lock file with the packages of the environment.

        There are two: stock Jazzy's message modules are compiled against NumPy 1.26 and cannot be
        imported with NumPy 2, which the other lock has. And pip must not decide which of apt's
        packages are good enough.
        """
        name = 'requirements.lock' if self.rclpy is None else 'stock.lock'
        return self.root / 'bootstrap' / name

    def stamp(self, version: str) -> str:
        """Return the stamp of the complete environment for a Python version."""
        ros = self.rclpy or 'wheels'
        return f'python {version}\nlock {stamps.file_hash(self.lock)}\nros {ros}\nat {self.path}\n'

    def is_current(self) -> bool:
        """Tell whether the environment is complete and as it would be made now.

        It may have another Python version, unless the user asks for one.
        """
        found = places.stamp_of(self.path)
        version = found.partition('\n')[0].removeprefix('python ')
        if os.environ.get('BPC_PYTHON') and version != own_version():
            return False
        return found == self.stamp(version) and self.python.exists()


def find(root: Path, rclpy: Path | None) -> Venv | None:
    """Return an environment that is current, rather that of the last start than others."""
    found = (Venv(root, rclpy, place) for place in places.existing(root))
    return next((made for made in found if made.is_current()), None)


def own_version() -> str:
    """Return the version of this interpreter, as in `python3.12`."""
    return f'{sys.version_info.major}.{sys.version_info.minor}'


def base_python() -> str:
    """Return this interpreter outside any virtual environment.

    The virtual environment may be the one that is going to be replaced.
    """
    return getattr(sys, '_base_executable', None) or sys.executable


def check_prerequisites(root: Path) -> None:
    """Raise SetupError for anything that would fail minutes later."""
    version = own_version()
    for module in ('venv', 'ensurepip'):
        if importlib.util.find_spec(module) is None:
            raise SetupError(
                f"needs the Python module '{module}', found {base_python()} without it; "
                f'on Debian and Ubuntu: apt install python{version}-venv'
            )
    check_compiler()
    header = Path(sysconfig.get_path('include')) / 'Python.h'
    if not header.exists():
        raise SetupError(
            f'needs the headers of Python {version}, found no {header}; '
            f'on Debian and Ubuntu: apt install python{version}-dev'
        )
    places.check_space(root, NEEDED_SPACE_BYTES)


def check_compiler() -> None:
    """Raise SetupError if there is no compiler for the message package."""
    for variable, language, names in (
        ('CXX', 'C++', ('c++', 'g++', 'clang++')),
        ('CC', 'C', ('cc', 'gcc', 'clang')),
    ):
        wanted = (os.environ[variable].split()[:1] if os.environ.get(variable) else None) or names
        if not any(shutil.which(name) for name in wanted):
            raise SetupError(
                f'needs a {language} compiler ({", ".join(wanted)}), found none on PATH; '
                'on Debian and Ubuntu: apt install build-essential'
            )


def at_first(lock_text: str) -> dict[str, str]:
    """Return the entries of a lock that are installed at first, by package."""
    return lock.part(lock_text, AT_FIRST)


def order_paths(venv: Venv) -> None:
    """Let no other NumPy win over that of the environment, as one in PYTHONPATH would."""
    site = venv.path / 'lib' / f'python{own_version()}' / 'site-packages'
    shutil.copy(Path(path_order.__file__), site / 'bpc_path_order.py')
    call = f'import bpc_path_order; bpc_path_order.put_last({str(venv.root)!r})\n'
    (site / 'bpc_path_order.pth').write_text(call)


def complete_ros(venv: Venv) -> None:
    """Add what the wheels lack, compared with an installation of ROS.

    The CMake exports name the builder's Python; and colcon looks for a local_setup in each prefix.
    """
    for shell in ('sh', 'bash', 'zsh'):
        (venv.path / f'local_setup.{shell}').write_text('# The paths: ./bpc env\n')
    code = 'import numpy; print(numpy.get_include())'
    numpy_include = subprocess.check_output([venv.python, '-I', '-c', code], text=True).strip()
    cmake_repair.repair_exports(venv.path, sysconfig.get_path('include'), numpy_include)


def make(root: Path, rclpy: Path | None, log: Path) -> Venv:
    """Make an environment from nothing, beside those that are there."""
    log.write_bytes(b'')
    with places.new(root, own_version()) as path:
        venv = Venv(root, rclpy, path)
        note(f'[1/3] virtual environment with Python {own_version()}')
        options = ['--system-site-packages'] if rclpy else []
        command = [base_python(), '-I', '-m', 'venv', '--prompt', 'bpc', *options, str(path)]
        if not run_logged(command, log, cwd=root, environment=os.environ):
            wanted = ' '.join(command[:4])
            raise SetupError(f'expected {wanted} to work, found an error (log: {log})')
        entries = at_first(venv.lock.read_text())
        note(f'[2/3] {len(entries)} packages from the package index')
        packages.install(Packages(entries, venv.lock.name, venv.python), log)
        order_paths(venv)
        if rclpy is None:
            complete_ros(venv)
        places.complete(path, venv.stamp(own_version()))
    return venv
