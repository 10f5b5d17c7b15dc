"""Open a map in Gazebo Sim with a clock for ROS, and a robot; on request with RViz and Nav2."""

from pathlib import Path
from shlex import quote

from launch import LaunchDescription
from launch.actions import AppendEnvironmentVariable, DeclareLaunchArgument
from launch.actions import IncludeLaunchDescription, OpaqueFunction, SetEnvironmentVariable
from launch.conditions import evaluate_condition_expression, IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

SHARE = Path(__file__).absolute().parents[1]
MAPS = sorted(path.stem for path in (SHARE / 'worlds').glob('*.world') if path.is_file())
MAP = DeclareLaunchArgument('map', default_value=MAPS[0], choices=MAPS, description='the map')

CONFIGS = {
    'IGN_GAZEBO_SERVER_CONFIG_PATH': SHARE / 'config' / 'fortress_server.config',
    'GZ_SIM_SERVER_CONFIG_PATH': SHARE / 'config' / 'server.config',
}
CLOCK = str(SHARE / 'config' / 'clock_bridge.yaml')
ON_REQUEST = {
    'rviz': ('rviz.launch.py', 'show all in RViz'),
    'nav2': ('navigation.launch.py', 'drive to goals with Nav2'),
    'elevation': ('elevation.launch.py', 'publish the map as grid_map'),
}


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
        # First: another package may have a model of the same name.
        *(AppendEnvironmentVariable(name, str(SHARE / 'models'), prepend=True)
          for name in ('IGN_GAZEBO_RESOURCE_PATH', 'GZ_SIM_RESOURCE_PATH')),
        OpaqueFunction(function=checked),
        OpaqueFunction(function=gazebo),
        Node(
            package='ros_gz_bridge', executable='parameter_bridge', name='clock_bridge',
            parameters=[{'config_file': ParameterValue(CLOCK, value_type=str)}],
            output='screen',
        ),
        included('spawn_robot.launch.py', {'simulator': 'sim'}),
        *(included(file, {'use_sim_time': 'true'}, IfCondition(LaunchConfiguration(name)))
          for name, (file, _) in ON_REQUEST.items()),
    ])


def checked(context):
    """
    Raise the errors of the arguments of the included files, before anything has started.

    If one is raised later, launch ends and leaves what it has started, such as Gazebo.
    """
    requested = [file for name, (file, _) in ON_REQUEST.items() if is_true(context, name)]
    for file in ('spawn_robot.launch.py', *requested):
        source = PythonLaunchDescriptionSource(str(SHARE / 'launch' / file))
        for entity in source.get_launch_description(context).entities:
            if isinstance(entity, (DeclareLaunchArgument, OpaqueFunction)):
                entity.execute(context)  # it returns what would be started


def included(name, arguments, condition=None):
    """Return another launch file of this package with arguments."""
    source = PythonLaunchDescriptionSource(str(SHARE / 'launch' / name))
    return IncludeLaunchDescription(
        source, launch_arguments=arguments.items(), condition=condition)


def gazebo(context):
    """Return Gazebo Sim with the world of the map."""
    world = SHARE / 'worlds' / f"{LaunchConfiguration('map').perform(context)}.world"
    source = [FindPackageShare('ros_gz_sim'), '/launch/gz_sim.launch.py']
    arguments = {
        'gz_args': f'{options(context)} {quote(str(world))}',
        'on_exit_shutdown': 'true',
    }
    return [IncludeLaunchDescription(
        PythonLaunchDescriptionSource(source), launch_arguments=arguments.items())]


def options(context):
    """Return the options of gz sim."""
    given = LaunchConfiguration('options').perform(context)
    if given:
        return given
    flags = {'headless': '-s --headless-rendering', 'verbose': '-v 4'}
    chosen = [flag for name, flag in flags.items() if is_true(context, name)]
    return ' '.join([*chosen, *([] if is_true(context, 'paused') else ['-r'])])


def is_true(context, name):
    """Return whether an argument is true."""
    return evaluate_condition_expression(context, [LaunchConfiguration(name)])
