"""Makes the system tests a package, so that `colcon test` runs them."""

from setuptools import find_namespace_packages, setup

PACKAGE = 'bpc_system_tests'

setup(
    name=PACKAGE,
    version='0.1.0',
    description='Tests of bpc at topic level.',
    maintainer='bpc developers',
    maintainer_email='bpc@localhost.invalid',
    license='Apache-2.0',
    python_requires='>=3.10',
    packages=find_namespace_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},  # tells `colcon test` to run pytest
    zip_safe=False,
)
