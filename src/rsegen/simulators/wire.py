"""Messages of both Gazebos as bytes: protocol buffers, of which each field is a number and a kind of value.

A message is a sequence of fields: a key, number * 8 + wire type, and a value; wire type 0 is a varint of seven bits per
byte, 1 and 5 are eight and four bytes, 2 is a length and its bytes (protobuf.dev, "Encoding"). The tables CLASSIC
and SIM list the fields of the message types that rsegen needs; others are skipped in what is received. Cost: some
microseconds per field. No protobuf library: its versions exclude each other, and users have one already (decision 16).
What breaks it: packed repeated fields, which no message of these tables has, and a field with another number in a
later Gazebo. Poses are converted between roll, pitch and yaw and quaternions.
"""

from __future__ import annotations

import math
import re
import struct
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean
from typing import Any, TypeAlias

from rsegen.errors import NoMessage, shown
from rsegen.simulators.poses import Contact, Pose, angles_of

Message: TypeAlias = Mapping[str, Any]
"""A message: numbers, texts, bytes and messages by the names of their fields; lists where a field may be repeated."""

Kind: TypeAlias = type | str
"""int, float, bool, str, bytes, or the name of a message type."""

Fields: TypeAlias = Mapping[str, tuple[int, Kind | list[Kind]]]
"""Number and kind of each field of a message type, by its name; a list of the kind: repeated."""

_NONSENSE = (AttributeError, IndexError, OverflowError, TypeError, ValueError, struct.error)
"""Errors of Python where bytes are no message of a type."""

_MOST_BYTES = 10
"""Bytes of a varint at most: 64 bits, seven each."""


@dataclass(frozen=True, slots=True)
class MessageTypes:
    """The message types of a simulator, by their names without the package."""

    types: Mapping[str, Fields]
    numbered: Mapping[str, Mapping[int, tuple[str, Kind | list[Kind]]]] = field(init=False)
    """Name and kind of each field by its number, as it is received, of each message type."""

    def __post_init__(self) -> None:
        numbered = {
            type_name: {field_number: (name, kind) for name, (field_number, kind) in fields.items()}
            for type_name, fields in self.types.items()
        }
        object.__setattr__(self, "numbered", numbered)

    def encode(self, type_name: str, message: Message) -> bytes:
        """Return a message of a type, such as `Twist`, as bytes."""
        fields = self.types[type_name]
        return b"".join(self._field(*fields[name], value) for name, value in message.items())

    def decode(self, type_name: str, content: bytes) -> dict[str, Any]:
        """Return the message of a type from bytes, or raise NoMessage; fields that are not in it are left out.

        Such a field reads as a zero or as nothing, as in protobuf. The type may be one that a server has named.
        """
        if type_name not in self.types:
            raise NoMessage(f"a simulator sent a message of the type {shown(type_name)}, which is not known")
        try:
            return self._decoded(type_name, content)
        except _NONSENSE as error:
            raise NoMessage(f"a simulator sent what is no message {type_name} ({error})") from None

    def _decoded(self, type_name: str, content: bytes) -> dict[str, Any]:
        names = self.numbered[type_name]
        message, parts = _Decoded(self, type_name), defaultdict[tuple[str, str], list[bytes]](list)
        for field_number, wire_type, value in _fields(content):
            if field_number not in names:
                continue
            name, kind = names[field_number]
            single = kind[0] if isinstance(kind, list) else kind
            if wire_type != _wire_type(single):
                raise ValueError(f"{name} is of another kind")
            if isinstance(kind, list):
                message.setdefault(name, []).append(self._value(single, value))
            elif isinstance(kind, str):
                parts[name, kind].append(value)
            else:
                message[name] = self._value(kind, value)
        # A message that comes in parts has the fields of all of them, by protobuf's rule that joined bytes are merged.
        message |= {name: self.decode(kind, b"".join(own)) for (name, kind), own in parts.items()}
        return message

    def _field(self, number: int, kind: Kind | list[Kind], value: Any) -> bytes:
        if isinstance(kind, list):
            return b"".join(self._field(number, kind[0], item) for item in value)
        key = _varint(number << 3 | _wire_type(kind))
        if kind is float:
            return key + struct.pack("<d", float(value))
        if kind in (int, bool):
            return key + _varint(int(value))
        content = self.encode(kind, value) if isinstance(kind, str) else value.encode() if kind is str else value
        return key + _varint(len(content)) + content

    def _value(self, kind: Kind, value: Any) -> Any:
        if kind is str:
            return value.decode(errors="replace")
        return self.decode(kind, value) if isinstance(kind, str) else kind(value)


