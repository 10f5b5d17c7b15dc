"""Open a map in Gazebo Classic (up to ROS 2 Iron), and spawn a robot; Gazebo publishes /clock."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import AppendEnvironmentVariable, DeclareLaunchArgument
from launch.actions import IncludeLaunchDescription, OpaqueFunction
from launch.conditions import evaluate_condition_expression
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.substitutions import FindPackageShare

SHARE = Path(__file__).absolute().parents[1]
MAPS = sorted(path.stem for path in (SHARE / 'worlds').glob('*.world') if path.is_file())
MAP = DeclareLaunchArgument('map', default_value=MAPS[0], choices=MAPS, description='the map')


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
        # First: another package may have a model of the same name.
        AppendEnvironmentVariable('GAZEBO_MODEL_PATH', str(SHARE / 'models'), prepend=True),
        OpaqueFunction(function=checked),
        # Gazebo is last: if an argument of the robot is wrong, it is not started.
        IncludeLaunchDescription(spawner, launch_arguments={'simulator': 'classic'}.items()),
        OpaqueFunction(function=gazebo),
    ])


def checked(context):
    """Raise the errors of the arguments, before anything has started."""
    for name in ('paused', 'headless', 'verbose', 'gui'):
        lower(context, name)


def gazebo(context):
    """Return the server with the world of the map, and the window unless there is to be none."""
    world = SHARE / 'worlds' / f"{LaunchConfiguration('map').perform(context)}.world"
    verbose = lower(context, 'verbose')
    arguments = {
        'world': str(world),
        'pause': lower(context, 'paused'),
        'verbose': verbose,
        'server_required': 'true',
    }
    found = [included('gzserver.launch.py', arguments)]
    if lower(context, 'gui') == 'true' and lower(context, 'headless') == 'false':
        found.append(included('gzclient.launch.py', {'verbose': verbose}))
    return found


def included(name, arguments):
    """Return a launch file of gazebo_ros with arguments."""
    source = PythonLaunchDescriptionSource([FindPackageShare('gazebo_ros'), f'/launch/{name}'])
    return IncludeLaunchDescription(source, launch_arguments=arguments.items())


def lower(context, name):
    """Return an argument as gazebo_ros compares it: true or false."""
    value = evaluate_condition_expression(context, [LaunchConfiguration(name)])
    return str(value).lower()
