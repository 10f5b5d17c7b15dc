"""Publish the occupancy grid of a map on /map, with the lifecycle manager that activates it."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

SHARE = Path(__file__).absolute().parents[1]
MAPS = sorted(path.stem for path in (SHARE / 'worlds').glob('*.world') if path.is_file())
MAP = DeclareLaunchArgument('map', default_value=MAPS[0], choices=MAPS, description='the map')
TIME = DeclareLaunchArgument(
    'use_sim_time', default_value='false', description='true: a simulation runs, use /clock')


def generate_launch_description():
    """Return the map server and its lifecycle manager."""
    use_sim_time = LaunchConfiguration('use_sim_time')
    manager = {'use_sim_time': use_sim_time, 'autostart': True, 'node_names': ['map_server']}
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
    parameters = {
        'use_sim_time': LaunchConfiguration('use_sim_time'),
        'yaml_filename': ParameterValue(str(grid), value_type=str),
        'frame_id': 'map',
    }
    return [Node(
        package='nav2_map_server', executable='map_server', name='map_server',
        parameters=[parameters], output='screen',
    )]
