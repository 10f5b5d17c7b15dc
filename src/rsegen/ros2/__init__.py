"""A ROS 2 package that opens maps and drives robots on them: manifest, build file, launch files, configurations."""

from rsegen.params.capabilities import Capability

CAPABILITY = Capability(
    summary="ROS 2 packages of maps and robots",
    needs=("formats", "robots", "standing"),
    offers={"rsegen.formats": {"ros2": "rsegen.ros2.ros2"}},
    manual="ros2",
)
