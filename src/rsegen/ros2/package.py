"""The files that all ROS 2 packages of maps share: manifest, build file, launch files, configurations.

    name of the package, files of robots --common_files--> the text of each file

Its Python is in package_files, as it is written but for @ROBOT@, the robot that is spawned by default: launch files, a
node and a test. They are of ROS's style (ament_flake8: single quotes, lines of at most 99 characters), and look for
maps and robots in the folder of the package, so packages of one name can be joined: only the maps differ. Robots and
bridges use the time of the simulation, which runs there in any case; files that run without one too have the argument
`use_sim_time`, which is false unless gazebo_sim.launch.py includes them. colcon and rosdep read package.xml,
CMakeLists.txt and the environment hook.

A Gazebo Sim server loads the systems of its configuration for a world that names none, as the package's worlds do. Up
to 6.7 it loads only these, so physics, user commands and scene broadcaster are named too. The names are those of the
installed version: `ignition-gazebo-...` in Fortress, `gz-sim-...` from Garden on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.resources import files

from rsegen.robots.drives import system_name
from rsegen.ros2.configuration import CLOCK, RVIZ_CONFIG, bridge_yaml, robot_topics

_PACKAGE_XML = """\
<?xml version="1.0"?>
<package format="3">
  <name>@PACKAGE@</name>
  <version>1.0.0</version>
  <description>Random Step Environments as worlds and models for Gazebo, RViz and Nav2; made by rsegen.</description>
  <maintainer email="you@example.com">you</maintainer>
  <license file="LICENSE">Apache-2.0</license>
  <url type="website">https://example.com</url>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <exec_depend>grid_map_msgs</exec_depend>
  <exec_depend>grid_map_rviz_plugin</exec_depend>
  <exec_depend>launch</exec_depend>
  <exec_depend>launch_ros</exec_depend>
  <exec_depend>nav2_behaviors</exec_depend>
  <exec_depend>nav2_bt_navigator</exec_depend>
  <exec_depend>nav2_controller</exec_depend>
  <exec_depend>nav2_costmap_2d</exec_depend>
  <exec_depend>nav2_lifecycle_manager</exec_depend>
  <exec_depend>nav2_map_server</exec_depend>
  <exec_depend>nav2_navfn_planner</exec_depend>
  <exec_depend>nav2_planner</exec_depend>
  <exec_depend>nav2_regulated_pure_pursuit_controller</exec_depend>
  <exec_depend>python3-numpy</exec_depend>
  <exec_depend>rclpy</exec_depend>
  <exec_depend>robot_state_publisher</exec_depend>
  <exec_depend>ros_gz_bridge</exec_depend>
  <exec_depend>ros_gz_sim</exec_depend>
  <exec_depend>rviz2</exec_depend>
  <exec_depend>sdformat_urdf</exec_depend>
  <exec_depend>std_msgs</exec_depend>
  <exec_depend>teleop_twist_keyboard</exec_depend>
  <exec_depend>tf2_ros</exec_depend>
  <exec_depend>xacro</exec_depend>
  <exec_depend condition="$ROS_DISTRO == humble or $ROS_DISTRO == iron">gazebo_ros</exec_depend>
  <test_depend>ament_cmake_flake8</test_depend>
  <test_depend>ament_cmake_lint_cmake</test_depend>
  <test_depend>ament_cmake_pep257</test_depend>
  <test_depend>ament_cmake_xmllint</test_depend>
  <test_depend>ament_cmake_pytest</test_depend>
  <test_depend>ament_lint_auto</test_depend>
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""
"""The manifest, of format 3 (REP 149), whose conditions leave out gazebo_ros from Jazzy on, which has none."""

_CMAKE_LISTS = """\
cmake_minimum_required(VERSION 3.8)
project(@PACKAGE@ NONE)

find_package(ament_cmake REQUIRED)

install(FILES LICENSE README.md DESTINATION share/${PROJECT_NAME})
install(
  DIRECTORY config launch maps models nodes robots urdf worlds
  DESTINATION share/${PROJECT_NAME}
)
ament_environment_hooks("${CMAKE_CURRENT_SOURCE_DIR}/env-hooks/${PROJECT_NAME}.dsv.in")

if(BUILD_TESTING)
  find_package(ament_lint_auto QUIET)
  if(ament_lint_auto_FOUND)
    ament_lint_auto_find_test_dependencies()
  endif()
  find_package(ament_cmake_pytest QUIET)
  if(ament_cmake_pytest_FOUND)
    ament_add_pytest_test(launch_files test/test_launch_files.py)
  endif()
endif()

ament_package()
"""
"""The build file: nothing is compiled, and the hook adds the models to Gazebo's search paths.

If ROS's linters and pytest are not installed, it builds without tests.
"""

