"""The launch files of a package, the configuration of RViz, and the package's own test, as texts.

They find the maps in the folder of the package, and keep to ament_flake8: single quotes, lines of at most 99
characters.

    SIM, CLASSIC     open a world in Gazebo Sim or Gazebo Classic, and include
    SPAWN_ROBOT      which spawns a robot at the map's start pose
    MAP_SERVER       publishes the occupancy grid; a lifecycle node, so a manager has to configure and activate it
    RVIZ             shows the URDF of the map and the occupancy grid, in the frame map
"""

from __future__ import annotations

MAP_ARGUMENT = """\
SHARE = Path(__file__).absolute().parents[1]
MAPS = sorted(path.stem for path in (SHARE / 'worlds').glob('*.world'))
MAP = DeclareLaunchArgument('map', default_value=MAPS[0], choices=MAPS, description='the map')
"""
"""The folder of the package, as its source or installed, and the argument that chooses one of its maps."""

SIM = f'''\
"""Open a map in Gazebo Sim (Fortress or later) with a clock for ROS, and spawn a robot."""

import os
from pathlib import Path
from shlex import quote

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.actions import SetEnvironmentVariable
from launch.conditions import evaluate_condition_expression
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

{MAP_ARGUMENT}
MESSAGES = 'ignition.msgs' if os.environ.get('ROS_DISTRO') == 'humble' else 'gz.msgs'
CONFIGS = {{
    'IGN_GAZEBO_SERVER_CONFIG_PATH': SHARE / 'config' / 'fortress_server.config',
    'GZ_SIM_SERVER_CONFIG_PATH': SHARE / 'config' / 'server.config',
}}


def generate_launch_description():
    """Return the environment, Gazebo, the bridge of its clock, and the spawner."""
    spawner = PythonLaunchDescriptionSource(str(SHARE / 'launch' / 'spawn_robot.launch.py'))
    return LaunchDescription([
        MAP,
        DeclareLaunchArgument('paused', default_value='false', description='start paused'),
        DeclareLaunchArgument('headless', default_value='false', description='open no window'),
        DeclareLaunchArgument('verbose', default_value='false', description='print all messages'),
        DeclareLaunchArgument(
            'options', default_value='',
            description='options of gz sim, in place of paused, headless and verbose',
        ),
        DeclareLaunchArgument(
            'use_sim_time', default_value='true', description='use the time of /clock',
        ),
        # Each Gazebo reads its own variable; one that is set already stays.
        *(SetEnvironmentVariable(name, EnvironmentVariable(name, default_value=str(path)))
          for name, path in CONFIGS.items()),
        OpaqueFunction(function=gazebo),
        Node(
            package='ros_gz_bridge', executable='parameter_bridge', name='clock_bridge',
            arguments=[f'/clock@rosgraph_msgs/msg/Clock[{{MESSAGES}}.Clock'],
            parameters=[{{'use_sim_time': LaunchConfiguration('use_sim_time')}}],
            output='screen',
        ),
        IncludeLaunchDescription(spawner, launch_arguments={{'simulator': 'sim'}}.items()),
    ])


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
"""Spawn a robot at the start pose of a map, or anywhere else, in a Gazebo that is running."""

import json
from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

{MAP_ARGUMENT}
SPAWNERS = {{
    'sim': ('ros_gz_sim', 'create', '-name'),
    'classic': ('gazebo_ros', 'spawn_entity.py', '-entity'),
}}
COORDINATES = {{'x': '-x', 'y': '-y', 'z': '-z', 'yaw': '-Y'}}


def generate_launch_description():
    """Return the arguments and the spawner."""
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
            'robot_file', default_value='', description='SDF or URDF file of the robot'),
        DeclareLaunchArgument(
            'robot_topic', default_value='', description='or its topic: robot_description'),
        DeclareLaunchArgument('robot_name', default_value='robot', description='its name'),
        *coordinates,
        OpaqueFunction(function=spawner),
    ])


def spawner(context):
    """Return the node that spawns the robot, or a message if none is given."""
    def given(name):
        return LaunchConfiguration(name).perform(context)

    source = robot(given('robot_file'), given('robot_topic'))
    if not source:
        return [LogInfo(msg='No robot is spawned: robot_file and robot_topic are empty.')]
    start = json.loads((SHARE / 'maps' / given('map') / 'start_pose.json').read_text())
    pose = [part for name, flag in COORDINATES.items()
            for part in (flag, given(name) or str(start[name]))]
    package, executable, named = SPAWNERS[given('simulator')]
    arguments = [named, given('robot_name'), *source, *pose]
    return [Node(package=package, executable=executable, arguments=arguments, output='screen')]


def robot(file, topic):
    """Return the arguments that say where the robot is described."""
    if not file:
        return ['-topic', topic] if topic else []
    if '://' in file:
        return ['-file', file]
    path = Path(file).expanduser().absolute()
    if not path.is_file():
        raise RuntimeError(f'robot_file: {{path}} is not a file')
    return ['-file', str(path)]
'''

