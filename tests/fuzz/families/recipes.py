"""Recipe files in YAML and JSON, and what commands are given them."""

from __future__ import annotations

import random
from collections.abc import Sequence

import yaml

from tests.fuzz.case import Case, Content, Special
from tests.fuzz.damage import damaged_text
from tests.fuzz.hostile import Tree, as_text, damaged_tree
from tests.fuzz.seeds import recipes

COMMANDS: Sequence[tuple[Sequence[str], tuple[str, ...], int]] = (
    (["info", "FILE"], (), 40),
    (["info", "FILE", "--json"], (), 5),
    (["generate", "FILE", "-o", "out", "--workers", "1"], ("out",), 25),
    (["metrics", "FILE", "--robot", "burger"], (), 6),
    (["metrics", "FILE", "--csv"], (), 3),
    (["export", "FILE", "--to", "stl,heightmap", "-o", "out", "--workers", "1"], ("out",), 5),
    (["series", "FILE", "--maps", "2", "-o", "out", "--workers", "1"], ("out",), 1),
    (["dataset", "FILE", "-o", "out", "--workers", "1"], ("out",), 5),
    (["sheet", "FILE", "-o", "sheet.csv"], ("sheet.csv",), 4),
    (["view", "FILE", "-o", "map.html"], ("map.html",), 4),
    (["open", "FILE", "--print"], (), 2),
    (["drive", "FILE", "--duration", "1"], (), 1),
    (["spawn", "FILE"], (), 1),
    (["respawn", "FILE"], (), 1),
    (["dataset", "--verify", "FILE"], (), 1),
)
"""Arguments, outputs and weight of what is done with a recipe; FILE is its name."""


def case(rng: random.Random) -> Case:
    """A recipe that is wrong in a place or a few, for one of the commands."""
    suffix = rng.choice((".yaml", ".yaml", ".json", ".json", ".yml", "", ".txt", ".JSON"))
    name = f"r{suffix}"
    argv, outputs, _ = rng.choices(COMMANDS, [weight for *_, weight in COMMANDS])[0]
    content = written(rng, rng.choice(recipes()), yaml_=suffix.lower() != ".json")
    return Case(
        family="recipe", argv=tuple(_named(argv, name)), files={name: special_or(rng, content)}, outputs=outputs
    )


def _named(argv: Sequence[str], name: str) -> list[str]:
    return [name if word == "FILE" else word for word in argv]


def written(rng: random.Random, tree: Tree, *, yaml_: bool) -> bytes:
    """A tree that is damaged, as text that may be damaged too."""
    if rng.random() < 0.8:
        content = as_text(damaged_tree(rng, tree, yaml_)).encode("utf-8", "surrogatepass")
        return damaged_text(rng, content) if rng.random() < 0.1 else content
    text = yaml.safe_dump(tree, sort_keys=False, allow_unicode=True) if yaml_ else as_text(tree)
    return damaged_text(rng, text.encode())


def special_or(rng: random.Random, content: bytes) -> Content:
    """Once in a while something other than a plain file."""
    if rng.random() > 0.01:
        return content
    targets = (
        "/dev/zero",
        "/dev/urandom",
        "/dev/null",
        "loop",
        "/",
        "/proc/self/mem",
        "/dev/full",
        "/etc/shadow",
        "nothing",
    )
    return rng.choice((Special(kind="folder"), Special(kind="fifo"), Special(kind="link", target=rng.choice(targets))))
