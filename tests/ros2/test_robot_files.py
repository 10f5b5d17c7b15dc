"""Files of robots in ROS 2 packages, judged by urdfdom, MuJoCo and the tables of ros_gz_bridge and Nav2."""

from __future__ import annotations

import json
import shutil
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from rsegen.geometry.poses import rotation
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.links import SdfPose
from rsegen.ros2.robots import ROOT, ros_files
from rsegen.standing.outlines import Outline
from tests.support.missing import missing

ROBOT = pytest.mark.parametrize("robot", ROBOTS.values(), ids=list(ROBOTS))

BRIDGED = {
    ("geometry_msgs/msg/Twist", "gz.msgs.Twist"),
    ("nav_msgs/msg/Odometry", "gz.msgs.Odometry"),
    ("sensor_msgs/msg/Imu", "gz.msgs.IMU"),
    ("sensor_msgs/msg/JointState", "gz.msgs.Model"),
    ("sensor_msgs/msg/LaserScan", "gz.msgs.LaserScan"),
    ("std_msgs/msg/Float64", "gz.msgs.Double"),
    ("tf2_msgs/msg/TFMessage", "gz.msgs.Pose_V"),
}
"""Some of the pairs of types that ros_gz_bridge converts, after its mappings.py (Humble and Jazzy)."""

PUBLISHED = {
    ("OdometryPublisher", "odom_topic"): "gz.msgs.Odometry",
    ("OdometryPublisher", "tf_topic"): "gz.msgs.Pose_V",
    ("DiffDrive", "odom_topic"): "gz.msgs.Odometry",
    ("TrackedVehicle", "odom_topic"): "gz.msgs.Odometry",
    ("JointStatePublisher", "topic"): "gz.msgs.Model",
    ("imu", "topic"): "gz.msgs.IMU",
    ("gpu_lidar", "topic"): "gz.msgs.LaserScan",
}
"""Messages of Gazebo's plug-ins and sensors on the topic of an element, after their source (Fortress, Harmonic)."""


def homogeneous(pose: SdfPose) -> np.ndarray[Any, Any]:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation(*pose[3:]), pose[:3]
    return matrix


def plugins(robot: Robot) -> Iterator[tuple[str, ET.Element]]:
    """Plug-ins and sensors of its SDF model by their kind."""
    model = ET.fromstring(ros_files(robot)["model.sdf"])
    yield from ((plugin.get("name", "").rpartition("::")[2], plugin) for plugin in model.iter("plugin"))
    yield from ((sensor.get("type", ""), sensor) for sensor in model.iter("sensor"))


