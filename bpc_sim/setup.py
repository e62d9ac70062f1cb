"""Installs bpc_sim the ROS 2 way: executables under lib/, data under share/."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = 'bpc_sim'


def share(folder: str, *patterns: str) -> list[tuple[str, list[str]]]:
    """The data_files entry of one folder; none if it has no such file."""
    files = sorted(file for pattern in patterns for file in glob(f'{folder}/{pattern}'))
    return [(f'share/{PACKAGE}/{folder}', files)] if files else []


setup(
    name=PACKAGE,
    version='0.1.0',
    description='Synthetic printer for bpc.',
    maintainer='bpc developers',
    maintainer_email='bpc@localhost.invalid',
    license='Apache-2.0',
    python_requires='>=3.10',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    package_data={PACKAGE: ['py.typed', '**/*.json', '**/*.yaml', '**/*.npz']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        *share('config', '*.yaml'),
        *share('launch', '*.launch.py'),
    ],
    install_requires=['setuptools'],
    extras_require={
        'raytraced': ['mitsuba==3.9.0'],  # traces the scenes of the study raytraced anew
        'test': ['pytest'],  # tells `colcon test` to run pytest
    },
    zip_safe=False,
    entry_points={
        'bpc.cameras': ['synthetic = bpc_sim.nodes.camera_back_end:prepare'],
        'bpc.commands': [
            'bench = bpc_sim.cli.bench:bench',
            'raytrace = bpc_sim.cli.raytrace:raytrace',
            'sim = bpc_sim.cli.sim:sim',
            'study = bpc_sim.cli.study:study',
        ],
        'console_scripts': [
            'print_controller = bpc_sim.nodes.print_controller:main',
            'synthetic_arm = bpc_sim.nodes.arm:main',
            'synthetic_extruder = bpc_sim.nodes.extruder:main',
            'synthetic_printer = bpc_sim.nodes.printer:main',
            'synthetic_robot = bpc_sim.nodes.robot:main',
        ],
    },
)
