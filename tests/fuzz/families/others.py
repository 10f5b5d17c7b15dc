"""Inventories, robots, plans and results of experiments, and plug-in files."""

from __future__ import annotations

import json
import random

from tests.fuzz import seeds
from tests.fuzz.case import Case, Content
from tests.fuzz.damage import damaged_text
from tests.fuzz.families.clouds import damaged as damaged_mesh
from tests.fuzz.families.recipes import special_or, written
from tests.fuzz.hostile import Tree

_TAGS: tuple[bytes, ...] = (
    b"<!DOCTYPE s [<!ENTITY a 'x'>]>",
    b"<?xml version='1.0' encoding='utf-16'?>",
    b"<model name='b'/>",
    b"<world name='w'/>",
)
_TAGS += (
    b"<a>" * 5000,
    b"<![CDATA[x]]>",
    b"<!--",
    b"&amp;",
    b"&#0;",
    b"&#x1b;",
    b"<x:y/>",
    b"<?pi?>",
    b"<pose/>",
    b"\x1b",
    b"&a;",
)
_OUTCOME = {
    "load": 1.5,
    "memory": 200.0,
    "cpu": 0.5,
    "speed": 3.0,
    "rtf_min": 0.9,
    "rtf": 1.0,
    "rtf_max": 1.1,
    "share": None,
}
_LINES: tuple[dict[str, Tree], ...] = (
    {"cell": {"row": 0, "size": 10, "pace": "real"}, "repeat": 0, "outcome": _OUTCOME},
)
_LINES += ({"cell": {"row": 1, "size": 20, "pace": "free"}, "repeat": 1, "outcome": _OUTCOME | {"rtf": None}},)


def inventory(rng: random.Random) -> Case:
    """A list of the blocks that a lab owns."""
    content = seeds.INVENTORY
    for _ in range(rng.choice((1, 1, 2))):
        content = damaged_text(rng, content)
    flags = rng.choice((["--unit-cm", "10"], ["--unit-cm", "0.1"], [], ["--chunk-size", "4"]))
    argv = ("info", "--obstacle", "random levels=3", "--seed", "7", *flags, "--inventory", "inv.csv")
    return Case(family="inventory", argv=argv, files={"inv.csv": special_or(rng, content)})


def robot(rng: random.Random) -> Case:
    """A model of a robot in SDF or URDF, with the file of its controller in its package."""
    content = rng.choice(seeds.robots())
    files: dict[str, Content] = {"part.stl": seeds.clouds()[rng.choice(("mesh.stl", "ascii.stl"))]}
    if content == seeds.CONTROLLED:
        files["package.xml"] = damaged_text(rng, seeds.PACKAGE) if rng.random() < 0.2 else seeds.PACKAGE
        controller = damaged_text(rng, seeds.CONTROLLER) if rng.random() < 0.8 else seeds.CONTROLLER
        files["config/c.yaml"] = special_or(rng, controller)
        if rng.random() < 0.5:
            return Case(family="robot", argv=_with_robot(rng), files={"cart.sdf": content, **files})
    if b"part.stl" in content and rng.random() < 0.7:
        files["part.stl"] = damaged_mesh(rng, "part.stl", seeds.clouds()["ascii.stl"])
        return Case(family="robot", argv=_with_robot(rng), files={"cart.sdf": content, **files})
    at = rng.randrange(len(content))
    tagged = content[:at] + rng.choice(_TAGS) + content[at:]
    content = tagged if rng.random() < 0.4 else damaged_text(rng, content)
    return Case(family="robot", argv=_with_robot(rng), files={"cart.sdf": special_or(rng, content), **files})


def _with_robot(rng: random.Random) -> tuple[str, ...]:
    drive = ("drive", "peak", "--robot", "cart.sdf", "--duration", "1")
    spots = ("spots", "peak", "--robot", "cart.sdf", "--seed", "1")
    return rng.choices((("@robot", "cart.sdf"), drive, spots), (6, 2, 2))[0]


def plan(rng: random.Random) -> Case:
    """A plan of an experiment; without a simulator it goes no further than its checks."""
    content = written(rng, rng.choice(seeds.plans()), yaml_=True)
    argv = ("@plan", "plan.yaml") if rng.random() < 0.5 else ("experiment", "plan.yaml", "-o", "out")
    return Case(family="plan", argv=argv, files={"plan.yaml": special_or(rng, content)})


def results(rng: random.Random) -> Case:
    """The log of an experiment's results, or its summary."""
    plan_ = {"plan": seeds.PLAN}
    if rng.random() < 0.5:
        cells = [{**line["cell"], "outcomes": [line["outcome"]]} for line in _LINES]
        tree: Tree = {"machine": {"simulator": "x"}, **plan_, "cells": cells}
        return Case(
            family="results",
            argv=("@summary", "s.json"),
            files={"s.json": special_or(rng, written(rng, tree, yaml_=False))},
        )
    first: Tree = {"rsegen_journal": 1, "holds": "experiment", "of": seeds.PLAN}
    lines: list[Tree] = [first, *({"result": line} for line in _LINES)]
    number = rng.randrange(len(lines))
    texts = [
        written(rng, line, yaml_=False) if at == number else json.dumps(line).encode() for at, line in enumerate(lines)
    ]
    content = b"\n".join(texts) + b"\n" * (rng.random() < 0.7)
    return Case(family="results", argv=("@journal", "out/.rsegen.jsonl"), files={"out/.rsegen.jsonl": content})


def plugin(rng: random.Random) -> Case:
    """A file of Python that should hold a kind of obstacle, and holds something else."""
    content = seeds.PLUGIN
    for _ in range(rng.choice((1, 1, 2, 3))):
        content = damaged_text(rng, content)
    argv = (
        "--plugin",
        "sand.py",
        *rng.choice((("obstacles",), ("info", "--obstacle", "dune levels=3", "--seed", "1"))),
    )
    return Case(family="plug-in", argv=argv, files={"sand.py": special_or(rng, content)}, forked=True)
