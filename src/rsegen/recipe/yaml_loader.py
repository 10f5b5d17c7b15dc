"""A loader of YAML that refuses what PyYAML accepts, so that its work is bounded by the length of the text.

1e3 is a number, as in YAML 1.2, JSON and flags; in YAML 1.1, which PyYAML has, it is a text.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from rsegen.errors import FileError, shown
from rsegen.input_files import refuse_duplicates

_DEEPEST = 100
"""Lists and mappings in each other: PyYAML's work grows with the square of them; a recipe has five."""

_MOST_WEIGHT = 4 * 2**20
_NODE = 10
"""Weight that aliases may stand for, and that of a value, list or key besides its characters.

The limit is what the largest file can say without aliases, so that they cannot stand for more (a "billion laughs").
"""


class Loader(yaml.SafeLoader):
    """Refuses duplicate keys, merge keys and aliases that stand for very much, which all can grow without end.

    last_counts: of a duplicate key the last value counts, as in ROS's files of parameters, which may have any numbers
    """

    def __init__(self, text: str, path: Path, *, last_counts: bool = False) -> None:
        super().__init__(text)
        self._path, self._last_counts = path, last_counts
        self._depth = self._weight = 0
        self._weights: dict[str, int] = {}

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node, and count what it stands for, with aliases in it as what they stand for."""
        event = self.peek_event()  # type: ignore[no-untyped-call]  # PyYAML's
        if isinstance(event, yaml.AliasEvent):
            self._count_alias(event)
            return super().compose_node(parent, index)
        before, anchor = self._weight, event.anchor
        self._weight += _NODE + len(getattr(event, "value", ""))
        self._depth += 1
        if self._depth > _DEEPEST:
            raise FileError(f"{self._at(event)}: not YAML: nested too deeply")
        node = super().compose_node(parent, index)
        self._depth -= 1
        if anchor is not None:
            self._weights[anchor] = self._weight - before
        return node

    def compose_mapping_node(self, anchor: Any) -> Any:
        """Compose a mapping; a FileError for a duplicate key, unless the last one counts."""
        node = super().compose_mapping_node(anchor)
        if self._last_counts:
            return node
        keys = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        refuse_duplicates((key.value, self._at(key)) for key in keys)
        return node

    def flatten_mapping(self, node: Any) -> None:
        """Refuse merge keys."""
        for key in (key for key, _ in node.value if key.tag == "tag:yaml.org,2002:merge"):
            raise FileError(f"{self._at(key)}: merge keys ('<<') are not supported; write the keys out")

    def construct_number(self, node: Any) -> Any:
        """Construct a number; what only YAML 1.1 has in base 60 (1:30) stays text, and in base 8 (010) is refused."""
        text = node.value if isinstance(node, yaml.ScalarNode) else ""  # a tag may be on anything
        if ":" in text:
            return text
        if not self._last_counts and _OCTAL.fullmatch(text):
            problem = f"{shown(text)} is a number in base 8 in YAML 1.1, and in base 10 in YAML 1.2"
            raise FileError(f"{self._at(node)}: {problem}; write it without the 0 in front")
        return _NUMBERS[node.tag](self, node)

    def _count_alias(self, event: Any) -> None:
        """Add what an alias stands for; nothing for one inside of that itself, whose node is not complete yet."""
        self._weight += self._weights.get(event.anchor, 0)
        if self._weight > _MOST_WEIGHT:
            most = f"{_MOST_WEIGHT // 2**20} MiB"
            raise FileError(f"{self._at(event)}: the aliases up to {shown(event.anchor)} stand for more than {most}")

    def _at(self, marked: Any) -> str:
        return f"{self._path}:{marked.start_mark.line + 1}"


class Dumper(yaml.SafeDumper):
    """Writes what the `Loader` reads: a text that it would take for a number is quoted."""


_WITH_EXPONENT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+\Z")

for _class in (Loader, Dumper):
    _class.add_implicit_resolver("tag:yaml.org,2002:float", _WITH_EXPONENT, list("-+.0123456789"))

_OCTAL = re.compile("[-+]?0[0-7]*[1-7][0-7]*")

_NUMBERS = {tag: Loader.yaml_constructors[tag] for tag in ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")}
for _tag in _NUMBERS:
    Loader.add_constructor(_tag, Loader.construct_number)
