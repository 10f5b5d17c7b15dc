"""Show a map in RViz, and what is published of robot, odometry, scan, paths and elevation."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

SHARE = Path(__file__).absolute().parents[1]
MAPS = sorted(path.stem for path in (SHARE / 'worlds').glob('*.world') if path.is_file())
MAP = DeclareLaunchArgument('map', default_value=MAPS[0], choices=MAPS, description='the map')
TIME = DeclareLaunchArgument(
    'use_sim_time', default_value='false', description='true: a simulation runs, use /clock')
NAMESPACE = 'step_field'


def generate_launch_description():
    """Return the nodes that describe the map, and RViz."""
    return LaunchDescription([
        MAP,
        TIME,
        DeclareLaunchArgument('rviz', default_value='true', description='false: publish alone'),
        Node(
            package='rviz2', executable='rviz2', name='rviz2',
            arguments=['-d', str(SHARE / 'config' / 'map.rviz')],
            parameters=[{'use_sim_time': LaunchConfiguration('use_sim_time')}],
            condition=IfCondition(LaunchConfiguration('rviz')), output='screen',
        ),
        OpaqueFunction(function=description),
    ])


def description(context):
    """Return the publishers of the URDF of the map and of its place in the frame map."""
    name = LaunchConfiguration('map').perform(context)
    urdf = (SHARE / 'urdf' / name / f'{name}.urdf').read_text()
    parameters = {
        'use_sim_time': LaunchConfiguration('use_sim_time'),
        'robot_description': ParameterValue(urdf, value_type=str),
    }
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
