"""Publish heights and friction of a map on /elevation, as grid_map_msgs/GridMap."""

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
    """Return the node."""
    return LaunchDescription([MAP, TIME, OpaqueFunction(function=elevation)])


def elevation(context):
    """Return the node that publishes the layers of the map."""
    folder = SHARE / 'maps' / LaunchConfiguration('map').perform(context)
    parameters = {
        'use_sim_time': LaunchConfiguration('use_sim_time'),
        'folder': ParameterValue(str(folder), value_type=str),
    }
    return [Node(
        executable='python3', arguments=[str(SHARE / 'nodes' / 'elevation.py')],
        name='elevation', parameters=[parameters], output='screen',
    )]
