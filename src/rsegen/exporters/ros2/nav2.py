"""Nav2's parameters that are the same for all robots, as text; those of a robot are in a file of its own.

Only what differs from Nav2's defaults is in it, with names that Humble and Jazzy have both: a planner of paths on the
occupancy grid, a controller that follows them and turns on the spot, and costmaps of the grid and what the lidar sees.
Numbers have a point, since ROS takes 1 for an integer. The names of two kinds of plug-ins differ by distribution, and
stand in the launch file.
"""

from __future__ import annotations

_STATIC = """\
      static_layer:
        plugin: nav2_costmap_2d::StaticLayer
        map_subscribe_transient_local: true
"""

_OBSTACLES = """\
      obstacle_layer:
        plugin: nav2_costmap_2d::ObstacleLayer
        observation_sources: scan
        scan:
          topic: /scan
          data_type: LaserScan
          max_obstacle_height: 2.0
          marking: true
          clearing: true
"""

_INFLATION = """\
      inflation_layer:
        plugin: nav2_costmap_2d::InflationLayer
        cost_scaling_factor: 3.0
"""


def _costmap(name: str, own: str, layers: str) -> str:
    return f"""\
{name}_costmap:
  {name}_costmap:
    ros__parameters:
      robot_base_frame: base_link
{own}{layers}"""


_LAYERS = "      plugins: [static_layer, obstacle_layer, inflation_layer]\n" + _STATIC + _OBSTACLES + _INFLATION

NAV2 = (
    """\
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
"""
    + _costmap(
        "local",
        """\
      global_frame: odom
      rolling_window: true
      width: 4
      height: 4
      resolution: 0.05
      update_frequency: 5.0
      publish_frequency: 2.0
""",
        _LAYERS,
    )
    + _costmap(
        "global",
        """\
      global_frame: map
      update_frequency: 1.0
      publish_frequency: 1.0
""",
        _LAYERS,
    )
)
