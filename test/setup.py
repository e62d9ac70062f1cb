"""Makes the system tests a package, so that `colcon test` runs them; nothing is installed."""

from setuptools import setup

PACKAGE = 'bpc_system_tests'

setup(
    name=PACKAGE,
    version='0.1.0',
    description='Tests of bpc at topic level.',
    maintainer='bpc developers',
    maintainer_email='bpc@localhost.invalid',
    license='Apache-2.0',
    python_requires='>=3.10',
    packages=[],
    py_modules=[],
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},  # tells `colcon test` to run pytest
    zip_safe=False,
)
