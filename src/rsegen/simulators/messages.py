"""Reading the text in which Gazebo's tools print protobuf messages."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Message:
    """Plain values by their name, and messages inside by theirs, in the order of the text."""

    values: dict[str, str] = field(default_factory=dict)
    parts: defaultdict[str, list[Message]] = field(default_factory=lambda: defaultdict(list))

    def numbers(self, *names: str) -> list[float]:
        """Values as numbers; what is not stated is 0, as in protobuf."""
        return [float(self.values.get(name, 0)) for name in names]


def parse(text: str) -> Message:
    """The message that a text says: lines `name: value`, `name {` and `}`."""
    whole = Message()
    open_messages = [whole]
    for line in map(str.strip, text.splitlines()):
        if line.endswith("{"):
            inner = Message()
            open_messages[-1].parts[line[:-1].strip()].append(inner)
            open_messages.append(inner)
        elif line == "}":
            open_messages.pop()
        elif line:
            name, _, value = line.partition(": ")
            open_messages[-1].values[name] = value.strip('"')
    return whole
