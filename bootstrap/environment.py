"""The environment variables that the nodes, colcon, pytest and Python need."""

from collections.abc import Iterable, Mapping
import os
from pathlib import Path
import shlex

from bootstrap import places
from bootstrap.installing import extras
from bootstrap.progress import PYTHON_SETTINGS
from bootstrap.stamps import PYTHON_PACKAGES
from bootstrap.venv import Venv

# Search paths that a sourced ROS fills. If that ROS cannot be used, they are emptied.
ROS_PATHS = ('AMENT_PREFIX_PATH', 'CMAKE_PREFIX_PATH', 'PYTHONPATH', 'LD_LIBRARY_PATH')


def joined(first: Iterable[Path], rest: Iterable[str]) -> str:
    """Return a search path with some folders in front, each folder once."""
    return os.pathsep.join(dict.fromkeys([*map(str, first), *rest]))


def python_folders(root: Path, build: Path) -> list[Path]:
    """Return the folders to import our packages from: sources, metadata, generated messages."""
    install = build / 'install'
    return [
        *(root / package for package in (*PYTHON_PACKAGES, 'test')),
        *(build / 'build' / package for package in PYTHON_PACKAGES),
        *sorted(install.glob('lib/python3*/site-packages')),
        *sorted(install.glob('local/lib/python3*/dist-packages')),
    ]


def search_paths(venv: Venv, given: Mapping[str, str], build: Path | None) -> dict[str, str]:
    """Return the search paths, with the folders of the colcon build, if there is one, in front."""
    if given.get('ROS_DISTRO') and venv.rclpy is None:
        given = {key: value for key, value in given.items() if key not in ROS_PATHS}
    prefixes = [build / 'install'] if build else []
    libraries = [prefix / 'lib' for prefix in prefixes]
    if venv.rclpy is None:
        prefixes.append(venv.path)
        wheel_libraries = sorted(venv.path.glob('lib/python3*/site-packages/ros_*.libs'))
        libraries += [venv.path / 'lib', *wheel_libraries]
    folders = {
        'PATH': [venv.path / 'bin', *extras.programs(venv)],
        'AMENT_PREFIX_PATH': prefixes,
        'CMAKE_PREFIX_PATH': prefixes,
        'LD_LIBRARY_PATH': libraries,
        'PYTHONPATH': python_folders(venv.root, build) if build else [],
    }
    earlier = f'{venv.root / places.FOLDER}{os.sep}'  # from a shell with another `./bpc env`
    rest = {
        name: [part for part in given.get(name, '').split(os.pathsep)
               if part and not part.startswith(earlier)]
        for name in folders
    }  # fmt: skip
    return {name: joined(paths, rest[name]) for name, paths in folders.items()}


def variables(venv: Venv, given: Mapping[str, str], build: Path | None) -> dict[str, str]:
    """Return the variables to set, given those that are set already.

    Args:
        venv: the virtual environment
        given: the variables that are set
        build: folder of the colcon build; None: it is only going to be built
    """
    result = {
        'BPC_ROOT': str(venv.root),
        'VIRTUAL_ENV': str(venv.path),
        **search_paths(venv, given, build),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': given.get('ROS_AUTOMATIC_DISCOVERY_RANGE') or 'LOCALHOST',
        'ROS_LOG_DIR': given.get('ROS_LOG_DIR') or str(venv.root / 'log' / 'ros'),
        'RMW_IMPLEMENTATION': given.get('RMW_IMPLEMENTATION') or 'rmw_fastrtps_cpp',
    }
    if venv.rclpy is None:
        result['CMAKE_GENERATOR'] = 'Ninja'
        # Otherwise the wheels start each Python twice to set LD_LIBRARY_PATH, which is set above.
        result['_ROS_WHEELS_BOOTSTRAP_COMPLETE'] = '1'
    return {name: value for name, value in result.items() if value}


def exports(values: Mapping[str, str], given: Mapping[str, str]) -> str:
    """Return shell lines that set the variables, and unset what harms our Python."""
    unset = ''.join(f'unset {name}\n' for name in PYTHON_SETTINGS if name in given)
    return unset + ''.join(
        f'export {name}={shlex.quote(value)}\n' for name, value in values.items()
    )
