"""The launch files of a package, and its own test, as texts.

They find maps and robots in the folder of the package, and keep to ament_flake8: single quotes, lines of at most 99
characters. Robots and bridges use the time of the simulation, which runs there in any case; files that run without one
too have the argument `use_sim_time`, which is false unless gazebo_sim.launch.py includes them.
"""

from __future__ import annotations

from rsegen.ros2.bridge import ROBOT
from rsegen.ros2.rviz import NAMESPACE

MAP_ARGUMENT = """\
SHARE = Path(__file__).absolute().parents[1]
MAPS = sorted(path.stem for path in (SHARE / 'worlds').glob('*.world'))
MAP = DeclareLaunchArgument('map', default_value=MAPS[0], choices=MAPS, description='the map')
"""
"""The folder of the package, as its source or installed, and the argument that chooses one of its maps."""

SIM = f'''\
"""Open a map in Gazebo Sim with a clock for ROS, and a robot; on request with RViz and Nav2."""

from pathlib import Path
from shlex import quote

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.actions import SetEnvironmentVariable
from launch.conditions import evaluate_condition_expression, IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

{MAP_ARGUMENT}
CONFIGS = {{
    'IGN_GAZEBO_SERVER_CONFIG_PATH': SHARE / 'config' / 'fortress_server.config',
    'GZ_SIM_SERVER_CONFIG_PATH': SHARE / 'config' / 'server.config',
}}
ON_REQUEST = {{
    'rviz': ('rviz.launch.py', 'show all in RViz'),
    'nav2': ('navigation.launch.py', 'drive to goals with Nav2'),
    'elevation': ('elevation.launch.py', 'publish the map as grid_map'),
}}


def generate_launch_description():
    """Return the environment, Gazebo, the bridge of its clock, the robot, and the rest."""
    return LaunchDescription([
        MAP,
        DeclareLaunchArgument('paused', default_value='false', description='start paused'),
        DeclareLaunchArgument('headless', default_value='false', description='open no window'),
        DeclareLaunchArgument('verbose', default_value='false', description='print all messages'),
        DeclareLaunchArgument(
            'options', default_value='',
            description='options of gz sim, in place of paused, headless and verbose',
        ),
        *(DeclareLaunchArgument(name, default_value='false', description=description)
          for name, (_, description) in ON_REQUEST.items()),
        # Each Gazebo reads its own variable; one that is set already stays.
        *(SetEnvironmentVariable(name, EnvironmentVariable(name, default_value=str(path)))
          for name, path in CONFIGS.items()),
        OpaqueFunction(function=gazebo),
        Node(
            package='ros_gz_bridge', executable='parameter_bridge', name='clock_bridge',
            parameters=[{{'config_file': str(SHARE / 'config' / 'clock_bridge.yaml')}}],
            output='screen',
        ),
        included('spawn_robot.launch.py', {{'simulator': 'sim'}}),
        *(included(file, {{'use_sim_time': 'true'}}, IfCondition(LaunchConfiguration(name)))
          for name, (file, _) in ON_REQUEST.items()),
    ])


def included(name, arguments, condition=None):
    """Return another launch file of this package with arguments."""
    source = PythonLaunchDescriptionSource(str(SHARE / 'launch' / name))
    return IncludeLaunchDescription(
        source, launch_arguments=arguments.items(), condition=condition)


def gazebo(context):
    """Return Gazebo Sim with the world of the map."""
    world = SHARE / 'worlds' / f"{{LaunchConfiguration('map').perform(context)}}.world"
    source = [FindPackageShare('ros_gz_sim'), '/launch/gz_sim.launch.py']
    arguments = {{
        'gz_args': f'{{options(context)}} {{quote(str(world))}}',
        'on_exit_shutdown': 'true',
    }}
    return [IncludeLaunchDescription(
        PythonLaunchDescriptionSource(source), launch_arguments=arguments.items())]


def options(context):
    """Return the options of gz sim."""
    given = LaunchConfiguration('options').perform(context)
    if given:
        return given
    flags = {{'headless': '-s --headless-rendering', 'verbose': '-v 4'}}
    chosen = [flag for name, flag in flags.items() if is_true(context, name)]
    return ' '.join([*chosen, *([] if is_true(context, 'paused') else ['-r'])])


def is_true(context, name):
    """Return whether an argument is true."""
    return evaluate_condition_expression(context, [LaunchConfiguration(name)])
'''

