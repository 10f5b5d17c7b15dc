"""Places of the links, joints and frames of a model in an SDF file, in the frame of the model."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError, shown
from rsegen.field.stepfield import Array
from rsegen.simulation.robots.rotation import rotation

_DEEPEST = 30
"""Frames that may be given relative to each other, one after another."""


_LARGEST = 1e6
"""Metres or radians, beyond which a number in a file is a mistake."""


class Frames:
    """The links, frames and nested models of a model by name, and its joints; those of a nested one are NESTED::NAME.

    A joint may have the name of a link in older files.
    FileError, which begins with `where`, if a pose is not numbers or is relative to itself.
    """

    def __init__(self, model: Element, where: str) -> None:
        self.where = where
        found = list(named(model))
        self.elements = {name: element for name, element in found if element.tag != "joint"}
        self.joints = {name: element for name, element in found if element.tag == "joint"}

    def transform(self, name: str, depth: int = 0) -> Array:
        """The pose of a frame in the model's, (4, 4); the model's own for a name that is none."""
        if depth > _DEEPEST:
            raise FileError(f"{self.where}: the pose of {shown(name)} is relative to itself")
        element = self.elements.get(name, self.joints.get(name))
        return np.eye(4) if element is None else self._placed(name, element, depth)

    def joint(self, name: str) -> Array:
        """The pose of a joint in the model's frame, (4, 4)."""
        return self._placed(name, self.joints[name], 0)

    def _placed(self, name: str, element: Element, depth: int) -> Array:
        scope = name.rpartition("::")[0]
        pose = element.find("pose")
        other = "" if pose is None else pose.get("relative_to", pose.get("frame", ""))
        other = other or _default(element)
        base = scope if other in ("", "__model__") else _in_scope(scope, other)
        return self.transform(base, depth + 1) @ self.local(element)

    def local(self, element: Element) -> Array:
        """The <pose> of an element as it stands, (4, 4)."""
        pose = element.find("pose")
        return np.eye(4) if pose is None else _matrix(pose, self.where)

    def shape(self, link: str, collision: Element) -> Array:
        """The pose of a collision shape of a link in the model's frame, (4, 4)."""
        pose = collision.find("pose")
        other = "" if pose is None else pose.get("relative_to", "")
        base = _in_scope(link.rpartition("::")[0], other) if other else link
        return self.transform(base) @ self.local(collision)

    def axis(self, joint: str) -> Array:
        """The direction of a joint's axis in the model's frame, (3,)."""
        element = self.joints[joint]
        found = element.find("axis/xyz")
        if found is None:
            return np.array([0.0, 0.0, 1.0])
        xyz = np.array(floats(found.text, 3, self.where))
        if (element.findtext("axis/use_parent_model_frame") or "").strip() in ("1", "true"):
            return xyz
        frame = found.get("expressed_in", "")
        scope = joint.rpartition("::")[0]
        turned = self.transform(_in_scope(scope, frame)) if frame else self.joint(joint)
        return np.asarray(turned[:3, :3] @ xyz)


def named(model: Element, scope: str = "") -> Iterator[tuple[str, Element]]:
    """The links, joints, frames and nested models of a model, with their names in it."""
    for element in model:
        if element.tag in ("link", "joint", "frame", "model"):
            yield f"{scope}{element.get('name', '')}", element
        if element.tag == "model":
            yield from named(element, f"{scope}{element.get('name', '')}::")


def floats(text: str | None, count: int, where: str) -> list[float]:
    """So many numbers of a text, none beyond a million; FileError if it has others."""
    try:
        found = [float(word) for word in (text or "").split()]
    except ValueError:
        found = []
    if len(found) != count or not all(abs(number) <= _LARGEST for number in found):
        wanted = "a number" if count == 1 else f"{count} numbers"
        raise FileError(f"{where}: {shown((text or '').strip())} is not {wanted} within a million")
    return found


def _default(element: Element) -> str:
    """What a pose is relative to if it does not say: a joint's to its child, a frame's to what it is attached to."""
    if element.tag == "joint":
        return (element.findtext("child") or "").strip()
    return element.get("attached_to", "") if element.tag == "frame" else ""


def _in_scope(scope: str, name: str) -> str:
    return f"{scope}::{name}" if scope else name


def _matrix(pose: Element, where: str) -> Array:
    if pose.get("rotation_format") == "quat_xyzw":
        *place, x, y, z, w = floats(pose.text, 7, where)
        turn = _of_quaternion(x, y, z, w, where)
    else:
        text = pose.text if (pose.text or "").strip() else "0 0 0 0 0 0"
        *place, roll, pitch, yaw = floats(text, 6, where)
        if pose.get("degrees") in ("1", "true"):
            roll, pitch, yaw = map(radians, (roll, pitch, yaw))
        turn = rotation(roll, pitch, yaw)
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = turn, place
    return made


def _of_quaternion(x: float, y: float, z: float, w: float, where: str) -> Array:
    length = float(np.linalg.norm([x, y, z, w]))
    if not length:
        raise FileError(f"{where}: the quaternion 0 0 0 0 is no rotation")
    x, y, z, w = (each / length for each in (x, y, z, w))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