@pytest.mark.long(reason="check_urdf, which scripts/ros2 installs")
@ROBOT
def test_urdfdom_reads_the_links_in_a_tree_below_base_link(robot: Robot, tmp_path: Path) -> None:
    """It is the parser of robot_state_publisher and RViz."""
    program = shutil.which("check_urdf") or missing("no check_urdf: run scripts/ros2")
    file = tmp_path / "robot.urdf"
    file.write_text(ros_files(robot)[f"{robot.kind}.urdf"])
    found = subprocess.run([program, file], capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    assert f"root Link: {ROOT} has 1 child(ren)" in found.stdout
    read = {line.partition(":  ")[2] for line in found.stdout.splitlines() if "child(" in line and ":  " in line}
    assert read == {link.name for link in robot.links} | {"imu", "lidar"}


@ROBOT
def test_mujoco_puts_links_and_hinges_of_the_urdf_where_those_of_the_sdf_are(robot: Robot) -> None:
    mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed")
    text = ros_files(robot)[f"{robot.kind}.urdf"]
    whole = '<mujoco><compiler fusestatic="false" balanceinertia="false" discardvisual="false"/></mujoco></robot>'
    model = mujoco.MjModel.from_xml_string(text.replace("</robot>", whole))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for link in robot.links:
        body, at = model.body(link.name), homogeneous(link.pose)
        found = np.eye(4)
        found[:3, :3], found[:3, 3] = data.xmat[body.id].reshape(3, 3), data.xpos[body.id]
        assert np.allclose(found, at, atol=1e-8), link.name
        assert body.mass[0] == pytest.approx(link.mass)
        assert sorted(body.inertia) == pytest.approx(sorted(link.moments), rel=1e-6)
        assert np.allclose(data.xipos[body.id], (at @ homogeneous(link.centre))[:3, 3], atol=1e-8)
    hinges = [joint for joint in robot.joints if joint.axis]
    assert model.njnt == len(hinges)
    poses = {link.name: homogeneous(link.pose) for link in robot.links}
    for hinge in hinges:
        assert hinge.axis is not None
        joint, at = model.joint(hinge.name), poses[hinge.child]
        axis, anchor = at[:3, :3] @ hinge.axis, (at @ [*hinge.anchor, 1])[:3]
        assert np.allclose(data.xaxis[joint.id], axis, atol=1e-8), hinge.name
        assert np.allclose(np.cross(anchor - data.xanchor[joint.id], axis), 0, atol=1e-8), hinge.name
        ends = [hinge.lower, hinge.upper] if hinge.lower is not None else [0, 0]
        assert joint.range == pytest.approx(ends, abs=1e-8)
        assert bool(model.jnt_limited[joint.id]) == (hinge.lower is not None)
    solids = [part for link in robot.links for part in link.parts]
    assert model.ngeom == len(solids) + sum(part.surface is not None for part in solids)


@ROBOT
def test_the_bridge_joins_types_that_ros_gz_bridge_converts(robot: Robot) -> None:
    topics = yaml.safe_load(ros_files(robot)["bridge.yaml"])
    assert all(
        set(topic) == {f"{side}_{what}_name" for side in ("ros", "gz") for what in ("topic", "type")} | {"direction"}
        for topic in topics
    )
    assert {(topic["ros_type_name"], topic["gz_type_name"]) for topic in topics} <= BRIDGED
    assert len({topic["ros_topic_name"] for topic in topics}) == len(topics)


@ROBOT
def test_every_topic_to_ros_is_published_by_the_model_and_every_other_one_is_heard(robot: Robot) -> None:
    topics = yaml.safe_load(ros_files(robot)["bridge.yaml"])
    published = {
        element.findtext(tag): kind
        for name, element in plugins(robot)
        for (of, tag), kind in PUBLISHED.items()
        if of == name
    }
    to_ros = {topic["gz_topic_name"]: topic["gz_type_name"] for topic in topics if topic["direction"] == "GZ_TO_ROS"}
    assert to_ros == published
    heard = {topic["gz_topic_name"]: topic["gz_type_name"] for topic in topics if topic["direction"] == "ROS_TO_GZ"}
    turned = [plugin.findtext("joint_name") for name, plugin in plugins(robot) if name == "JointPositionController"]
    assert heard == {
        "/model/robot/cmd_vel": "gz.msgs.Twist",
        **{f"/model/robot/joint/{joint}/0/cmd_pos": "gz.msgs.Double" for joint in turned},
    }


@ROBOT
def test_frames_of_messages_are_links_of_the_urdf_or_odometry(robot: Robot) -> None:
    urdf = ET.fromstring(ros_files(robot)[f"{robot.kind}.urdf"])
    links = {link.get("name") for link in urdf.findall("link")}
    elements = dict(plugins(robot))
    drive = elements.get("DiffDrive", elements.get("TrackedVehicle"))
    assert drive is not None
    assert (drive.findtext("frame_id"), drive.findtext("child_frame_id")) == ("wheel_odom", ROOT)
    truth = elements["OdometryPublisher"]
    assert (truth.findtext("odom_frame"), truth.findtext("robot_base_frame")) == ("odom", ROOT)
    assert truth.findtext("dimensions") == "3"
    for sensor in ("imu", "gpu_lidar"):
        assert elements[sensor].findtext("gz_frame_id") in links
    placed = {name.get("name"): name.find("origin") for name in urdf.findall("joint")}
    for sensor, frame in (("imu", "imu_fixed"), ("gpu_lidar", "lidar_fixed")):
        origin = placed[frame]
        assert origin is not None
        where = [float(value) for key in ("xyz", "rpy") for value in origin.get(key, "").split()]
        assert where == pytest.approx([float(value) for value in (elements[sensor].findtext("pose") or "").split()])


def leaves(values: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", value


@ROBOT
def test_nav2_gets_the_outline_and_the_speeds_of_the_robot_as_numbers_with_a_point(robot: Robot) -> None:
    parameters = dict(leaves(yaml.safe_load(ros_files(robot)["nav2.yaml"])))
    numbers = {name: value for name, value in parameters.items() if not isinstance(value, str)}
    assert all(isinstance(value, float) for value in numbers.values())  # ROS refuses 1 for a number with a point
    assert numbers["controller_server.ros__parameters.FollowPath.desired_linear_vel"] == robot.driving_speed
    assert numbers["behavior_server.ros__parameters.max_rotational_vel"] <= robot.turn
    outline = Outline.of(robot.body)
    for costmap in ("local_costmap", "global_costmap"):
        footprint = np.array(json.loads(parameters[f"{costmap}.{costmap}.ros__parameters.footprint"]))
        assert footprint.min(axis=0) == pytest.approx([outline.low_x, outline.low_y], abs=0.001)
        assert footprint.max(axis=0) == pytest.approx([outline.high_x, outline.high_y], abs=0.001)
        sides = np.diff(footprint, axis=0, append=footprint[:1])
        assert (np.count_nonzero(sides, axis=1) == 1).all()  # corners in their order round the rectangle
        inflation = numbers[f"{costmap}.{costmap}.ros__parameters.inflation_layer.inflation_radius"]
        assert inflation > np.hypot(*footprint.T).max()