CLASSIC = f'''\
"""Open a map in Gazebo Classic (up to ROS 2 Iron), and spawn a robot; Gazebo publishes /clock."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.conditions import evaluate_condition_expression
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.substitutions import FindPackageShare

{MAP_ARGUMENT}

def generate_launch_description():
    """Return Gazebo and the spawner."""
    spawner = PythonLaunchDescriptionSource(str(SHARE / 'launch' / 'spawn_robot.launch.py'))
    return LaunchDescription([
        MAP,
        DeclareLaunchArgument('paused', default_value='false', description='start paused'),
        DeclareLaunchArgument('headless', default_value='false', description='open no window'),
        DeclareLaunchArgument('verbose', default_value='false', description='print all messages'),
        DeclareLaunchArgument('gui', default_value='true', description='false is headless, too'),
        DeclareLaunchArgument(
            'robot', default_value='none', description='none, or a file (URDF, Xacro, SDF)'),
        OpaqueFunction(function=gazebo),
        IncludeLaunchDescription(spawner, launch_arguments={{'simulator': 'classic'}}.items()),
    ])


def gazebo(context):
    """Return the server with the world of the map, and the window unless there is to be none."""
    world = SHARE / 'worlds' / f"{{LaunchConfiguration('map').perform(context)}}.world"
    verbose = lower(context, 'verbose')
    arguments = {{
        'world': str(world),
        'pause': lower(context, 'paused'),
        'verbose': verbose,
        'server_required': 'true',
    }}
    found = [included('gzserver.launch.py', arguments)]
    if lower(context, 'gui') == 'true' and lower(context, 'headless') == 'false':
        found.append(included('gzclient.launch.py', {{'verbose': verbose}}))
    return found


def included(name, arguments):
    """Return a launch file of gazebo_ros with arguments."""
    source = PythonLaunchDescriptionSource([FindPackageShare('gazebo_ros'), f'/launch/{{name}}'])
    return IncludeLaunchDescription(source, launch_arguments=arguments.items())


def lower(context, name):
    """Return an argument as gazebo_ros compares it: true or false."""
    value = evaluate_condition_expression(context, [LaunchConfiguration(name)])
    return str(value).lower()
'''

