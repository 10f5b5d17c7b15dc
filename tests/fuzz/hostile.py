"""Trees of plain values as files hold them, made wrong in one place or a few: other sorts, extremes, depth, aliases."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

Tree: TypeAlias = Any


@dataclass(frozen=True, slots=True)
class Raw:
    """A value by how it is written, since Python has none such."""

    text: str


TEXTS = (
    "",
    " ",
    "x",
    "random",
    "\x1b[31mred\x1b[0m",
    "a\rb",
    "\x07",
    "\u202eright to left",
    "\u2028",
    "\x00",
    "\ufeff",
    "é" * 70,
    "x" * 600,
    "n" * 20_000,
    "../../outside",
    "/dev/zero",
    "/",
    "~",
    "$HOME",
    "%s%n",
    "{0.__class__}",
    "a\nb",
    "1",
    "-1",
    "1e400",
    "nan",
    "0x10",
    "1_000",
    "٣",
    "#fff",
    "#GGGGGG",
    "'",
    '"',
    "None",
    "true",
    "con",
    "rse_0000",
    "peak",
    "2x2",
)
NUMBERS = (
    0,
    -1,
    1,
    2,
    3,
    5,
    7,
    10,
    100,
    255,
    256,
    1000,
    32766,
    32767,
    32768,
    65535,
    65536,
    2**31 - 1,
    2**31,
    2**53,
    2**63 - 1,
    2**63,
    2**64,
    10**30,
    0.5,
    -0.0,
    1e-9,
    5e-324,
    1e-5,
    0.1,
    1.5,
    99.999999999,
    100.0000001,
    1e9,
    1e18,
    1e300,
    1.7976931348623157e308,
    float("nan"),
    float("inf"),
    float("-inf"),
)
OTHERS: tuple[Tree, ...] = (
    None,
    True,
    False,
    [],
    {},
    [[]],
    [{}],
    {"": ""},
    {"kind": "peak"},
    [None],
    [1, 2],
    [1, 2, 3],
    [[1, 2], [3]],
)
RAWS = (
    *("9" * 400, "9" * 5000, "-" + "9" * 5000, "1e999", "-1e999", "1e-999", "NaN", "Infinity", "-Infinity", "0.1e1"),
    *('"\\ud800"', '"\\u0000"', '"\\u001b[2J"', "[" * 60 + "]" * 60, "[" * 3000 + "]" * 3000, "[" * 100_000),
    *('{"a":' * 2000 + "1" + "}" * 2000, "[" + "1," * 20_000 + "1]", '"' + "x" * 200_000 + '"', "01", "+1", ".5", "5."),
    *("{", "}", "[", "]", ",", ":", '"', "'", "//", "undefined", '{"a":1,"a":2}', "[1,]", "1 2", "- 1", "? x", "\t"),
)
"""Values that may stand in JSON, and in the flow style of YAML, or may not."""
YAML_RAWS = (
    *(
        "!!binary aGVsbG8=",
        "!!binary '*'",
        "!!timestamp x",
        "!!float x",
        "!!int x",
        "!!bool x",
        "!!null x",
        "!!set {a, b}",
    ),
    *(
        "!!omap [a: 1]",
        "!!omap x",
        "!!pairs [a: 1]",
        "!!python/object/apply:os.system [x]",
        "!x y",
        "!<x> y",
        "!!str {}",
    ),
    *("&a [*a]", "&a {a: *a}", "*nothing", "&a", "{<<: {a: 1}}", "{<<: 1}", "{? [a] : b}", "{[a]: b}", "{{a: 1}: 2}"),
    *("2001-01-01", "2001-13-41", "1:30:00", "190:20:30.15", "0o17", "017", "0b1", "1_0", "+.inf", ".nan", "~", "yes"),
    *("!!seq x", "!!map x", "!!int 0x", "!!int _", "!!float _", "!!float 1:x", "!!int ''", "@x", "`x`", "%x", "|", ">"),
    *(
        "[&a [x,x],&b [*a,*a],&c [*b,*b],&d [*c,*c,*c,*c]]",
        "!!timestamp 2001-01-01T99:99:99Z",
        "!!binary é",
        "---",
        "...",
    ),
    "["
    + ",".join(
        f"&{name} [{','.join([f'*{below}'] * 10)}]" for below, name in zip("zabcdefgh", "abcdefghi", strict=True)
    )
    + "]",
)


def scalar(rng: random.Random, yaml: bool) -> Tree:
    """A value that hardly belongs anywhere."""
    kinds: list[Sequence[Tree]] = [NUMBERS, NUMBERS, TEXTS, OTHERS, [Raw(text) for text in RAWS]]
    if yaml:
        kinds += [[Raw(text) for text in YAML_RAWS]] * 2
    return copy.deepcopy(rng.choice(rng.choice(kinds)))


def damaged_tree(rng: random.Random, tree: Tree, yaml: bool) -> Tree:
    """A copy of a tree that is wrong in one place, or in a few."""
    box = {"tree": copy.deepcopy(tree)}
    for _ in range(_few(rng)):
        parent, key = rng.choice(list(_places(box)))
        rng.choice(_CHANGES)(rng, parent, key, yaml)
        if "tree" not in box:
            return None
    return box["tree"]


def _few(rng: random.Random) -> int:
    return 1 + (rng.random() < 0.3) + (rng.random() < 0.1)


def _places(node: Tree) -> Iterator[tuple[Any, Any]]:
    """Every place in a tree: the list or mapping, and the key."""
    items = list(node.items()) if isinstance(node, dict) else list(enumerate(node)) if isinstance(node, list) else []
    for key, value in items:
        yield node, key
        yield from _places(value)


def _replace(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    parent[key] = scalar(rng, yaml)


def _remove(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    if "tree" in parent:
        parent[key] = scalar(rng, yaml)
    else:
        del parent[key]


def _nudge(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    """A number near or far, or another sort of the same."""
    value = parent[key]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        changes: list[Callable[[], Any]] = [
            *(lambda: value + 1, lambda: value - 1, lambda: -value, lambda: value * 1000, lambda: value + 0.5),
            *(lambda: str(value), lambda: float(value), lambda: [value], lambda: {"": value}),
        ]
        parent[key] = rng.choice(changes)()
    elif isinstance(value, str):
        parent[key] = rng.choice(
            (value[:-1], value.upper(), f" {value}", value * 9, value + rng.choice(TEXTS), [value])
        )
    else:
        parent[key] = scalar(rng, yaml)


def _wrap(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    value = parent[key]
    for _ in range(rng.choice((1, 1, 2, 50))):
        value = [value] if rng.random() < 0.5 else {"a": value}
    parent[key] = value


def _unwrap(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    value = parent[key]
    parts = list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []
    parent[key] = rng.choice(parts) if parts else scalar(rng, yaml)


def _repeat(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    """Items more than once; of a mapping, a key that is given twice."""
    if isinstance(parent, list):
        parent[key:key] = [parent[key]] * rng.choice((1, 2, 30, 300))
    elif isinstance(key, str):
        parent[Raw(f'"{key}"')] = scalar(rng, yaml)


def _rename(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    if isinstance(parent, dict) and "tree" not in parent and isinstance(key, str):
        name = rng.choice((key + "s", key.upper(), key.replace("_", "-"), rng.choice(TEXTS), Raw("null"), Raw("1")))
        parent[name] = parent.pop(key)
    else:
        parent[key] = scalar(rng, yaml)


def _add(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    if isinstance(parent, list):
        parent.insert(key, scalar(rng, yaml))
    elif "tree" not in parent:
        parent[rng.choice(TEXTS)] = scalar(rng, yaml)


def _swap(rng: random.Random, parent: Any, key: Any, yaml: bool) -> None:
    """Another part of the same list or mapping at this place."""
    others = list(parent.values()) if isinstance(parent, dict) else parent
    parent[key] = copy.deepcopy(rng.choice(others))


_CHANGES = (_replace, _replace, _replace, _remove, _nudge, _nudge, _wrap, _unwrap, _repeat, _rename, _add, _swap)


def as_text(tree: Tree) -> str:
    """A tree in JSON, which is YAML as well, but for what is raw."""
    match tree:
        case Raw(text):
            return text
        case dict():
            return "{" + ", ".join(f"{as_text(key)}: {as_text(value)}" for key, value in tree.items()) + "}"
        case list() | tuple():
            return "[" + ", ".join(map(as_text, tree)) + "]"
    return _scalar_text(tree)


def _scalar_text(value: object) -> str:
    import json

    return json.dumps(value)
