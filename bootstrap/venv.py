"""Makes the virtual environment: the locked packages, and CMake exports that fit this machine."""

from dataclasses import dataclass
import importlib.util
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import sysconfig

from bootstrap import cmake_repair, stamps
from bootstrap.progress import note, run_logged, SetupError

SPACE_NEEDED = 1.5e9  # [bytes] the environment, the build, and what pip unpacks on the way
STAMP = 'bpc-stamp'

# What pip's log says, and what it means. The first that fits is the reason.
PIP_FAILURES = (
    (r'No space left on device', 'the disk is full'),
    (r'DO NOT MATCH THE HASHES', 'a package whose content differs from the lock'),
    (r'Retrying \(|NewConnectionError|ConnectTimeout|ProxyError', 'no connection'),
)


@dataclass(frozen=True)
class Venv:
    """The virtual environment of one checkout.

    Attributes:
        root: the checkout
        rclpy: the rclpy of a sourced stock Jazzy; None: ROS comes as wheels
    """

    root: Path
    rclpy: Path | None

    @property
    def path(self) -> Path:
        """Its folder."""
        return self.root / '.venv'

    @property
    def python(self) -> Path:
        """Its interpreter."""
        return self.path / 'bin' / 'python'

    @property
    def lock(self) -> Path:
        """The packages it holds.

        Stock Jazzy's message modules are compiled against NumPy 1.26 and fail to import with 2,
        which the other lock has; and pip must not judge by itself what of apt's is good enough.
        """
        name = 'requirements.lock' if self.rclpy is None else 'stock.lock'
        return self.root / 'bootstrap' / name

    def stamp(self, version: str) -> str:
        """What the stamp says once this environment is complete, for a Python version."""
        ros = self.rclpy or 'wheels'
        return f'python {version}\nlock {stamps.file_hash(self.lock)}\nros {ros}\nat {self.path}\n'

    def is_current(self) -> bool:
        """Whether it is complete and as it would be made now.

        A Python version that nobody asked for now is no reason to make it again.
        """
        found = stamps.read(self.path / STAMP)
        version = found.partition('\n')[0].removeprefix('python ')
        if os.environ.get('BPC_PYTHON') and version != own_version():
            return False
        return found == self.stamp(version) and self.python.exists()


def own_version() -> str:
    """The version of this interpreter, as in `python3.12`."""
    return f'{sys.version_info.major}.{sys.version_info.minor}'


def base_python() -> str:
    """This interpreter outside any virtual environment, which may be the one to be replaced."""
    return getattr(sys, '_base_executable', None) or sys.executable


def check_prerequisites(root: Path) -> None:
    """Complain about what the set-up would stumble over minutes later."""
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
    free = shutil.disk_usage(root).free
    if free < SPACE_NEEDED:
        raise SetupError(
            f'needs {SPACE_NEEDED / 1e9:.1f} GB of disk for the set-up, '
            f'found {free / 1e9:.1f} GB free at {root}'
        )


def check_compiler() -> None:
    """Complain if there is no compiler for the message package."""
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


def why_pip_failed(log_text: str) -> str:
    """The reason of a failed installation, in a few words and pip's own first error."""
    meaning = next((text for pattern, text in PIP_FAILURES if re.search(pattern, log_text)), '')
    errors = re.findall(r'^\s*ERROR: (.*)$', log_text, re.MULTILINE)
    return '; '.join(part for part in (meaning, *errors[:1]) if part) or 'an error'


def build_tools_of(lock_text: str) -> str:
    """The part of a lock that pip needs first to install a package published as source only."""
    found = re.search(r'^setuptools==.*\n(?:[ \t].*\n?)*', lock_text, re.MULTILINE)
    return found.group() if found else ''


def install(venv: Venv, log: Path) -> None:
    """Install exactly what the lock says."""
    environment = {
        **{key: value for key, value in os.environ.items() if key != 'PYTHONPATH'},
        '_ROS_WHEELS_BOOTSTRAP_COMPLETE': '1',  # pip needs none of the ROS libraries
        'PIP_DISABLE_PIP_VERSION_CHECK': '1',
        'PIP_NO_INPUT': '1',
        'PIP_PROGRESS_BAR': 'off',
    }
    build_tools = venv.path / 'build-tools.lock'
    build_tools.write_text(build_tools_of(venv.lock.read_text()))
    for requirements in (build_tools, venv.lock):
        command = [
            *(str(venv.python), '-m', 'pip', 'install', '-r', str(requirements), '--no-compile'),
            *('--require-hashes', '--no-deps', '--no-build-isolation', '--use-pep517'),
        ]
        if not run_logged(command, log, cwd=venv.root, environment=environment):
            raise SetupError(
                f'expected the packages of bootstrap/{venv.lock.name} from the package index, '
                f'found: {why_pip_failed(log.read_text(errors="replace"))} (log: {log})'
            )


def compile_modules(venv: Venv, log: Path) -> None:
    """Compile what was installed on all cores; pip would take three times as long on one."""
    command = [str(venv.python), '-I', '-m', 'compileall', '-q', '-j', '0', str(venv.path / 'lib')]
    # A failure is no harm: some packages ship files that are valid in another Python only.
    run_logged(command, log, cwd=venv.root, environment=os.environ)


def complete_ros(venv: Venv) -> None:
    """Mend what the wheels lack of an installation of ROS.

    The CMake exports name the builder's Python; and colcon looks for a local_setup in each prefix.
    """
    for shell in ('sh', 'bash', 'zsh'):
        (venv.path / f'local_setup.{shell}').write_text('# The paths: ./bpc env\n')
    code = 'import numpy; print(numpy.get_include())'
    numpy_include = subprocess.check_output([venv.python, '-I', '-c', code], text=True).strip()
    cmake_repair.repair_exports(venv.path, sysconfig.get_path('include'), numpy_include)


def make(venv: Venv, log: Path) -> None:
    """Make the environment from nothing; without its stamp the next run would replace it."""
    shutil.rmtree(venv.path, ignore_errors=True)
    log.write_bytes(b'')
    note(f'[1/3] virtual environment with Python {own_version()}')
    options = ['--system-site-packages'] if venv.rclpy else []
    command = [base_python(), '-m', 'venv', '--prompt', 'bpc', *options, str(venv.path)]
    if not run_logged(command, log, cwd=venv.root, environment=os.environ):
        raise SetupError(f'expected {" ".join(command[:3])} to work, found an error (log: {log})')
    count = len(re.findall(r'^[\w.-]+==', venv.lock.read_text(), re.MULTILINE))
    note(f'[2/3] about {count} packages from the package index, a minute or two')
    try:
        install(venv, log)
    except SetupError:
        shutil.rmtree(venv.path, ignore_errors=True)  # the disk may be full of it
        raise
    compile_modules(venv, log)
    if venv.rclpy is None:
        complete_ros(venv)
    (venv.path / STAMP).write_text(venv.stamp(own_version()))
