"""Joints that follow another one, by <mimic> in URDF and in SDF since 1.11, or by a constraint in MJCF.

The angle of a follower is multiplier * (leader's angle - reference) + offset, radians or metres. The rule stands in the
<axis> of its joint, as in SDF 1.11, whatever the version of the model is; only a simulator that keeps to it gets it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from rsegen.robots.files.sdf_elements import numbers_text, put
from rsegen.robots.files.sdf_shapes import ModelFrames, floats, in_scope

MOVING = ("revolute", "continuous", "prismatic")
"""Types of joints with one angle or way, which may follow, lead and be held; others are screws, balls and gears."""


class Mimic(NamedTuple):
    """The rule of a joint that follows the joint `leader`: times a multiplier, plus an offset, radians or metres."""

    leader: str
    multiplier: float
    offset: float


def put_mimic(joint: Element, mimic: Mimic) -> None:
    """Make a joint of SDF, which has an <axis>, follow another one."""
    axis = joint.find("axis")
    assert axis is not None  # noqa: S101  # of those that may follow each has one
    element = SubElement(axis, "mimic", joint=mimic.leader)
    put(element, "multiplier", numbers_text([mimic.multiplier]))
    put(element, "offset", numbers_text([mimic.offset]))


def mimics(frames: ModelFrames) -> dict[str, Mimic]:
    """Return the rule of each joint that follows another; both have to move, and not to follow each other in a circle.

    FileError for what is no number.
    """
    rules: dict[str, Mimic] = {}
    for name, joint in frames.joints.items():
        element = joint.find("axis/mimic")
        if element is None or joint.get("type") not in MOVING:
            continue
        scope, where = name.rpartition("::")[0], f"{frames.where}: <mimic> of joint {name}"
        own = (element.get("joint") or "").strip()
        leader = in_scope(scope, own)
        if leader in frames.joints and frames.joints[leader].get("type") in MOVING:
            (multiplier,) = floats(element.findtext("multiplier", "1"), 1, where)
            (offset,) = floats(element.findtext("offset", "0"), 1, where)
            (reference,) = floats(element.findtext("reference", "0"), 1, where)
            rules[name] = Mimic(leader, multiplier, offset - multiplier * reference)
    return {name: mimic for name, mimic in rules.items() if first_leader(name, rules) is not None}


def first_leader(joint: str, followed: Mapping[str, Mimic]) -> str | None:
    """Return the joint that a joint follows in the end: itself if it follows none; None if they follow each other."""
    for _ in range(len(followed) + 1):
        if joint not in followed:
            return joint
        joint = followed[joint].leader
    return None