SPAWN_ROBOT = f'''\
"""
Spawn a robot in a Gazebo that is running, with its description, frames and bridge.

It is one of the folder robots, or a file: URDF, Xacro or SDF. Its model is named '{ROBOT}', as the
topics of the bridge expect.
"""

import json
from pathlib import Path
from shlex import quote

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import Command, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

{MAP_ARGUMENT}
ROBOTS = sorted(path.name for path in (SHARE / 'robots').iterdir())
SPAWNERS = {{
    'sim': ('ros_gz_sim', 'create', '-name'),
    'classic': ('gazebo_ros', 'spawn_entity.py', '-entity'),
}}
COORDINATES = {{'x': '-x', 'y': '-y', 'z': '-z', 'roll': '-R', 'pitch': '-P', 'yaw': '-Y'}}


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
            description=f"none, {{', '.join(ROBOTS)}}, or a file (URDF, Xacro, SDF)"),
        DeclareLaunchArgument(
            'robot_topic', default_value='',
            description='in place of robot: a topic that has its description'),
        DeclareLaunchArgument(
            'robot_name', default_value='{ROBOT}', description='model name of a robot of your own'),
        DeclareLaunchArgument(
            'start', default_value='spot', choices=['spot', 'ground'],
            description='a spot on the map, if there is one for the robot, or west of the map'),
        *coordinates,
        DeclareLaunchArgument(
            'bridge', default_value='',
            description='the bridge file of a robot of your own; none: no bridge'),
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
        return [LogInfo(msg=f"No robot is spawned: give robot:={{', '.join(ROBOTS)}} or a file.")]
    start, place = start_pose(given('map'), kind, given('start'))
    coordinates = {{name: float(given(name)) for name in COORDINATES if given(name)}}
    start.update(coordinates)
    if topic:
        return [spawner(simulator, given('robot_name'), ['-topic', topic], start)]
    place = 'at the given coordinates' if coordinates else place
    localized = IfCondition(LaunchConfiguration('localized'))
    said = LogInfo(msg=f'The robot {{kind}} starts {{place}}.')
    if kind in ROBOTS:
        if simulator == 'classic':
            raise RuntimeError(f'robot: {{kind}} drives in Gazebo Sim; give a file')
        folder = SHARE / 'robots' / kind
        return [
            said,
            state_publisher((folder / f'{{kind}}.urdf').read_text()),
            spawner(simulator, '{ROBOT}', ['-file', str(folder / 'model.sdf')], start),
            bridge(given('bridge') or folder / 'bridge.yaml'),
            frame('odom', dict.fromkeys(start, 0.0), localized),
            frame('wheel_odom', start),
        ]
    path = Path(kind).expanduser().absolute()
    if not path.is_file():
        raise RuntimeError(f"robot: {{kind}} is neither none, {{', '.join(ROBOTS)}}, nor a file")
    is_sdf = path.suffix == '.sdf'
    source = ['-file', str(path)] if is_sdf else ['-topic', 'robot_description']
    default = SHARE / 'config' / 'robot_bridge.yaml'
    is_bridged = simulator == 'sim' and given('bridge') != 'none'
    return [
        said,
        state_publisher(path.read_text() if is_sdf else Command(['xacro ', quote(str(path))])),
        spawner(simulator, given('robot_name'), source, start),
        *([bridge(given('bridge') or default)] if is_bridged else []),
        frame('odom', start, localized),
    ]


def start_pose(name, kind, start):
    """Return the pose at which a robot starts, and where that is."""
    poses = json.loads((SHARE / 'maps' / name / 'start_poses.json').read_text())
    if start == 'spot' and kind in poses:
        return poses[kind], 'on its spot on the map'
    return poses['ground'], 'on the ground west of the map'


def state_publisher(description):
    """Return the node that publishes the description and the frames of the links."""
    return Node(
        package='robot_state_publisher', executable='robot_state_publisher', output='screen',
        parameters=[{{
            'use_sim_time': True,
            'robot_description': ParameterValue(description, value_type=str),
        }}],
    )


def spawner(simulator, name, source, start):
    """Return the node that spawns the robot at its start pose."""
    package, executable, named = SPAWNERS[simulator]
    pose = [part for key, flag in COORDINATES.items() for part in (flag, str(start[key]))]
    arguments = [named, name, *source, *pose]
    return Node(package=package, executable=executable, arguments=arguments, output='screen')


def bridge(file):
    """Return the bridge of the topics in a file."""
    return Node(
        package='ros_gz_bridge', executable='parameter_bridge', name='robot_bridge',
        parameters=[{{'config_file': str(file), 'use_sim_time': True}}], output='screen',
    )


def frame(name, pose, condition=None):
    """
    Return the publisher of a frame in which odometry is given, in the frame map.

    That of rsegen's robots is their true pose in the world, so odom is map; what wheels measure
    begins at the start, as does the odometry of other robots.
    """
    coordinates = [part for key in COORDINATES for part in (f'--{{key}}', str(pose[key]))]
    return Node(
        package='tf2_ros', executable='static_transform_publisher', name=f'{{name}}_frame',
        arguments=[*coordinates, '--frame-id', 'map', '--child-frame-id', name],
        condition=condition, output='screen',
    )
'''

TIME_ARGUMENT = """\
TIME = DeclareLaunchArgument(
    'use_sim_time', default_value='false', description='true: a simulation runs, use /clock')
"""
"""The argument of nodes that run with a simulation and without."""

