"""Start Nav2 for a robot on a map: planner, controller, recoveries, navigator and map server."""

import os
from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

SHARE = Path(__file__).absolute().parents[1]
MAPS = sorted(path.stem for path in (SHARE / 'worlds').glob('*.world') if path.is_file())
MAP = DeclareLaunchArgument('map', default_value=MAPS[0], choices=MAPS, description='the map')
TIME = DeclareLaunchArgument(
    'use_sim_time', default_value='false', description='true: a simulation runs, use /clock')
ROBOTS = sorted(path.name for path in (SHARE / 'robots').iterdir())
NODES = {
    'planner_server': 'nav2_planner',
    'controller_server': 'nav2_controller',
    'behavior_server': 'nav2_behaviors',
    'bt_navigator': 'nav2_bt_navigator',
}
# Up to Iron, these plug-ins have a slash in their names.
BETWEEN = '/' if os.environ.get('ROS_DISTRO') in ('humble', 'iron') else '::'
PLUGINS = {
    'GridBased.plugin': f'nav2_navfn_planner{BETWEEN}NavfnPlanner',
    'spin.plugin': f'nav2_behaviors{BETWEEN}Spin',
    'backup.plugin': f'nav2_behaviors{BETWEEN}BackUp',
    'wait.plugin': f'nav2_behaviors{BETWEEN}Wait',
}


def generate_launch_description():
    """Return the map server, Nav2's nodes and their lifecycle manager."""
    use_sim_time = LaunchConfiguration('use_sim_time')
    manager = {'use_sim_time': use_sim_time, 'autostart': True, 'node_names': list(NODES)}
    server = PythonLaunchDescriptionSource(str(SHARE / 'launch' / 'map_server.launch.py'))
    return LaunchDescription([
        MAP,
        TIME,
        DeclareLaunchArgument(
            'robot', default_value='@ROBOT@',
            description=f"{', '.join(ROBOTS)}, or any other with nav2_params"),
        DeclareLaunchArgument(
            'nav2_params', default_value='',
            description='file with the parameters of your robot, as robots/KIND/nav2.yaml'),
        OpaqueFunction(function=nodes),  # first: if an argument is wrong, nothing is started
        IncludeLaunchDescription(
            server, launch_arguments={'use_sim_time': use_sim_time}.items()),
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
        raise RuntimeError(f"give robot:={', '.join(ROBOTS)}, or nav2_params:=FILE of your robot")
    own = Path(given).expanduser().absolute() if given else SHARE / 'robots' / kind / 'nav2.yaml'
    if not own.is_file():
        raise RuntimeError(f'nav2_params: {own} is not a file')
    parameters = [
        str(SHARE / 'config' / 'nav2.yaml'), str(own),
        {'use_sim_time': LaunchConfiguration('use_sim_time'), **PLUGINS},
    ]
    return [
        Node(package=package, executable=name, parameters=parameters, output='screen')
        for name, package in NODES.items()
    ]