class _Decoded(dict[str, Any]):
    """A message that was received, of whoever: a field that it should have and has not is a zero, not an error."""

    def __init__(self, types: MessageTypes, type_name: str) -> None:
        super().__init__()
        self._types, self._type_name = types, type_name

    def __missing__(self, name: str) -> Any:
        _, kind = self._types.types[self._type_name][name]
        if isinstance(kind, list):
            return []
        return _Decoded(self._types, kind) if isinstance(kind, str) else kind()


def parse_text(text: str) -> Message:
    """Return the message of a text for `gz topic`: `position { x: 1 } name: "a"`; its values stay texts."""
    whole: dict[str, Any] = {}
    inside = [whole]  # the messages that are open, the innermost last
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


def _wire_type(kind: Kind) -> int:
    """Return the wire type of a field: 0 a varint, 1 eight bytes, 2 a length and its bytes."""
    return 1 if kind is float else 0 if kind in (int, bool) else 2


def _fields(content: bytes) -> Iterator[tuple[int, int, Any]]:
    """Yield number, wire type and raw value of each field; ValueError for what is longer than the message."""
    at = 0
    while at < len(content):
        key, at = _number(content, at)
        if key & 7 == 0:
            value, at = _number(content, at)
            yield key >> 3, 0, value
            continue
        if key & 7 == 2:
            length, at = _number(content, at)
        else:
            length = {1: 8, 5: 4}.get(key & 7, -1)  # the wire types of a fixed length; the others are groups, or none
        if not 0 <= length <= len(content) - at:
            raise ValueError(f"a field of {length} bytes")
        raw, at = content[at : at + length], at + length
        yield key >> 3, key & 7, struct.unpack("<d", raw)[0] if key & 7 == 1 else raw


def _varint(number: int) -> bytes:
    """Return a number as seven bits a byte, the lowest first; a negative one as if it had 64 bits."""
    left = number & 2**64 - 1
    content = bytearray()
    while left > 127:
        content.append(left & 127 | 128)  # the eighth bit: more follow
        left >>= 7
    return bytes([*content, left])


def _number(content: bytes, at: int) -> tuple[int, int]:
    """Return the number that begins there, and where the next thing begins."""
    value = 0
    for place in range(_MOST_BYTES):
        byte = content[at + place]
        value |= (byte & 127) << 7 * place
        if byte < 128:
            value &= 2**64 - 1
            return (value - 2**64 if value >= 2**63 else value), at + place + 1  # two's complement
    raise ValueError("a number of more than 64 bits")


_BOTH: Mapping[str, Fields] = {
    "Time": {"sec": (1, int), "nsec": (2, int)},
    "Twist": {"linear": (2, "Vector3d"), "angular": (3, "Vector3d")},
    "WorldStatistics": {"sim_time": (2, "Time"), "real_time": (4, "Time"), "paused": (5, bool), "iterations": (6, int)},
}
"""The message types that are the same in both."""

CLASSIC = MessageTypes(
    {
        **_BOTH,
        "Vector3d": {"x": (1, float), "y": (2, float), "z": (3, float)},
        "Quaternion": {"x": (2, float), "y": (3, float), "z": (4, float), "w": (5, float)},
        "Pose": {"name": (1, str), "id": (2, int), "position": (3, "Vector3d"), "orientation": (4, "Quaternion")},
        "ImageStamped": {"time": (1, "Time"), "image": (2, bytes)},
        "PosesStamped": {"time": (1, "Time"), "pose": (2, [bytes])},
        "GzString": {"data": (1, str)},
        "GzString_V": {"data": (1, [str])},
        "Mesh": {"filename": (1, str)},
        "Geometry": {"mesh": (8, "Mesh")},
        "Visual": {"geometry": (9, "Geometry")},
        "Link": {"name": (2, str), "pose": (9, "Pose"), "visual": (10, ["Visual"])},
        "Model": {"name": (1, str), "id": (2, int), "is_static": (3, bool), "pose": (4, "Pose"), "link": (6, ["Link"])},
        "Model_V": {"models": (2, ["Model"])},
        "Factory": {"sdf": (1, str), "pose": (3, "Pose")},
        "Request": {"id": (1, int), "request": (2, str), "data": (3, str)},
        "Response": {"id": (1, int), "response": (3, str), "type": (4, str), "serialized_data": (5, bytes)},
        "LogControl": {"stop": (2, bool)},
        "WorldControl": {"pause": (1, bool), "multi_step": (3, int)},
        "Contact": {"collision1": (1, str), "collision2": (2, str), "position": (3, ["Vector3d"])},
        "Contacts": {"contact": (1, ["Contact"])},
        "Packet": {"stamp": (1, "Time"), "type": (2, str), "serialized_data": (3, bytes)},
        "Publish": {"topic": (1, str), "msg_type": (2, str), "host": (3, str), "port": (4, int)},
        "Subscribe": {"topic": (1, str), "host": (2, str), "port": (3, int), "msg_type": (4, str)},
    }
)
"""The message types of Gazebo Classic that rsegen sends and receives, with the numbers in Gazebo 11.1's library."""