ENVIRONMENT_HOOK = "".join(
    f"prepend-non-duplicate;{variable};share/@PROJECT_NAME@/models\n"
    for variable in ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
)
"""The search paths for models of Gazebo Classic, Gazebo Sim and Ignition."""

_SYSTEMS = (
    *("Physics", "UserCommands", "SceneBroadcaster", "Sensors", "Imu", "Contact"),
    *("Altimeter", "ForceTorque", "Magnetometer", "NavSat"),
)
"""Systems of a server."""


def _config(backend: str) -> str:
    """Return the server's configuration; backend: as of `system_name`."""
    plugins = ""
    for kind in _SYSTEMS:
        name, parameters = system_name(kind, backend), "<render_engine>ogre2</render_engine>" * (kind == "Sensors")
        plugins += f"""\
    <plugin entity_name="*" entity_type="world"
            filename="{name.library}"
            name="{name.class_name}">{parameters}</plugin>
"""
    return f"<server_config>\n  <plugins>\n{plugins}  </plugins>\n</server_config>\n"


_LAYERS = """\
      plugins: [static_layer, obstacle_layer, inflation_layer]
      static_layer:
        plugin: nav2_costmap_2d::StaticLayer
        map_subscribe_transient_local: true
      obstacle_layer:
        plugin: nav2_costmap_2d::ObstacleLayer
        observation_sources: scan
        scan:
          topic: /scan
          data_type: LaserScan
          max_obstacle_height: 2.0
          marking: true
          clearing: true
      inflation_layer:
        plugin: nav2_costmap_2d::InflationLayer
        cost_scaling_factor: 3.0
"""

_NAV2 = f"""\
# Nav2's parameters for all robots; robots/KIND/nav2.yaml has those of one
planner_server:
  ros__parameters:
    planner_plugins: [GridBased]
    GridBased:
      tolerance: 0.2
      use_astar: false
      allow_unknown: true
controller_server:
  ros__parameters:
    controller_plugins: [FollowPath]
    enable_stamped_cmd_vel: false  # the bridge takes geometry_msgs/Twist
    FollowPath:
      plugin: nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController
      use_velocity_scaled_lookahead_dist: false
      use_rotate_to_heading: true
      allow_reversing: false
behavior_server:
  ros__parameters:
    behavior_plugins: [spin, backup, wait]
    enable_stamped_cmd_vel: false
bt_navigator:
  ros__parameters:
    global_frame: map
    robot_base_frame: base_link
    odom_topic: /odom
local_costmap:
  local_costmap:
    ros__parameters:
      robot_base_frame: base_link
      global_frame: odom
      rolling_window: true
      width: 4
      height: 4
      resolution: 0.05
      update_frequency: 5.0
      publish_frequency: 2.0
{_LAYERS}global_costmap:
  global_costmap:
    ros__parameters:
      robot_base_frame: base_link
      global_frame: map
      update_frequency: 1.0
      publish_frequency: 1.0
{_LAYERS}"""
"""Nav2's parameters that all robots share, only where they differ from its defaults, by names of both Humble and
Jazzy. Numbers have a point, since ROS takes 1 for an integer; plug-ins whose names differ stand in the launch file."""


PYTHON = (
    "launch/elevation.launch.py",
    "launch/gazebo_classic.launch.py",
    "launch/gazebo_sim.launch.py",
    "launch/map_server.launch.py",
    "launch/navigation.launch.py",
    "launch/rviz.launch.py",
    "launch/spawn_robot.launch.py",
    "nodes/elevation.py",
    "test/test_launch_files.py",
)
"""The files of package_files."""


