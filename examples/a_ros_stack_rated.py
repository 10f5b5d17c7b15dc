"""Rate a ROS 2 stack: a Jackal in MuJoCo sends /odom and /clock and takes /cmd_vel, as on a real robot.

    python a_ros_stack_rated.py           rates what answers, after use_sim_time is set in your stack
    python a_ros_stack_rated.py --stack   a small stack to try it with, in another shell

ROS 2 speaks DDS, so this side needs no ROS: `pip install cyclonedds`. Both have one ROS_DOMAIN_ID.
"""

import os
import sys
from math import atan2, cos, sin
from time import monotonic, sleep

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct
from cyclonedds.idl.types import array, float64, int32, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

import rsegen

RUBBLE = rsegen.Recipe(name="rubble", boundary="none", obstacles=[rsegen.Random(levels=4)])
PATIENCE = 10.0  # seconds of a clock on the wall in which a stack has to answer


def message(package: str, name: str, **fields: type) -> type:
    """Return a message of ROS 2 as DDS has it."""
    return make_idl_struct(name, f"{package}.msg.dds_.{name}_", fields)


Time = message("builtin_interfaces", "Time", sec=int32, nanosec=uint32)
Clock = message("rosgraph_msgs", "Clock", clock=Time)
Header = message("std_msgs", "Header", stamp=Time, frame_id=str)
Vector3 = message("geometry_msgs", "Vector3", x=float64, y=float64, z=float64)
Point = message("geometry_msgs", "Point", x=float64, y=float64, z=float64)
Quaternion = message("geometry_msgs", "Quaternion", x=float64, y=float64, z=float64, w=float64)
Pose = message("geometry_msgs", "Pose", position=Point, orientation=Quaternion)
Twist = message("geometry_msgs", "Twist", linear=Vector3, angular=Vector3)
PoseCovariance = message("geometry_msgs", "PoseWithCovariance", pose=Pose, covariance=array[float64, 36])
TwistCovariance = message("geometry_msgs", "TwistWithCovariance", twist=Twist, covariance=array[float64, 36])
Odometry = message(
    "nav_msgs", "Odometry", header=Header, child_frame_id=str, pose=PoseCovariance, twist=TwistCovariance
)


def twist(ahead: float, turn: float) -> Twist:
    """Return a speed, m/s, and a turn rate, rad/s."""
    return Twist(Vector3(ahead, 0.0, 0.0), Vector3(0.0, 0.0, turn))


class Node:
    """The topics of a robot, from its own side or from the stack's."""

    def __init__(self, *, of_robot: bool) -> None:
        self.participant = DomainParticipant(int(os.environ.get("ROS_DOMAIN_ID", "0")))
        qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
        odom, clock, command = (
            Topic(self.participant, f"rt/{name}", of, qos=qos)
            for name, of in (("odom", Odometry), ("clock", Clock), ("cmd_vel", Twist))
        )
        self.sends = [DataWriter(self.participant, to, qos=qos) for to in ((odom, clock) if of_robot else (command,))]
        self.takes = DataReader(self.participant, command if of_robot else odom, qos=qos)

    def newest(self, until: float):
        """Return the newest message, at the latest at this time; None if there is none."""
        while monotonic() < until:
            if messages := [message for message in self.takes.take(N=10) if isinstance(message, IdlStruct)]:
                return messages[-1]
            sleep(0.0002)
        return None


def stack() -> None:
    """A stack in five lines: drive east, and back to the middle of the lane."""
    node = Node(of_robot=False)
    while True:
        if (seen := node.newest(monotonic() + 1)) is not None:
            at = seen.pose.pose
            heading = 2 * atan2(at.orientation.z, at.orientation.w)
            node.sends[0].write(twist(0.4, -1.5 * heading - at.position.y))


class RosStack:
    """Drives a Jackal over a field by the commands of a stack, a tenth of a second at a time."""

    def __init__(self) -> None:
        self.node = Node(of_robot=True)

    def __call__(self, field: rsegen.StepField, seed: int) -> bool:
        """Return whether it gets across."""
        from rsegen.training.crossing import Crossing
        from rsegen.training.gymnasium import CrossingEnv

        env = CrossingEnv(Crossing(recipe=rsegen.recipe_of(field), robot="jackal", seconds=20))
        env.reset(seed=seed)
        is_over = is_late = False
        while not (is_over or is_late):
            v, w = self.command_at(env.world.data)
            drive = env.crossing.driven.drive
            _, _, is_over, is_late, info = env.step([v / drive.speed, w / drive.turn])
        return info["is_across"]

    def command_at(self, data) -> tuple[float, float]:
        """Say where the robot is, and return its command, m/s and rad/s: the world waits for the answer."""
        stamp = Time(int(data.time), int(data.time % 1 * 1e9))
        x, y, z, qw, qx, qy, qz = data.qpos[:7]
        yaw = 2 * atan2(qz, qw)
        speed = twist(cos(yaw) * data.qvel[0] + sin(yaw) * data.qvel[1], data.qvel[5])
        unknown = [0.0] * 36
        pose = PoseCovariance(Pose(Point(x, y, z), Quaternion(qx, qy, qz, qw)), unknown)
        odometry = Odometry(Header(stamp, "odom"), "base_link", pose, TwistCovariance(speed, unknown))
        until = monotonic() + PATIENCE
        while monotonic() < until:  # again, as what is sent before the stack is found is lost
            self.node.sends[1].write(Clock(stamp))
            self.node.sends[0].write(odometry)
            if (told := self.node.newest(monotonic() + 1)) is not None:
                return told.linear.x, told.angular.z
        raise SystemExit("nothing answers /odom with /cmd_vel: is your stack running, with this ROS_DOMAIN_ID?")


if __name__ == "__main__":
    if sys.argv[1:] == ["--stack"]:
        stack()
    rating = rsegen.rate(RosStack(), RUBBLE, seed=7, trials=24)
    print(*rating.report(), sep="\n")