SIM = MessageTypes(
    {
        **_BOTH,
        "Header": {"stamp": (1, "Time")},
        "Vector3d": {"x": (2, float), "y": (3, float), "z": (4, float)},
        "Quaternion": {"x": (2, float), "y": (3, float), "z": (4, float), "w": (5, float)},
        "Pose": {
            "header": (1, "Header"),
            "name": (2, str),
            "id": (3, int),
            "position": (4, "Vector3d"),
            "orientation": (5, "Quaternion"),
        },
        "EntityPose": {"id": (3, int)},  # a Pose of which the rest is skipped
        "Pose_V": {"header": (1, "Header"), "pose": (2, [bytes])},
        "Double": {"data": (2, float)},
        "Boolean": {"data": (2, bool)},
        "Empty": {},
        "StringMsg_V": {"data": (2, [str])},
        "Entity": {"id": (2, int), "name": (3, str), "type": (4, int)},
        "EntityFactory": {"sdf": (2, str), "pose": (7, "Pose")},
        "Contact": {"collision1": (2, "Entity"), "collision2": (3, "Entity"), "position": (4, ["Vector3d"])},
        "Contacts": {"header": (1, "Header"), "contact": (2, [bytes])},
        "Mesh": {"filename": (2, str)},
        "Geometry": {"mesh": (9, "Mesh")},
        "Visual": {"geometry": (10, "Geometry")},
        "Link": {"visual": (11, ["Visual"])},
        "Model": {"name": (2, str), "id": (3, int), "pose": (5, "Pose"), "link": (7, ["Link"])},
        "Scene": {"name": (2, str), "model": (9, ["Model"])},
        "WorldControl": {"pause": (2, bool), "multi_step": (4, int)},
        "Subscriber": {"topic": (1, str)},
        "MessagePublisher": {"ctrl": (1, str), "msg_type": (2, str)},
        "ServicePublisher": {"socket_id": (1, str), "request_type": (2, str), "response_type": (3, str)},
        "Publisher": {
            "topic": (1, str),
            "address": (2, str),
            "process_uuid": (3, str),
            "node_uuid": (4, str),
            "scope": (5, int),
            "msg_pub": (6, "MessagePublisher"),
            "srv_pub": (7, "ServicePublisher"),
        },
        "Discovery": {
            "version": (2, int),
            "process_uuid": (3, str),
            "type": (4, int),
            "sub": (6, "Subscriber"),
            "pub": (7, "Publisher"),
        },
    }
)
"""The message types of Gazebo Sim that rsegen sends and receives; they are the same in all versions since Fortress."""


def nanoseconds(time: Mapping[str, int] | None) -> int:
    """Return a message Time of Gazebo Sim in nanoseconds; 0 without a message, as protobuf leaves out zeros."""
    return (time or {}).get("sec", 0) * 10**9 + (time or {}).get("nsec", 0)


PoseMessage = Mapping[str, Mapping[str, Any]]
"""A pose as a message: position x, y, z and orientation x, y, z, w."""


def pose_message(pose: Pose) -> PoseMessage:
    """Return the message of a pose."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (pose.roll, pose.pitch, pose.yaw))
    turned = {
        "w": cr * cp * cy + sr * sp * sy,
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
    }
    return {"position": {"x": pose.x, "y": pose.y, "z": pose.z}, "orientation": turned}


def pose_of(message: PoseMessage) -> Pose:
    """Return the pose in a message; missing fields are 0."""
    at, q = message.get("position", {}), message.get("orientation", {})
    turn = (float(q.get(name, 0.0)) for name in "wxyz")
    return Pose.of([*(float(at.get(name, 0.0)) for name in "xyz"), *angles_of(*turn)])


def contact_of(collisions: tuple[str, str], points: Sequence[Mapping[str, float]]) -> Contact | None:
    """Return a contact at the mean of its points; None if it has none."""
    if not points:
        return None
    x, y, z = (fmean(point[along] for point in points) for along in "xyz")
    return Contact(collisions=collisions, position=(x, y, z))


def mesh_file(model: Mapping[str, Any]) -> str:
    """Return the file of the first visual mesh of a model; empty if no visual is a mesh."""
    visuals = (visual for link in model.get("link", []) for visual in link.get("visual", []))
    files = (visual.get("geometry", {}).get("mesh", {}).get("filename") for visual in visuals)
    return next(filter(None, files), "")
