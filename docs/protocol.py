"""protocol.ts, what the page and its server say to each other, made of the types and signatures of the server.

    call, its keyword parameters and its result      --> an entry of Calls: {doc: string; index: number} and Pose
    TypedDict, or a dataclass, with its comments     --> interface
    action, its keyword parameters                   --> a member of Action

    python -m docs.protocol     makes protocol.ts anew; so does make docs, and make check says if it is out of date

A parameter with a default may be left out. A type that JSON has wider than TypeScript is `Annotated` with the name or
the class that TypeScript has for it.
"""

from __future__ import annotations

import ast
import inspect
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypedDict, Union, get_args, get_origin, get_type_hints, is_typeddict

import rsegen
from rsegen.page import calls
from rsegen.page.calls import Failure, load_calls
from rsegen.page.host import Event, Search
from rsegen.page.model.actions import actions
from rsegen.page.shown_map import Frozen

FILE = Path(rsegen.__file__).parent / "page" / "browser" / "app" / "protocol.ts"

HEAD = """\
/* What the page and its server say to each other. Made by `python -m docs.protocol` of the types in Python.

   POST /api/NAME, "Authorization: Bearer TOKEN", JSON object of arguments --> 200 and JSON, or 4xx and {error: Failure}
   POST /api/events {doc, page}  --> a stream of lines, each an Event as JSON, open as long as the page is
   POST /api/upload?name=N, bytes --> {path}, for scan, compare and import
   POST /api/file {path}         --> the bytes of a file under the server's folder: pictures, tables, PDF

   Lengths are in metres, angles in radians, unless a name ends in _cm. Every call may have `page`, the name that a page
   gives itself, and `doc`. Actions of one gesture, any text, are undone together. */

/* Integers that a number of JavaScript would round, such as seeds, are bigint here, and plain integers on the wire. */
export type Json = null | boolean | number | bigint | string | Json[] | { [key: string]: Json };
export type Entry = { kind: string; [parameter: string]: Json }; // an obstacle as a recipe file has it
export type Cell = [number, number]; // of blocks, frames not counted: x, y
export type SceneData = Drawing & Partial<MapData & DocumentMap>; // a map of a document, or of a page that is a file
"""

_PLAIN: Mapping[Any, str] = {
    int: "number",
    float: "number",
    str: "string",
    bool: "boolean",
    NoneType: "null",
    Any: "Json",
    object: "Json",
}


class Interfaces:
    """The interfaces that have been asked for, each with all that it refers to."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}
        self._classes: dict[str, type] = {}

    def type_of(self, hint: Any) -> str:
        """Return a type as TypeScript writes it."""
        origin, parts = get_origin(hint), get_args(hint)
        if origin is Annotated:
            return parts[1] if isinstance(parts[1], str) else self.type_of(parts[1])
        if origin in (Union, UnionType):
            return " | ".join(dict.fromkeys(map(self.type_of, parts)))
        if origin is Literal:
            return " | ".join(map(json.dumps, parts))
        if origin in (dict, Mapping):
            return f"{{ [name: string]: {self.type_of(parts[1])} }}"
        if origin in (list, tuple):
            return self._list(origin, parts)
        return _PLAIN.get(hint) or self._interface(hint)

    def _list(self, origin: Any, parts: Sequence[Any]) -> str:
        """Return the type of a list, whose entries are of one type, or of a tuple."""
        entries = [self.type_of(part) for part in parts if part is not Ellipsis]
        if origin is tuple and Ellipsis not in parts:
            return f"[{', '.join(entries)}]"
        return f"({entries[0]})[]" if " | " in entries[0] else f"{entries[0]}[]"

    def _interface(self, cls: type) -> str:
        if not (is_typeddict(cls) or is_dataclass(cls)):
            raise TypeError(f"{cls} has no type in TypeScript")
        if self._classes.setdefault(cls.__name__, cls) is not cls:
            raise TypeError(f"{cls} and {self._classes[cls.__name__]} have one name")
        if cls.__name__ not in self.texts:
            self.texts[cls.__name__] = ""  # it may refer to itself
            may_lack = getattr(cls, "__optional_keys__", ())
            comments = _comments(cls)
            lines = [
                f"  {name}{'?' * (name in may_lack)}: {self.type_of(hint)};{comments.get(name, '')}\n"
                for name, hint in get_type_hints(cls, include_extras=True).items()
            ]
            self.texts[cls.__name__] = f"{_comment(cls)}export interface {cls.__name__} {{\n{''.join(lines)}}}\n"
        return cls.__name__

    def arguments(self, function: Callable[..., Any], first: Sequence[str]) -> str:
        """Return the keyword parameters of a function as an object of TypeScript, after some that are written so."""
        hints = get_type_hints(function, include_extras=True)
        known, needed = calls.keywords(function)
        own = [f"{name}{'?' * (name not in needed)}: {self.type_of(hints[name])}" for name in known]
        return f"{{ {'; '.join([*first, *own])} }}" if own or first else "{}"


def _comment(thing: Any, indent: str = "") -> str:
    """Return the first line of a docstring as a comment."""
    return f"{indent}/* {inspect.getdoc(thing).partition(chr(10))[0]} */\n"  # type: ignore[union-attr]  # all have one


def _comments(cls: type) -> Mapping[str, str]:
    """Return the comments of the fields of a class and of its bases, each behind its field."""
    module = sys.modules[cls.__module__]
    source = inspect.getsource(module)
    lines = source.splitlines()
    (found,) = (node for node in ast.parse(source).body if isinstance(node, ast.ClassDef) and node.name == cls.__name__)
    comments: dict[str, str] = {}
    for base in (getattr(module, ast.unparse(base)) for base in found.bases):
        comments |= _comments(base) if base is not TypedDict else {}
    for node in found.body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.end_lineno:
            comment = lines[node.end_lineno - 1][node.end_col_offset :].partition("#")[2]
            comments[node.target.id] = f" //{comment}" if comment else ""
    return comments


def protocol() -> str:
    """Return the text of protocol.ts."""
    load_calls()
    types = Interfaces()
    called = "".join(_calls(types))
    acted = "".join(_actions(types))
    named = f"export type Search = {types.type_of(Search)};\n\nexport type Event = {types.type_of(Event)};\n"
    for cls in (Failure, Frozen):
        types.type_of(cls)
    parts = [
        HEAD,
        *types.texts.values(),
        named,
        "/* Changes of a document, of the map that the page shows. */\nexport type Action =\n" + acted.rstrip() + ";\n",
        "/* What a page may ask for: the arguments, and the result. */\nexport interface Calls {\n" + called + "}\n",
    ]
    return "\n".join(parts)


def _calls(types: Interfaces) -> Iterator[str]:
    functions = {name: (function, ["doc: string"]) for name, function in calls.OF_DOCUMENT.items()}
    functions |= {name: (function, []) for name, function in calls.OF_HOST.items()}
    for name, (function, first) in sorted(functions.items()):
        result = types.type_of(get_type_hints(function, include_extras=True)["return"])
        yield f"{_comment(function, '  ')}  {name}: {{ args: {types.arguments(function, first)}; result: {result} }};\n"


def _actions(types: Interfaces) -> Iterator[str]:
    for name, function in sorted(actions().items()):
        yield f"{_comment(function, '  ')}  | {types.arguments(function, [f'do: {json.dumps(name)}'])}\n"


if __name__ == "__main__":
    FILE.write_text(protocol(), "utf-8", newline="\n")