def common_files(package: str, robots: Mapping[str, Mapping[str, str]], robot: str) -> Mapping[str, str]:
    """Return the text of each file of a package of this name by its path, except the files of its maps.

    robots: the files of each robot by its kind; robot: the one that is spawned by default, or `none`
    """
    folder = files("rsegen.ros2")
    # Launch files and nodes are files of their own, which tests run; the rest is text with a few values filled in.
    python = {path: folder.joinpath("package_files", path).read_text("utf-8") for path in PYTHON}
    own = "topics of a robot of your own: those of Gazebo Sim's plug-ins for a model named robot"
    return {
        "LICENSE": folder.joinpath("LICENSE").read_text("utf-8"),
        "README.md": _readme(package, robots),
        "package.xml": _PACKAGE_XML.replace("@PACKAGE@", package),
        "CMakeLists.txt": _CMAKE_LISTS.replace("@PACKAGE@", package),
        f"env-hooks/{package}.dsv.in": ENVIRONMENT_HOOK,
        "config/clock_bridge.yaml": bridge_yaml("the time of Gazebo Sim", [CLOCK]),
        "config/fortress_server.config": _config("fortress"),
        "config/map.rviz": RVIZ_CONFIG,
        "config/nav2.yaml": _NAV2,
        "config/robot_bridge.yaml": bridge_yaml(own, robot_topics()),
        "config/server.config": _config("sim"),
        **{path: text.replace("@ROBOT@", robot) for path, text in python.items()},
        **{f"robots/{kind}/{name}": text for kind, texts in robots.items() for name, text in texts.items()},
    }


def _readme(package: str, robots: Iterable[str]) -> str:
    """Return the README of a package: what its files are, one line for each thing to do, and its topics."""
    # A table for each question of who opens the package: how is it used, what is in it, what does it publish?
    nav2 = f"`ros2 launch {package} gazebo_sim.launch.py robot:=jackal start:=ground rviz:=true nav2:=true`"
    kinds = ", ".join(f"`{kind}`" for kind in robots)
    return f"""\
# {package}

Random Step Environments (NIST stepfields) for Gazebo, RViz and Nav2, with robots; made by rsegen.
For ROS 2 Humble with Gazebo Fortress (from 6.16) and for Jazzy with Gazebo Harmonic.

    rosdep install --from-paths src --ignore-src -y     # in the workspace, once
    colcon build && . install/setup.bash

| to | command |
|---|---|
| open a map | `ros2 launch {package} gazebo_sim.launch.py` |
| spawn a robot | `ros2 launch {package} gazebo_sim.launch.py robot:=jackal` |
| drive it by keys | `ros2 run teleop_twist_keyboard teleop_twist_keyboard` |
| see all in RViz | `ros2 launch {package} gazebo_sim.launch.py robot:=jackal rviz:=true` |
| drive to goals with Nav2 | {nav2} |
| publish the true heights | `ros2 launch {package} elevation.launch.py use_sim_time:=true` |

`robot` is one of {kinds}, or a file: URDF, Xacro or SDF. `map` chooses a map; each launch file
lists its arguments with `--show-args`. Nav2 takes goals from RViz's tool *2D Goal Pose*. The tracks
of the crawler move in Harmonic, not in Fortress.

| file | what it is |
|---|---|
| `launch/gazebo_sim.launch.py` | opens Gazebo Sim and includes the others on request |
| `launch/gazebo_classic.launch.py` | opens Gazebo Classic; robots from files |
| `launch/spawn_robot.launch.py` | spawns a robot in a Gazebo that runs, with its frames and bridge |
| `launch/rviz.launch.py` | RViz, and the map's own description |
| `launch/navigation.launch.py`, `launch/map_server.launch.py` | Nav2, and the map for it |
| `launch/elevation.launch.py`, `nodes/elevation.py` | the map as grid_map |
| `robots/KIND` | a robot: URDF, model for Gazebo, topics of the bridge, parameters of Nav2 |
| `config` | RViz, Nav2, the bridge of a robot of your own, the systems of Gazebo's server |
| `maps/NAME` | occupancy grid, heights, friction, and where robots start |
| `models`, `urdf`, `worlds` | the map for Gazebo and RViz |

| topic | type | |
|---|---|---|
| `/cmd_vel` | geometry_msgs/Twist | drives the robot |
| `/JOINT/angle` | std_msgs/Float64 | turns a flipper or a joint of the arm, radians |
| `/odom`, `/tf` | nav_msgs/Odometry | the true pose in 3D: `odom` is the frame of the world |
| `/wheel_odometry` | nav_msgs/Odometry | what wheels or tracks measure, in the frame `wheel_odom` |
| `/joint_states`, `/imu`, `/scan` | sensor_msgs/JointState, Imu, LaserScan | joints and sensors |
| `/map` | nav_msgs/OccupancyGrid | what is too high to climb from the ground |
| `/elevation` | grid_map_msgs/GridMap | layers `elevation` (m) and `friction`, latched: the ground truth |
| `/clock` | rosgraph_msgs/Clock | the time of the simulation |

`map` to `odom` is fixed, as the pose is the true one; if SLAM or AMCL is to publish it, give
`localized:=false`. Without a simulation leave `use_sim_time` at false, its default.
"""
