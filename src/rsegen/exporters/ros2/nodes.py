"""The launch files of a package that run with a simulation and without, and the package's own test, as texts.

They have the argument `use_sim_time`, which is false unless gazebo_sim.launch.py includes them.

    MAP_SERVER    publishes the occupancy grid; a lifecycle node, so a manager has to configure and activate it
    NAVIGATION    starts Nav2's planner, controller, recoveries and navigator, and MAP_SERVER
    ELEVATION     publishes heights and friction of the map as a grid_map
    RVIZ          shows the URDF of the map, the robot, and what the others publish, in the frame map
"""

from __future__ import annotations

from rsegen.exporters.ros2.launch import MAP_ARGUMENT
from rsegen.exporters.ros2.rviz import NAMESPACE

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
