"""The nodes on a recording, in real time, with /clock."""

from __future__ import annotations

from pathlib import Path

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    IncludeLaunchDescription,
    OpaqueFunction,
    RegisterEventHandler,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration, ThisLaunchFileDir
from launch_ros.actions import Node, SetParameter


def actions(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """The live nodes, and robot, extruder and camera out of the recording."""
    given = {name: LaunchConfiguration(name).perform(context) for name in (
        'bag', 'hand_eye_file', 'params_file', 'namespace', 'rate', 'loop')}
    bag = Path(given['bag'])
    hand_eye = given['hand_eye_file'] or str(bag / 'hand_eye.calib')
    beside = bag / 'params.yaml'
    params = given['params_file'] or (str(beside) if beside.exists() else '')
    files = [params] if params else []
    common = {'package': 'bpc_perception', 'namespace': given['namespace'], 'output': 'screen'}
    player = Node(
        executable='bag_player', name='bag_player', **common,
        parameters=[*files, {'bag': str(bag), 'rate': float(given['rate']),
                             'loop': given['loop'] == 'true'}])
    return [
        SetParameter('back_end', 'bag'),
        SetParameter('bag', str(bag)),
        IncludeLaunchDescription(
            [ThisLaunchFileDir(), '/live.launch.py'],
            launch_arguments={
                'hand_eye_file': hand_eye, 'params_file': params, 'use_sim_time': 'true',
                'camera': 'driver', 'namespace': given['namespace']}.items()),
        player,
        RegisterEventHandler(OnProcessExit(
            target_action=player,
            on_exit=[EmitEvent(event=Shutdown(reason='the recording has ended'))])),
    ]


def generate_launch_description() -> LaunchDescription:
    """Arguments, then nodes."""
    return LaunchDescription([
        DeclareLaunchArgument('bag', description='Recording: a rosbag2 folder.'),
        DeclareLaunchArgument(
            'hand_eye_file', default_value='',
            description='Hand-eye calibration; empty = hand_eye.calib in '
                        'the recording.'),
        DeclareLaunchArgument(
            'params_file', default_value='',
            description='ROS parameter file; empty = params.yaml in the recording, if there.'),
        DeclareLaunchArgument(
            'namespace', default_value='', description='Namespace of all nodes.'),
        DeclareLaunchArgument('rate', default_value='1.0', description='Speed; 1 = as recorded.'),
        DeclareLaunchArgument('loop', default_value='false', choices=('true', 'false'),
                              description='Again and again.'),
        OpaqueFunction(function=actions),
    ])
