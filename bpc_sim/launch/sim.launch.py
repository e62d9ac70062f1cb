"""The nodes on the synthetic printer."""

from __future__ import annotations

from pathlib import Path
import tempfile
import time

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, SetParameter

from bpc_sim.config import SimConfig
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_sim.printer.settings import write_settings

START_DELAY_S = 6.0  # until all nodes have found each other


def actions(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the live nodes, and robot, extruder and camera of a simulated print."""
    given = {name: LaunchConfiguration(name).perform(context)
             for name in ('scenario', 'speed', 'rate', 'target', 'namespace')}
    namespace = given['namespace']
    sim = SimConfig(scenario=given['scenario'], speed=float(given['speed']),
                    start_time_ns=time.time_ns() + round(START_DELAY_S * 1e9))
    common = {'scenario': sim.scenario, 'speed': sim.speed, 'start_time_ns': sim.start_time_ns}
    folder = Path(tempfile.mkdtemp(prefix='bpc_sim-'))
    settings = write_settings(sim.job(), float(given['target']), folder)
    live = Path(get_package_share_directory('bpc_perception'), 'launch', 'live.launch.py')
    camera = {**common, 'back_end': 'synthetic', 'rate': float(given['rate'])}
    return [
        *(SetParameter(name, value) for name, value in camera.items()),
        IncludeLaunchDescription(
            str(live), launch_arguments={
                'hand_eye_file': str(settings.hand_eye), 'params_file': str(settings.parameters),
                'camera': 'driver', 'namespace': namespace}.items()),
        Node(package='bpc_sim', executable='synthetic_robot', name='synthetic_robot',
             namespace=namespace, parameters=[common], output='screen'),
        Node(package='bpc_sim', executable='synthetic_extruder', name='synthetic_extruder',
             namespace=namespace, parameters=[common], output='screen'),
    ]


def generate_launch_description() -> LaunchDescription:
    """Return arguments, then nodes."""
    return LaunchDescription([
        DeclareLaunchArgument('scenario', default_value='spiral_gaps', choices=tuple(SCENARIOS),
                              description='What is printed.'),
        DeclareLaunchArgument('speed', default_value='0.003',
                              description='Of the nozzle [m/s].'),
        DeclareLaunchArgument('rate', default_value='0.5', description='Captures a second.'),
        DeclareLaunchArgument('target', default_value='0.002',
                              description='Thickness wanted [m].'),
        DeclareLaunchArgument(
            'namespace', default_value='', description='Namespace of all nodes.'),
        OpaqueFunction(function=actions),
    ])
