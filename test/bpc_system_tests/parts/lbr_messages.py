"""The messages of the LBR stack, for which there is no wheel: built where they are missing."""

from __future__ import annotations

from importlib.util import find_spec
import os
from pathlib import Path
import subprocess
from textwrap import dedent

PACKAGE = 'lbr_fri_idl'
# Fields, types and order are those of lbr_fri_idl for FRI 1: the message is the same on the wire.
FILES = {
    'msg/LBRState.msg': '''
        float64 sample_time
        int8 session_state
        int8 connection_quality
        int8 safety_state
        int8 operation_mode
        int8 drive_state
        int8 client_command_mode
        int8 overlay_type
        int8 control_mode
        uint32 time_stamp_sec
        uint32 time_stamp_nano_sec
        float64[7] measured_joint_position
        float64[7] commanded_joint_position
        float64[7] measured_torque
        float64[7] commanded_torque
        float64[7] external_torque
        float64[7] ipo_joint_position
        float64 tracking_performance
    ''',
    'CMakeLists.txt': '''
        cmake_minimum_required(VERSION 3.10)
        project(lbr_fri_idl)
        find_package(ament_cmake REQUIRED)
        find_package(rosidl_default_generators REQUIRED)
        rosidl_generate_interfaces(${PROJECT_NAME} msg/LBRState.msg)
        ament_package()
    ''',
    'package.xml': '''
        <package format="3">
          <name>lbr_fri_idl</name>
          <version>0.0.0</version>
          <description>LBRState as the LBR stack has it.</description>
          <maintainer email="bpc@localhost.invalid">bpc developers</maintainer>
          <license>Apache-2.0</license>
          <buildtool_depend>ament_cmake</buildtool_depend>
          <buildtool_depend>rosidl_default_generators</buildtool_depend>
          <exec_depend>rosidl_default_runtime</exec_depend>
          <member_of_group>rosidl_interface_packages</member_of_group>
        </package>
    ''',
}


def lbr_messages(folder: Path) -> dict[str, str]:
    """Build the package in a folder; return the search paths with which processes find it."""
    if find_spec(PACKAGE) is not None:  # the real package
        return {}
    for name, text in FILES.items():
        file = folder / 'source' / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(dedent(text))
    build, prefix = folder / 'build', folder / 'install'
    for command in (['cmake', '-S', folder / 'source', '-B', build,
                     f'-DCMAKE_INSTALL_PREFIX={prefix}', '-DCMAKE_BUILD_TYPE=Debug'],
                    ['cmake', '--build', build, '--target', 'install']):
        ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                               check=False)
        assert ended.returncode == 0, ended.stdout + ended.stderr
    python, = prefix.glob(f'**/{PACKAGE}/msg/__init__.py')
    first = {'PYTHONPATH': python.parents[2], 'LD_LIBRARY_PATH': prefix / 'lib',
             'AMENT_PREFIX_PATH': prefix}
    return {name: f'{path}:{os.environ.get(name, "")}' for name, path in first.items()}
