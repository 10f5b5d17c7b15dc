"""Find the joints of wheels by what they turn: round, on the ground, on an endless joint across; and their steering.

Nothing names wheels here: a joint is judged by its limits, its axis, the shapes of its link, and the joints between it
and the body. What breaks it: shapes of unknown size.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.robots.files.controllers import Controls
from rsegen.robots.files.sdf_shapes import ModelFrames

_ALONG = 0.99
"""Cosine of the angle between a wheel's axis and y at least: cambered wheels have some degrees."""

UPRIGHT = 0.7
"""Vertical part of an axis from which on what it carries is steered, or swivels, and is no rocker."""

_TRAIL = 0.05
"""Share of its radius by which a caster trails at least: makers' have 0.3 to 1, and the steered wheels of cars 0."""

_ENDLESS = 100.0
"""Radians between the limits of a joint from which on it may be that of a wheel: no arm turns 16 times."""

_ROUND, _GROUNDED, _CENTRED = 0.05, 0.2, 0.2
"""Shares of a wheel's size: by which its height and length may differ; of its radius: by which its lowest point may be
above that of the robot, and its middle away from its axis."""

_LIKE = 0.8
"""Radius of a driven wheel at least, as a share of the largest: smaller ones are casters."""


TURNING = ("revolute", "continuous")
"""Types of joints that turn about one axis."""


def steered_wheels(frames: ModelFrames, ros: Controls) -> dict[str, str]:
    """Return the joints of wheels that are steered, and which joint steers each: an upright one that is held.

    Such wheels are as large as the largest. What steers has limits, or ROS gives it a position, or it does not trail:
    casters do, and swivel freely. A universal joint steers too, and so does one on which a wheel cannot roll, as in
    models of cars that are only seen. A suspension and a rocker turn about level axes. What is steered does not turn by
    a difference between its sides.
    """
    if not frames.shapes.whole:
        return {}
    # Two sorts steer: joints that are no free swivels above a wheel, and joints on which the wheel itself turns.
    above = frames.holders()
    across = {name for name, joint in frames.joints.items() if is_endless(joint) and is_along_y(name, frames)}

    def is_free(joint: str) -> bool:
        return joint not in ros.placed and is_endless(frames.joints[joint])

    steer_alone = {
        name
        for name, joint in frames.joints.items()
        if joint.get("type") == "universal" or (_swivels(name, frames) and not is_free(name))
    }
    radii = large_wheels((name for name in frames.joints if name in across | steer_alone), frames)

    def steering(joint: str) -> str:
        """Return the joint that steers a wheel; an empty text for none."""
        link = frames.parent(joint)
        if joint in steer_alone:
            return joint
        for _ in frames.joints:  # as deep as there are joints, as a file may have a circle
            if link not in above:
                return ""
            held = above[link]
            if _swivels(held, frames) and not (is_free(held) and _trails(joint, held, radii[joint], frames)):
                return held
            link = frames.parent(held)
        return ""

    return {joint: by for joint in radii if (by := steering(joint))}


def _swivels(joint: str, frames: ModelFrames) -> bool:
    """Return whether a joint turns what it carries to the left and the right, as in a caster or a steering."""
    turns = frames.joints[joint].get("type") in TURNING
    return turns and bool(abs(frames.axis(joint)[2]) >= UPRIGHT)


def _trails(wheel: str, swivel: str, radius: float, frames: ModelFrames) -> bool:
    """Return whether the middle of a wheel is behind or in front of the axis on which it swivels."""
    # The distance of the two axes, which is along the normal of both; an offset along the axle does not count.
    away = frames.joint(wheel)[:3, 3] - frames.joint(swivel)[:3, 3]
    across = np.cross(frames.axis(wheel), frames.axis(swivel))
    return bool(abs(away @ across) > _TRAIL * radius * np.linalg.norm(across))


def is_along_y(joint: str, frames: ModelFrames) -> bool:
    """Return whether a joint turns about an axis across the model, up to the camber of a wheel."""
    return bool(abs(frames.axis(joint)[1]) >= _ALONG)


def rolling_joints(joints: Iterable[str], frames: ModelFrames) -> list[str]:
    """Return the joints that are endless, along y, and not carried by a swivel, as the wheel of a caster is.

    Nor do they carry another of them, as the joints of an arm do.
    """
    above = frames.holders()
    swivels: dict[str, bool] = {}  # whether a link is turned about an upright axis

    def is_swivelling(link: str) -> bool:
        # Up to the first link that is known, and back: each link is asked once, however many joints it carries.
        way = []
        while link in above and link not in swivels:
            swivels[link] = False  # until more is known; it ends a circle
            way.append(link)
            link = frames.parent(above[link])
        turned = swivels.get(link, False)
        for part in reversed(way):
            turned = turned or _swivels(above[part], frames)
            swivels[part] = turned
        return turned

    rolling = [
        joint
        for joint in joints
        if is_endless(frames.joints[joint]) and is_along_y(joint, frames) and not is_swivelling(frames.parent(joint))
    ]
    carrying = {frames.parent(joint) for joint in rolling}
    return [joint for joint in rolling if frames.child(joint) not in carrying]


def is_wheel(joint: str, frames: ModelFrames) -> bool:
    """Return whether a joint turns what is round about it and on the ground, without end, about an axis along y."""
    return is_endless(frames.joints[joint]) and is_along_y(joint, frames) and _wheel_radius(joint, frames) > 0


def is_endless(joint: Element) -> bool:
    """Return whether a joint turns without end."""
    if joint.get("type") not in TURNING:
        return False
    try:
        low = float(joint.findtext("axis/limit/lower") or "-inf")
        high = float(joint.findtext("axis/limit/upper") or "inf")
    except ValueError:
        return False
    return high - low >= _ENDLESS


def large_wheels(joints: Iterable[str], frames: ModelFrames) -> dict[str, float]:
    """Return the joints that turn wheels about as large as the largest of them, and the radius of each."""
    radii = {joint: _wheel_radius(joint, frames) for joint in joints}
    largest = max(radii.values(), default=0.0)
    return {joint: radius for joint, radius in radii.items() if radius and radius >= _LIKE * largest}


def _wheel_radius(joint: str, frames: ModelFrames) -> float:
    """Return the radius of what a joint turns if it is round about it and on the ground; 0 if not."""
    shape, whole = frames.shapes.of(frames.child(joint)), frames.shapes.whole
    if shape is None or whole is None:
        return 0.0
    length, _, height = shape.high - shape.low
    off = np.linalg.norm(((shape.low + shape.high) / 2 - frames.joint(joint)[:3, 3])[[0, 2]])
    is_round = abs(length - height) <= _ROUND * height and off <= _CENTRED * height / 2
    is_on_ground = shape.low[2] - whole.low[2] <= _GROUNDED * height / 2
    return float(height / 2) if is_round and is_on_ground else 0.0
