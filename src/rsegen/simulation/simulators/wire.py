"""Messages of both Gazebos as bytes: protocol buffers, of which each field is a number and a kind of value.

The tables of a simulator list the fields of its message types; fields that rsegen never needs are not in them, and are
skipped in what is received.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

Message: TypeAlias = Mapping[str, Any]
"""A message: numbers, texts, bytes and messages by the names of their fields; lists where a field may be repeated."""

Kind: TypeAlias = type | str
"""int, float, bool, str, bytes, or the name of a message type; a name, `text` or `bytes` with [] after it: repeated."""

Fields: TypeAlias = Mapping[str, tuple[int, Kind]]
"""Number and kind of each field of a message type, by its name."""

NO_MESSAGE = (AttributeError, IndexError, TypeError, ValueError, struct.error)
"""What `decode` raises for bytes that are no message of the type."""


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
