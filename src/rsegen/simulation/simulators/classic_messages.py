"""Gazebo Classic's messages as bytes: protocol buffers, of which each field is a number and a kind of value.

The tables say what a message type has, by name; fields that rsegen never needs are left out, and skipped when read.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from typing import Any

Message = Mapping[str, Any]
"""A message: numbers, texts, bytes and messages by the names of their fields; lists where a field may be repeated."""

_Kind = type | str
"""int, float, bool, str, bytes, or the name of a message type; with [] after it, repeated."""

TYPES: Mapping[str, Mapping[str, tuple[int, _Kind]]] = {
    "Time": {"sec": (1, int), "nsec": (2, int)},
    "Vector3d": {"x": (1, float), "y": (2, float), "z": (3, float)},
    "Quaternion": {"x": (2, float), "y": (3, float), "z": (4, float), "w": (5, float)},
    "Pose": {"name": (1, str), "id": (2, int), "position": (3, "Vector3d"), "orientation": (4, "Quaternion")},
    "Twist": {"linear": (2, "Vector3d"), "angular": (3, "Vector3d")},
    "GzString": {"data": (1, str)},
    "GzString_V": {"data": (1, "text[]")},
    "Link": {"name": (2, str), "pose": (9, "Pose")},
    "Model": {
        "name": (1, str),
        "id": (2, int),
        "is_static": (3, bool),
        "pose": (4, "Pose"),
        "link": (6, "Link[]"),
    },
    "Model_V": {"models": (2, "Model[]")},
    "Factory": {"sdf": (1, str), "sdf_filename": (2, str), "pose": (3, "Pose"), "allow_renaming": (6, bool)},
    "Request": {"id": (1, int), "request": (2, str), "data": (3, str)},
    "Response": {"id": (1, int), "response": (3, str), "type": (4, str), "serialized_data": (5, bytes)},
    "LogControl": {"stop": (2, bool)},
    "WorldControl": {"pause": (1, bool), "step": (2, bool), "multi_step": (3, int)},
    "WorldStatistics": {
        "sim_time": (2, "Time"),
        "pause_time": (3, "Time"),
        "real_time": (4, "Time"),
        "paused": (5, bool),
        "iterations": (6, int),
    },
    "Contact": {"collision1": (1, str), "collision2": (2, str), "position": (3, "Vector3d[]")},
    "Contacts": {"contact": (1, "Contact[]")},
    "Packet": {"stamp": (1, "Time"), "type": (2, str), "serialized_data": (3, bytes)},
    "Publish": {"topic": (1, str), "msg_type": (2, str), "host": (3, str), "port": (4, int)},
    "Subscribe": {"topic": (1, str), "host": (2, str), "port": (3, int), "msg_type": (4, str), "latching": (5, bool)},
}


def encode(type_name: str, message: Message) -> bytes:
    """A message of a type, such as `Twist`, as bytes."""
    return b"".join(_field(*TYPES[type_name][name], value) for name, value in message.items())


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


def decode(type_name: str, content: bytes) -> dict[str, Any]:
    """The message of a type from bytes; missing fields are left out."""
    names = {number: (name, kind) for name, (number, kind) in TYPES[type_name].items()}
    found: dict[str, Any] = {}
    for number, value in _fields(content):
        if number not in names:
            continue
        name, kind = names[number]
        if isinstance(kind, str) and kind.endswith("[]"):
            found.setdefault(name, []).append(_value(kind[:-2], value))
        else:
            found[name] = _value(kind, value)
    return found


def _field(number: int, kind: _Kind, value: Any) -> bytes:
    if isinstance(kind, str) and kind.endswith("[]"):
        return b"".join(_field(number, kind[:-2], one) for one in value)
    if kind is float:
        return _varint(number << 3 | 1) + struct.pack("<d", float(value))
    if kind in (int, bool):
        return _varint(number << 3) + _varint(int(value))
    content = value if kind is bytes else value.encode() if kind in (str, "text") else encode(str(kind), value)
    return _varint(number << 3 | 2) + _varint(len(content)) + content


def _value(kind: _Kind, value: Any) -> Any:
    if kind in (str, "text"):
        return value.decode(errors="replace")
    if isinstance(kind, str):
        return decode(kind, value)
    return kind(value)


def _fields(content: bytes) -> Iterator[tuple[int, Any]]:
    """Number and raw value of each field, in order."""
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
    """Seven bits a byte, the lowest first; a negative number as if it had 64 bits."""
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
