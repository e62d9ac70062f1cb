"""The nodes on a real printer's topics; the robot publishes by itself."""

from __future__ import annotations

import os

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from bpc_perception.claims import domain
from bpc_perception.files.parameter_file import live_recorder
from bpc_perception.recording.path_journal import default_folder
from bpc_perception.runtime.transport.dds_profiles import PROFILE_VARIABLES, with_profile

# Shared memory with room for a capture; a user's own file wins.
TRANSPORT = {name: value for name, value in with_profile(os.environ, captures=True).items()
             if name in PROFILE_VARIABLES}

# A node that died goes on with its print; one that cannot start says why a few times over.
RESPAWN_DELAY, RESPAWN_MAX_RETRIES = 0.5, 3  # [s], times

# What the nodes subscribe to, by the launch argument that names another topic for it.
TOPICS = {
    'pose_topic': 'end_effector_pose',
    'joint_states_topic': 'joint_states',
    'lbr_state_topic': 'lbr_state',
    'extrusion_topic': 'extrusion_state',
    'image_topic': 'color/image_color',
    'camera_info_topic': 'color/camera_info',
    'cloud_topic': 'points/xyzrgba',
}


def nodes(context: LaunchContext) -> list[Node]:
    """The nodes that the arguments ask for."""
    given = {name: LaunchConfiguration(name).perform(context) for name in (
        'params_file', 'hand_eye_file', 'namespace', 'use_sim_time', 'camera',
        'camera_settings_file', 'autostart', 'extruder', *TOPICS)}
    if not given['namespace'].strip('/'):  # that of the commands
        domain.expect_free()
    recorder = live_recorder(given['params_file'] or None)  # refuses without a nozzle offset
    parameters = [given['params_file']] if given['params_file'] else []
    parameters.append({'use_sim_time': given['use_sim_time'] == 'true'})
    remappings = [(topic, given[argument]) for argument, topic in TOPICS.items()
                  if given[argument] != topic]
    common = {'namespace': given['namespace'], 'remappings': remappings, 'output': 'screen',
              'respawn': True, 'respawn_delay': RESPAWN_DELAY,
              'respawn_max_retries': RESPAWN_MAX_RETRIES}
    kept = recorder.state_folder or str(default_folder(given['namespace']))
    started = [Node(package='bpc_perception', executable='path_recorder', name='path_recorder',
                    parameters=[*parameters, {'state_folder': kept}], **common)]
    parameters = [*parameters, {'hand_eye_file': given['hand_eye_file']}]
    if given['camera'] in ('driver', 'zivid'):  # two nodes, which have their own names
        chosen = [] if given['camera'] == 'driver' else [
            {'back_end': 'zivid', 'settings_file': given['camera_settings_file']}]
        started.append(Node(package='bpc_perception', executable='composed',
                            parameters=[*parameters, {'autostart': given['autostart'] == 'true'},
                                        *chosen],
                            additional_env=TRANSPORT, **common))
    else:
        started.append(Node(package='bpc_perception', executable='thickness', name='thickness',
                            parameters=parameters, **common))
    if given['camera'] == 'vendor':
        started.append(Node(
            package='zivid_camera', executable='zivid_camera', name='zivid_camera',
            parameters=[*parameters, {'settings_file_path': given['camera_settings_file']}],
            additional_env=TRANSPORT, **common))
    if given['extruder'] == 'bridge':
        started.append(Node(package='bpc_perception', executable='extruder_bridge',
                            name='extruder_bridge', parameters=parameters, **common))
    return started


def generate_launch_description() -> LaunchDescription:
    """Arguments, then nodes."""
    return LaunchDescription([
        DeclareLaunchArgument(
            'hand_eye_file', description='Hand-eye calibration.'),
        DeclareLaunchArgument(
            'params_file', description='ROS parameter file; it has to say the nozzle_offset.'),
        DeclareLaunchArgument(
            'namespace', default_value='', description='Namespace of all nodes.'),
        DeclareLaunchArgument(
            'use_sim_time', default_value='false', choices=('true', 'false'),
            description='Whether time comes from /clock.'),
        DeclareLaunchArgument(
            'camera', default_value='none', choices=('none', 'vendor', 'driver', 'zivid'),
            description='none = the camera publishes already; vendor = start zivid_camera; '
                        'driver = our camera driver, in the process of the thickness node; '
                        'zivid = the same with that back end.'),
        DeclareLaunchArgument(
            'camera_settings_file', default_value='',
            description='With camera:=vendor and camera:=zivid: capture settings (.yml).'),
        DeclareLaunchArgument(
            'autostart', default_value='true', choices=('true', 'false'),
            description='With camera:=driver and camera:=zivid: false = the camera driver waits '
                        'for a lifecycle manager.'),
        DeclareLaunchArgument(
            'extruder', default_value='none', choices=('none', 'bridge'),
            description='bridge = start extruder_bridge; none = extrusion_state is published.'),
        *(DeclareLaunchArgument(argument, default_value=topic,
                                description=f'The topic to use for {topic}.')
          for argument, topic in TOPICS.items()),
        OpaqueFunction(function=nodes),
    ])
