"""A case: files in an empty folder, and a command that is run there. As one line of JSON it can be run again."""

from __future__ import annotations

import base64
import json
import os
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias


@dataclass(frozen=True, kw_only=True, slots=True)
class Special:
    """Entries of a folder that are no plain files."""

    kind: Literal["folder", "fifo", "link"]
    target: str = ""


Content: TypeAlias = "bytes | Special"


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """One trial of a command, or of a reader, whose name begins with @.

    outputs: the files and folders that the command may write, if it does not refuse
    forked: in a process of its own, as it changes what Python knows
    """

    family: str
    argv: tuple[str, ...]
    files: Mapping[str, Content] = field(default_factory=dict)
    outputs: tuple[str, ...] = ()
    forked: bool = False

    def lay_out(self, folder: Path) -> None:
        """Write its files into an empty folder."""
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            match content:
                case bytes():
                    path.write_bytes(content)
                case Special(kind="folder"):
                    path.mkdir(exist_ok=True)
                case Special(kind="fifo"):
                    os.mkfifo(path)
                case Special(target=target):
                    path.symlink_to(target)

    def line(self) -> str:
        """The case as one line of JSON."""
        whole: dict[str, object] = {"family": self.family, "argv": list(self.argv)}
        whole["files"] = {name: _packed(content) for name, content in self.files.items()}
        return json.dumps(whole | {"outputs": list(self.outputs), "forked": self.forked})


def read_case(line: str) -> Case:
    """The case that `line` gave."""
    found = json.loads(line)
    files = {name: _unpacked(content) for name, content in found["files"].items()}
    argv, outputs = tuple(found["argv"]), tuple(found["outputs"])
    return Case(family=found["family"], argv=argv, files=files, outputs=outputs, forked=found["forked"])


def _packed(content: Content) -> object:
    if isinstance(content, Special):
        return {content.kind: content.target}
    try:
        text = content.decode()
    except UnicodeDecodeError:
        text = None
    if text is not None and text.isprintable() | text.replace("\n", "").isprintable() and len(text) < 2000:
        return text
    return {"zlib": base64.b64encode(zlib.compress(content, 9)).decode()}


def _unpacked(packed: Any) -> Content:
    if isinstance(packed, str):
        return packed.encode()
    ((kind, value),) = packed.items()
    return zlib.decompress(base64.b64decode(value)) if kind == "zlib" else Special(kind=kind, target=value)
