"""The nodes on a recording, in real time, with /clock."""

from __future__ import annotations

import os
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
from launch_ros.actions import Node

import bpc_perception

# Shared memory with room for a capture; a user's own file wins. Read under either name.
TRANSPORT = {name: str(Path(bpc_perception.__file__).with_name('transport.xml'))
             for name in ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
             if name not in os.environ}


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
        IncludeLaunchDescription(
            [ThisLaunchFileDir(), '/live.launch.py'],
            launch_arguments={
                'hand_eye_file': hand_eye, 'params_file': params, 'use_sim_time': 'true',
                'namespace': given['namespace']}.items()),
        Node(executable='camera_driver', name='camera_driver', additional_env=TRANSPORT, **common,
             parameters=[*files, {'back_end': 'bag', 'bag': str(bag), 'use_sim_time': True}]),
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
