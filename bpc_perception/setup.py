"""Installs bpc_perception the ROS 2 way: executables under lib/, data under share/."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = 'bpc_perception'


def share(folder: str, *patterns: str) -> list[tuple[str, list[str]]]:
    """The data_files entry of one folder; none if it has no such file."""
    files = sorted(file for pattern in patterns for file in glob(f'{folder}/{pattern}'))
    return [(f'share/{PACKAGE}/{folder}', files)] if files else []


setup(
    name=PACKAGE,
    version='0.1.0',
    description='Thickness of a printed filament along the path of the nozzle.',
    maintainer='bpc developers',
    maintainer_email='bpc@localhost.invalid',
    license='Apache-2.0',
    python_requires='>=3.10',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    # Everything beside the modules that they read: templates, transport profiles.
    package_data={PACKAGE: ['py.typed', '**/*.css', '**/*.j2', '**/*.json', '**/*.xml',
                            '**/*.yaml']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        *share('config', '*.yaml', '*.xml'),
        *share('launch', '*.launch.py'),
        *share('rviz', '*.rviz'),
        *share('foxglove', '*.json'),
        *share('sros2', '*.xml'),
    ],
    install_requires=['setuptools'],
    extras_require={
        'batch': ['distributed', 'pyarrow'],  # bpc batch
        'docs': ['furo', 'myst-parser', 'sphinx'],  # the web site of docs/
        'figures': ['matplotlib'],  # --figures
        'page': ['nicegui'],  # --page
        'printability': ['shapely'],  # bpc printability
        'tables': ['openpyxl'],  # --xlsx
        'window': ['statsmodels'],  # bpc window
        'test': ['pytest'],  # tells `colcon test` to run pytest
    },
    zip_safe=False,
    entry_points={
        'bpc.cameras': [
            'bag = bpc_perception.drivers.cameras.bag:prepare',
            'zivid = bpc_perception.drivers.cameras.zivid:prepare',
        ],
        'console_scripts': [
            'bpc = bpc_perception.__main__:main',
            'bag_player = bpc_perception.nodes.bag_player:main',
            'bag_recorder = bpc_perception.nodes.bag_recorder:main',
            'camera_driver = bpc_perception.nodes.camera_driver:main',
            'composed = bpc_perception.nodes.composed:main',
            'extruder_bridge = bpc_perception.nodes.extruder_bridge:main',
            'page = bpc_perception.nodes.page:main',
            'path_recorder = bpc_perception.nodes.path_recorder:main',
            'results_writer = bpc_perception.nodes.results_writer:main',
            'thickness = bpc_perception.nodes.thickness:main',
        ],
    },
)
