"""The launch files that publish the occupancy grid of a map and show the map in RViz, and their test in the package.

map_server is a lifecycle node: it publishes nothing until the lifecycle manager configures and activates it.
"""

from __future__ import annotations

from rsegen.exporters.ros2.gazebo_launch import MAP_ARGUMENT
from rsegen.exporters.ros2.rviz import NAMESPACE

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
