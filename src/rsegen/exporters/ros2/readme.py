"""The README of a package: what its files are, one line for each thing to do, and its topics."""

from __future__ import annotations

from collections.abc import Iterable


def readme(package: str, robots: Iterable[str]) -> str:
    """Return the text for a package of this name, with robots of these kinds."""
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
