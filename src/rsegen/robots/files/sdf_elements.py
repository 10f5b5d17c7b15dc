"""Elements of SDF for robots of other formats: numbers, poses, and masses of bodies that become one."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from math import isnan, nan
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from rsegen.errors import FileError, shown
from rsegen.field.stepfield import Array
from rsegen.geometry.poses import angles

LATEST_OF_CLASSIC = "1.7"
"""The latest version of SDF that Gazebo Classic reads, in which robots of other formats are written."""

LUMPED = "_fixed_joint_lump__"
"""Before the name of a shape, after that of a link, if a fixed joint attaches the shape's own link, as in Gazebo."""

MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")

ENDS = ("parent", "child", "gearbox_reference_body")
"""Elements of a joint that name a link."""

NAMES_A_PART = re.compile("joint|link|body", re.IGNORECASE)
"""Elements and attributes of plug-ins that name a part of their model; those with a frame in their name are ROS's."""


def part_name(part: str) -> str:
    """Return the name of a part, LINK::COLLISION, for a reader; a lumped link's part is named by that link alone."""
    lumped = re.search(f"{LUMPED}(.+?)_collision(_[0-9]+)?$", part)
    return lumped[1] if lumped else part


_SHORTEST = 1e-9
"""Length of an axis, which should be 1, below which it is taken for none."""


def unit_axis(axis: Sequence[float], where: str) -> Array:
    """Return the direction of an axis, (3,), of length 1 as simulators make it; FileError for none."""
    length = float(np.linalg.norm(axis))
    if length < _SHORTEST:
        raise FileError(f"{where}: its axis {numbers_text(axis)} has no direction")
    return np.array(axis) / length


_MOST_FRICTION = 1e6
"""The largest coefficient that is not cut off; files have 1e16 and more for what is not to slip."""


def coefficient(shape: Element, name: str, where: str) -> float:
    """Return a coefficient of friction of a collision shape, `mu` or `mu2`: 1 by default; FileError for no number."""
    text = (shape.findtext(f"surface/friction/ode/{name}") or "1").strip()
    try:
        value = float(text)
    except ValueError:
        value = nan
    if isnan(value):
        raise FileError(f"{where}: {shown(text)} is not a number, as its <{name}> of friction has to be")
    return min(max(value, 0.0), _MOST_FRICTION)


class Mass(NamedTuple):
    """A mass, kg, its centre, (3,), metres, and its tensor of inertia about it, (3, 3), kg m^2."""

    mass: float
    centre: Array
    tensor: Array


NO_MASS = Mass(0.0, np.zeros(3), np.zeros((3, 3)))
"""Mass of 0, at the origin."""


def moved(body: Mass, place: Array) -> Mass:
    """Return a body of a frame that is at a place, (4, 4), in the frame outside."""
    turn = place[:3, :3]
    return Mass(body.mass, turn @ body.centre + place[:3, 3], turn @ body.tensor @ turn.T)


def sum_of_masses(parts: Iterable[tuple[Mass, Array]]) -> Mass:
    """Return bodies at their places as one; Steiner's theorem moves their tensors to the common centre."""
    bodies = [moved(body, place) for body, place in parts if body.mass]
    if not bodies:
        return NO_MASS
    mass = sum(body.mass for body in bodies)
    centre = np.sum([body.mass * body.centre for body in bodies], axis=0) / mass
    tensor = np.zeros((3, 3))
    for body in bodies:
        offset = body.centre - centre
        tensor += body.tensor + body.mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return Mass(mass, centre, tensor)


def append_inertial(link: Element, body: Mass) -> None:
    """Append the <inertial> of a body to its link."""
    put(link, "inertial/pose", f"{numbers_text(body.centre)} 0 0 0")
    put(link, "inertial/mass", numbers_text([body.mass]))
    for name, value in zip(MOMENTS, body.tensor[np.triu_indices(3)], strict=True):
        put(link, f"inertial/inertia/{name}", numbers_text([value]))


def is_true(text: str | None) -> bool:
    """Return whether the text of an element or an attribute says yes, in letters of any case."""
    return (text or "").strip().lower() in ("1", "true")


def without_plugins(element: Element) -> Iterator[Element]:
    """Yield an element and all that is in it, but plug-ins, whose elements have meanings of their own."""
    yield element
    for part in element:
        if part.tag != "plugin":
            yield from without_plugins(part)


def pose_text(transform: Array) -> str:
    """Return a transform, (4, 4), as x, y, z, metres, and roll, pitch, yaw, radians."""
    return numbers_text([*transform[:3, 3], *angles(transform[:3, :3])])


def pose_in(element: Element) -> Element:
    """Return the <pose> of an element, an empty one as its first part if it has none."""
    pose = element.find("pose")
    if pose is None:
        pose = Element("pose")
        element.insert(0, pose)
    return pose


def put_pose(element: Element, transform: Array) -> None:
    """Give an element a pose, (4, 4), in the frame that SDF has for it by default, in place of any other."""
    for pose in element.findall("pose"):
        element.remove(pose)
    pose_in(element).text = pose_text(transform)


def numbers_text(values: Iterable[float]) -> str:
    """Return numbers with twelve digits, more than files have: a small wheel has moments of 1e-7 kg m^2."""
    return " ".join(f"{value + 0.0:.12g}" for value in values)


def put_all(element: Element, paths: Iterable[str], text: str) -> None:
    """Set the text of the elements at several paths."""
    for path in paths:
        put(element, path, text)


def put(element: Element, path: str, text: str) -> None:
    """Set the text of the element at a path in another; elements of the path that are missing are made."""
    for tag in path.split("/"):
        inner = element.find(tag)
        element = SubElement(element, tag) if inner is None else inner
    element.text = text.strip()