NAMESPACE = "step_field"
"""Namespace of the nodes that describe the map, so that a robot's own robot_description stays free."""

RVIZ_CONFIG = f"""\
Panels:
  - Class: rviz_common/Displays
    Name: Displays
  - Class: rviz_common/Views
    Name: Views
Visualization Manager:
  Class: ""
  Displays:
    - Class: rviz_default_plugins/RobotModel
      Name: Step field
      Enabled: true
      Value: true
      Collision Enabled: false
      Visual Enabled: true
      Description Source: Topic
      Description Topic:
        Depth: 5
        Durability Policy: Transient Local
        History Policy: Keep Last
        Reliability Policy: Reliable
        Value: /{NAMESPACE}/robot_description
    - Class: rviz_default_plugins/Map
      Name: Occupancy grid
      Enabled: true
      Value: true
      Alpha: 0.5
      Color Scheme: map
      Topic:
        Depth: 1
        Durability Policy: Transient Local
        History Policy: Keep Last
        Reliability Policy: Reliable
        Value: /map
  Enabled: true
  Global Options:
    Background Color: 48; 48; 48
    Fixed Frame: map
    Frame Rate: 30
  Name: root
  Tools:
    - Class: rviz_default_plugins/MoveCamera
    - Class: rviz_default_plugins/Select
    - Class: rviz_default_plugins/Measure
  Value: true
  Views:
    Current:
      Class: rviz_default_plugins/Orbit
      Distance: 5
      Name: Current View
      Pitch: 0.8
      Value: Orbit (rviz)
      Yaw: 4.2
    Saved: ~
"""

MAP_SERVER = f'''\
"""Publish the occupancy grid of a map on /map, with the lifecycle manager that activates it."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

{MAP_ARGUMENT}

def generate_launch_description():
    """Return the map server and its lifecycle manager."""
    use_sim_time = LaunchConfiguration('use_sim_time')
    manager = {{'use_sim_time': use_sim_time, 'autostart': True, 'node_names': ['map_server']}}
    return LaunchDescription([
        MAP,
        DeclareLaunchArgument(
            'use_sim_time', default_value='true', description='use the time of /clock',
        ),
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

RVIZ = f'''\
"""Show a map in RViz: its URDF in the frame map, and the occupancy grid if it is published."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

{MAP_ARGUMENT}
NAMESPACE = '{NAMESPACE}'


def generate_launch_description():
    """Return the nodes that describe the map, and RViz."""
    return LaunchDescription([
        MAP,
        DeclareLaunchArgument(
            'use_sim_time', default_value='true', description='use the time of /clock',
        ),
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
        f'maps/{name}/map.yaml', f'maps/{name}/map.pgm', f'maps/{name}/start_pose.json',
        f'models/{name}/model.sdf', f'urdf/{name}/{name}.urdf',
    ):
        assert (PACKAGE / path).is_file(), path
'''