MAP_SERVER = f'''\
"""Publish the occupancy grid of a map on /map, with the lifecycle manager that activates it."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

{MAP_ARGUMENT}{TIME_ARGUMENT}

def generate_launch_description():
    """Return the map server and its lifecycle manager."""
    use_sim_time = LaunchConfiguration('use_sim_time')
    manager = {{'use_sim_time': use_sim_time, 'autostart': True, 'node_names': ['map_server']}}
    return LaunchDescription([
        MAP,
        TIME,
        OpaqueFunction(function=map_server),
        Node(
            package='nav2_lifecycle_manager', executable='lifecycle_manager',
            name='lifecycle_manager_map', parameters=[manager], output='screen',
        ),
    ])


def map_server(context):
    """Return the map server with the occupancy grid of the map."""
    grid = SHARE / 'maps' / LaunchConfiguration('map').perform(context) / 'map.yaml'
    parameters = {{
        'use_sim_time': LaunchConfiguration('use_sim_time'),
        'yaml_filename': str(grid),
        'frame_id': 'map',
    }}
    return [Node(
        package='nav2_map_server', executable='map_server', name='map_server',
        parameters=[parameters], output='screen',
    )]
'''

NAVIGATION = f'''\
"""Start Nav2 for a robot on a map: planner, controller, recoveries, navigator and map server."""

import os
from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

{MAP_ARGUMENT}{TIME_ARGUMENT}ROBOTS = sorted(path.name for path in (SHARE / 'robots').iterdir())
NODES = {{
    'planner_server': 'nav2_planner',
    'controller_server': 'nav2_controller',
    'behavior_server': 'nav2_behaviors',
    'bt_navigator': 'nav2_bt_navigator',
}}
# Up to Iron, these plug-ins have a slash in their names.
BETWEEN = '/' if os.environ.get('ROS_DISTRO') in ('humble', 'iron') else '::'
PLUGINS = {{
    'GridBased.plugin': f'nav2_navfn_planner{{BETWEEN}}NavfnPlanner',
    'spin.plugin': f'nav2_behaviors{{BETWEEN}}Spin',
    'backup.plugin': f'nav2_behaviors{{BETWEEN}}BackUp',
    'wait.plugin': f'nav2_behaviors{{BETWEEN}}Wait',
}}


def generate_launch_description():
    """Return the map server, Nav2's nodes and their lifecycle manager."""
    use_sim_time = LaunchConfiguration('use_sim_time')
    manager = {{'use_sim_time': use_sim_time, 'autostart': True, 'node_names': list(NODES)}}
    server = PythonLaunchDescriptionSource(str(SHARE / 'launch' / 'map_server.launch.py'))
    return LaunchDescription([
        MAP,
        TIME,
        DeclareLaunchArgument(
            'robot', default_value='@ROBOT@',
            description=f"{{', '.join(ROBOTS)}}, or any other with nav2_params"),
        DeclareLaunchArgument(
            'nav2_params', default_value='',
            description='file with the parameters of your robot, as robots/KIND/nav2.yaml'),
        IncludeLaunchDescription(
            server, launch_arguments={{'use_sim_time': use_sim_time}}.items()),
        OpaqueFunction(function=nodes),
        Node(
            package='nav2_lifecycle_manager', executable='lifecycle_manager',
            name='lifecycle_manager_navigation', parameters=[manager], output='screen',
        ),
    ])


def nodes(context):
    """Return Nav2's nodes, under their own names, with the parameters of the robot."""
    kind = LaunchConfiguration('robot').perform(context)
    given = LaunchConfiguration('nav2_params').perform(context)
    if not given and kind not in ROBOTS:
        raise RuntimeError(f"give robot:={{', '.join(ROBOTS)}}, or nav2_params:=FILE of your robot")
    own = Path(given).expanduser().absolute() if given else SHARE / 'robots' / kind / 'nav2.yaml'
    if not own.is_file():
        raise RuntimeError(f'nav2_params: {{own}} is not a file')
    parameters = [
        str(SHARE / 'config' / 'nav2.yaml'), str(own),
        {{'use_sim_time': LaunchConfiguration('use_sim_time'), **PLUGINS}},
    ]
    return [
        Node(package=package, executable=name, parameters=parameters, output='screen')
        for name, package in NODES.items()
    ]
'''

