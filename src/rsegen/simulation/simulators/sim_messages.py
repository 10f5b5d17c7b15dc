"""Parsing and formatting of the protobuf text of Gazebo Sim's commands."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Message:
    """Plain values by their name, and messages inside by theirs, in the order of the text."""

    values: dict[str, str] = field(default_factory=dict)
    parts: defaultdict[str, list[Message]] = field(default_factory=lambda: defaultdict(list))


def parse(text: str) -> Message:
    """The message in a text of lines `name: value`, `name {` and `}`; other lines are skipped."""
    whole = Message()
    open_messages = [whole]
    for line in map(str.strip, text.splitlines()):
        name, colon, value = line.partition(":")
        if line.endswith("{"):
            inner = Message()
            open_messages[-1].parts[line[:-1].strip()].append(inner)
            open_messages.append(inner)
        elif line == "}" and len(open_messages) > 1:
            open_messages.pop()
        elif colon and name.isidentifier():
            open_messages[-1].values[name] = value.strip().strip('"')
    return whole


def format_message(message: Mapping[str, object]) -> str:
    """The text of a message of strings, numbers, booleans and messages."""
    return " ".join(f"{name}{_value(value)}" for name, value in message.items())


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return f" {{ {format_message(value)} }}"
    return f": {json.dumps(value, ensure_ascii=False)}"
