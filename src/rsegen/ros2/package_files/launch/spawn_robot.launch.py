"""
Spawn a robot in a Gazebo that is running, with its description, frames and bridge.

It is one of the folder robots, or a file: URDF, Xacro or SDF. Its model is named 'robot', as the
topics of the bridge expect.
"""

import json
from math import isfinite, nan
from pathlib import Path
from shlex import quote

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction
from launch.conditions import evaluate_condition_expression
from launch.substitutions import Command, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

SHARE = Path(__file__).absolute().parents[1]
MAPS = sorted(path.stem for path in (SHARE / 'worlds').glob('*.world') if path.is_file())
MAP = DeclareLaunchArgument('map', default_value=MAPS[0], choices=MAPS, description='the map')

ROBOTS = sorted(path.name for path in (SHARE / 'robots').iterdir())
SPAWNERS = {
    'sim': ('ros_gz_sim', 'create', '-name'),
    'classic': ('gazebo_ros', 'spawn_entity.py', '-entity'),
}
COORDINATES = {'x': '-x', 'y': '-y', 'z': '-z', 'roll': '-R', 'pitch': '-P', 'yaw': '-Y'}


def generate_launch_description():
    """Return the arguments and the robot."""
    coordinates = [
        DeclareLaunchArgument(
            name, default_value='', description='metres or radians; default: the start pose')
        for name in COORDINATES
    ]
    return LaunchDescription([
        MAP,
        DeclareLaunchArgument(
            'simulator', default_value='sim', choices=list(SPAWNERS), description='which Gazebo'),
        DeclareLaunchArgument(
            'robot', default_value='@ROBOT@',
            description=f"none, {', '.join(ROBOTS)}, or a file (URDF, Xacro, SDF)"),
        DeclareLaunchArgument(
            'robot_topic', default_value='',
            description='in place of robot: a topic that has its description'),
        DeclareLaunchArgument(
            'robot_name', default_value='robot', description='model name of a robot of your own'),
        DeclareLaunchArgument(
            'start', default_value='spot', choices=['spot', 'ground'],
            description='a spot on the map, if there is one for the robot, or west of the map'),
        *coordinates,
        DeclareLaunchArgument(
            'bridge', default_value='',
            description='bridge file, in place of the default one; none: no bridge'),
        DeclareLaunchArgument(
            'localized', default_value='true',
            description='false: another node, such as SLAM, publishes the frame odom in map'),
        OpaqueFunction(function=spawned),
    ])


def spawned(context):
    """Return the nodes of the robot, or a message if there is none."""
    def given(name):
        return LaunchConfiguration(name).perform(context)

    kind, topic, simulator = given('robot'), given('robot_topic'), given('simulator')
    if kind == 'none' and not topic:
        return [LogInfo(msg=f"No robot is spawned: give robot:={', '.join(ROBOTS)} or a file.")]
    start, place = start_pose(given('map'), kind, given('start'))
    coordinates = {name: number(name, given(name)) for name in COORDINATES if given(name)}
    start.update(coordinates)
    if topic:
        return [spawner(simulator, given('robot_name'), ['-topic', topic], start)]
    place = 'at the given coordinates' if coordinates else place
    localized = evaluate_condition_expression(context, [LaunchConfiguration('localized')])
    said = LogInfo(msg=f'The robot {kind} starts {place}.')
    if kind in ROBOTS:
        if simulator == 'classic':
            raise RuntimeError(f'robot: {kind} drives in Gazebo Sim; give a file')
        folder = SHARE / 'robots' / kind
        return [
            said,
            state_publisher((folder / f'{kind}.urdf').read_text()),
            spawner(simulator, 'robot', ['-file', str(folder / 'model.sdf')], start),
            *bridge(given('bridge'), folder / 'bridge.yaml'),
            *([frame('odom', dict.fromkeys(start, 0.0))] if localized else []),
            frame('wheel_odom', start),
        ]
    path = Path(kind).expanduser().absolute()
    if not path.is_file():
        raise RuntimeError(f"robot: {kind} is neither none, {', '.join(ROBOTS)}, nor a file")
    is_sdf = path.suffix == '.sdf'
    source = ['-file', str(path)] if is_sdf else ['-topic', 'robot_description']
    default = SHARE / 'config' / 'robot_bridge.yaml'
    return [
        said,
        state_publisher(path.read_text() if is_sdf else expanded(context, path)),
        spawner(simulator, given('robot_name'), source, start),
        *(bridge(given('bridge'), default) if simulator == 'sim' else []),
        *([frame('odom', start)] if localized else []),
    ]


def start_pose(name, kind, start):
    """Return the pose at which a robot starts, and where that is."""
    poses = json.loads((SHARE / 'maps' / name / 'start_poses.json').read_text())
    if start == 'spot' and kind in poses:
        return poses[kind], 'on its spot on the map'
    return poses['ground'], 'on the ground west of the map'


def number(name, text):
    """Return a coordinate; an error if the text is no finite number."""
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        raise RuntimeError(f'{name}: {text} is not a number of metres or radians')
    return value


def expanded(context, path):
    """Return the URDF of a Xacro file; its warnings are printed, and stop nothing."""
    return Command(['xacro ', quote(str(path))], on_stderr='warn').perform(context)


def state_publisher(description):
    """Return the node that publishes the description and the frames of the links."""
    return Node(
        package='robot_state_publisher', executable='robot_state_publisher', output='screen',
        parameters=[{
            'use_sim_time': True,
            'robot_description': ParameterValue(description, value_type=str),
        }],
    )


def spawner(simulator, name, source, start):
    """Return the node that spawns the robot at its start pose."""
    package, executable, named = SPAWNERS[simulator]
    pose = [part for key, flag in COORDINATES.items() for part in (flag, decimal(start[key]))]
    arguments = [named, name, *source, *pose]
    return Node(package=package, executable=executable, arguments=arguments, output='screen')


def decimal(value):
    """Return a number without an exponent, which spawn_entity.py takes for an option."""
    return f'{value:.6f}'


def bridge(given, default):
    """Return the bridge of the topics in the given file, or in the default one, in a list."""
    if given == 'none':
        return []
    file = Path(given).expanduser().absolute() if given else default
    if not file.is_file():
        raise RuntimeError(f'bridge: {file} is not a file')
    parameters = {
        'config_file': ParameterValue(str(file), value_type=str),
        'use_sim_time': True,
    }
    return [Node(
        package='ros_gz_bridge', executable='parameter_bridge', name='robot_bridge',
        parameters=[parameters], output='screen',
    )]


def frame(name, pose):
    """
    Return the publisher of a frame in which odometry is given, in the frame map.

    That of rsegen's robots is their true pose in the world, so odom is map; what wheels measure
    begins at the start, as does the odometry of other robots.
    """
    coordinates = [part for key in COORDINATES for part in (f'--{key}', decimal(pose[key]))]
    return Node(
        package='tf2_ros', executable='static_transform_publisher', name=f'{name}_frame',
        arguments=[*coordinates, '--frame-id', 'map', '--child-frame-id', name],
        output='screen',
    )