ELEVATION = f'''\
"""Publish heights and friction of a map on /elevation, as grid_map_msgs/GridMap."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

{MAP_ARGUMENT}{TIME_ARGUMENT}

def generate_launch_description():
    """Return the node."""
    return LaunchDescription([MAP, TIME, OpaqueFunction(function=elevation)])


def elevation(context):
    """Return the node that publishes the layers of the map."""
    folder = SHARE / 'maps' / LaunchConfiguration('map').perform(context)
    parameters = {{
        'use_sim_time': LaunchConfiguration('use_sim_time'),
        'folder': str(folder),
    }}
    return [Node(
        executable='python3', arguments=[str(SHARE / 'nodes' / 'elevation.py')],
        name='elevation', parameters=[parameters], output='screen',
    )]
'''

RVIZ = f'''\
"""Show a map in RViz, and what is published of robot, odometry, scan, paths and elevation."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

{MAP_ARGUMENT}{TIME_ARGUMENT}NAMESPACE = '{NAMESPACE}'


def generate_launch_description():
    """Return the nodes that describe the map, and RViz."""
    return LaunchDescription([
        MAP,
        TIME,
        DeclareLaunchArgument('rviz', default_value='true', description='false: publish alone'),
        OpaqueFunction(function=description),
        Node(
            package='rviz2', executable='rviz2', name='rviz2',
            arguments=['-d', str(SHARE / 'config' / 'map.rviz')],
            parameters=[{{'use_sim_time': LaunchConfiguration('use_sim_time')}}],
            condition=IfCondition(LaunchConfiguration('rviz')), output='screen',
        ),
    ])


def description(context):
    """Return the publishers of the URDF of the map and of its place in the frame map."""
    name = LaunchConfiguration('map').perform(context)
    urdf = (SHARE / 'urdf' / name / f'{{name}}.urdf').read_text()
    parameters = {{
        'use_sim_time': LaunchConfiguration('use_sim_time'),
        'robot_description': ParameterValue(urdf, value_type=str),
    }}
    return [
        Node(
            package='robot_state_publisher', executable='robot_state_publisher',
            namespace=NAMESPACE, parameters=[parameters], output='screen',
        ),
        Node(
            package='tf2_ros', executable='static_transform_publisher', namespace=NAMESPACE,
            arguments=['--frame-id', 'map', '--child-frame-id', name], output='screen',
        ),
    ]
'''

TEST = '''\
"""Every launch file of this package can be loaded, and every map has all of its files."""

from pathlib import Path

from launch.launch_description_sources import get_launch_description_from_python_launch_file
import pytest

PACKAGE = Path(__file__).absolute().parents[1]
LAUNCH_FILES = sorted((PACKAGE / 'launch').glob('*.launch.py'))
MAPS = sorted(path.stem for path in (PACKAGE / 'worlds').glob('*.world'))


@pytest.mark.parametrize('file', LAUNCH_FILES, ids=lambda file: file.name)
def test_launch_file_can_be_loaded(file):
    """Read it as ros2 launch does; nothing is started."""
    assert get_launch_description_from_python_launch_file(str(file)).entities


@pytest.mark.parametrize('name', MAPS)
def test_map_is_complete(name):
    """Look for what the launch files open."""
    for path in (
        f'maps/{name}/map.yaml', f'maps/{name}/map.pgm', f'maps/{name}/start_poses.json',
        f'maps/{name}/elevation.json', f'maps/{name}/elevation.npy', f'maps/{name}/friction.npy',
        f'models/{name}/model.sdf', f'urdf/{name}/{name}.urdf',
    ):
        assert (PACKAGE / path).is_file(), path
'''
