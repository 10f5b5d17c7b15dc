"""Messages of both Gazebos as bytes: protocol buffers, of which each field is a number and a kind of value.

The tables of a simulator list the fields of its message types; fields that rsegen never needs are not in them, and are
skipped in what is received.

Conversion of poses with roll, pitch and yaw to simulators' messages with a quaternion, and back.

What a message about a model, of either Gazebo, says of its meshes.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from rsegen.simulation.simulators.live_world import Pose

Message: TypeAlias = Mapping[str, Any]
"""A message: numbers, texts, bytes and messages by the names of their fields; lists where a field may be repeated."""

Kind: TypeAlias = type | str
"""int, float, bool, str, bytes, or the name of a message type; a name, `text` or `bytes` with [] after it: repeated."""

Fields: TypeAlias = Mapping[str, tuple[int, Kind]]
"""Number and kind of each field of a message type, by its name."""

NO_MESSAGE = (AttributeError, IndexError, TypeError, ValueError, struct.error)
"""Errors that `decode` raises for bytes that are no message of the type."""


@dataclass(frozen=True, slots=True)
class MessageTypes:
    """The message types of a simulator, by their names without the package."""

    types: Mapping[str, Fields]

    def encode(self, type_name: str, message: Message) -> bytes:
        """A message of a type, such as `Twist`, as bytes."""
        fields = self.types[type_name]
        return b"".join(self._field(*fields[name], value) for name, value in message.items())

    def decode(self, type_name: str, content: bytes) -> dict[str, Any]:
        """The message of a type from bytes; missing fields are left out."""
        names = {number: (name, kind) for name, (number, kind) in self.types[type_name].items()}
        found: dict[str, Any] = {}
        for number, value in _fields(content):
            if number not in names:
                continue
            name, kind = names[number]
            if isinstance(kind, str) and kind.endswith("[]"):
                found.setdefault(name, []).append(self._value(kind[:-2], value))
            else:
                found[name] = self._value(kind, value)
        return found

    def _field(self, number: int, kind: Kind, value: Any) -> bytes:
        if isinstance(kind, str) and kind.endswith("[]"):
            return b"".join(self._field(number, kind[:-2], one) for one in value)
        if kind is float:
            return _varint(number << 3 | 1) + struct.pack("<d", float(value))
        if kind in (int, bool):
            return _varint(number << 3) + _varint(int(value))
        plain = value.encode() if kind in (str, "text") else None
        content = value if kind in (bytes, "bytes") else self.encode(str(kind), value) if plain is None else plain
        return _varint(number << 3 | 2) + _varint(len(content)) + content

    def _value(self, kind: Kind, value: Any) -> Any:
        if kind in (str, "text"):
            return value.decode(errors="replace")
        if kind in (bytes, "bytes"):
            return b"" + value  # a number is no bytes: bytes(value) would be as many
        if isinstance(kind, str):
            return self.decode(kind, value)
        return kind(value)


def parse_text(text: str) -> Message:
    """The message of a text for `gz topic`: `position { x: 1 } name: "a"`; its values stay texts."""
    whole: dict[str, Any] = {}
    inside = [whole]
    name = ""
    for word in re.findall(r'"[^"]*"|[{}]|[^\s{}:]+', text):
        if word == "}":
            inside.pop()
        elif word == "{":
            inside.append(inside[-1].setdefault(name, {}))
            name = ""
        elif name:
            inside[-1][name], name = word.strip('"'), ""
        else:
            name = word
    return whole


def _fields(content: bytes) -> Iterator[tuple[int, Any]]:
    """Yield number and raw value of each field, in order."""
    at = 0
    while at < len(content):
        key, at = _number(content, at)
        length = {1: 8, 5: 4}.get(key & 7)
        if key & 7 == 0:
            value, at = _number(content, at)
            yield key >> 3, value
            continue
        if length is None:
            length, at = _number(content, at)
        raw, at = content[at : at + length], at + length
        yield key >> 3, struct.unpack("<d", raw)[0] if key & 7 == 1 else raw


def _varint(number: int) -> bytes:
    """Return a number as seven bits a byte, the lowest first; a negative one as if it had 64 bits."""
    number &= 2**64 - 1
    content = bytearray()
    while number > 127:
        content.append(number & 127 | 128)
        number >>= 7
    return bytes([*content, number])


def _number(content: bytes, at: int) -> tuple[int, int]:
    """The number that begins there, and where the next thing begins."""
    number = shift = 0
    while True:
        byte = content[at]
        number |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return (number - 2**64 if number >= 2**63 else number), at


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
    """Return whether a model is closer to its target pose than to its previous one."""
    return _distance(at, wanted) <= _distance(at, before)


def _distance(one: Pose, other: Pose) -> float:
    return math.dist((one.x, one.y, one.z), (other.x, other.y, other.z))


def mesh_file(model: Mapping[str, Any]) -> str:
    """The file of the first mesh that is seen of a model; empty if there is none."""
    return next(_mesh_files(model), "")


def _mesh_files(model: Mapping[str, Any]) -> Iterator[str]:
    visuals = (visual for link in model.get("link", []) for visual in link.get("visual", []))
    for visual in visuals:
        if file := visual.get("geometry", {}).get("mesh", {}).get("filename"):
            yield file
