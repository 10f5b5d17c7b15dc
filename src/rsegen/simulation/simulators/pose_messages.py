"""Conversion of poses with roll, pitch and yaw to simulators' messages with a quaternion, and back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rsegen.simulation.simulators.live_world import Pose

PoseMessage = Mapping[str, Mapping[str, Any]]
"""A pose as a message: position x, y, z and orientation x, y, z, w."""


def pose_message(pose: Pose) -> PoseMessage:
    """The message of a pose."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (pose.roll, pose.pitch, pose.yaw))
    turned = {
        "w": cr * cp * cy + sr * sp * sy,
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
    }
    return {"position": {"x": pose.x, "y": pose.y, "z": pose.z}, "orientation": turned}


def pose_of(message: PoseMessage) -> Pose:
    """The pose in a message; missing fields are 0."""
    at, q = message.get("position", {}), message.get("orientation", {})
    x, y, z, w = (float(q.get(name, 0.0)) for name in "xyzw")
    return Pose(
        x=float(at.get("x", 0.0)),
        y=float(at.get("y", 0.0)),
        z=float(at.get("z", 0.0)),
        roll=math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        pitch=math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))),
        yaw=math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


def is_nearer(at: Pose, wanted: Pose, before: Pose) -> bool:
    """Whether a model is nearer to its wanted pose than to the one before."""
    return _distance(at, wanted) <= _distance(at, before)


def _distance(one: Pose, other: Pose) -> float:
    return math.dist((one.x, one.y, one.z), (other.x, other.y, other.z))
