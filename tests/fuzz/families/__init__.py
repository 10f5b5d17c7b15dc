"""Makers of cases: one function per sort of input, each from a random generator alone."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from types import MappingProxyType

from tests.fuzz.case import Case
from tests.fuzz.families import clouds, fields, flags, folders, heights, others, pages, recipes, wires

Family = Callable[[random.Random], Case]

FAMILIES: Mapping[str, tuple[Family, int]] = MappingProxyType(
    {
        "recipe": (recipes.case, 30),
        "flags": (flags.case, 20),
        "table": (heights.table, 8),
        "array": (heights.array, 6),
        "image": (heights.image, 10),
        "ros": (heights.ros, 6),
        "cloud": (clouds.case, 4),
        "map": (folders.damaged_map, 6),
        "data set": (folders.damaged_data_set, 8),
        "inventory": (others.inventory, 3),
        "robot": (others.robot, 4),
        "plan": (others.plan, 4),
        "results": (others.results, 3),
        "plug-in": (others.plugin, 1),
        "wire": (wires.case, 0),  # by --family alone: threads and sockets take what time they like
        "page": (pages.case, 0),
        "field": (fields.case, 0),  # a second each, most of which makes the cloud
    }
)
"""Family -> the function that makes its cases, and its weight."""


def case_of(seed: int, number: int, family: str | None = None) -> Case:
    """Case `number` of all that a seed stands for, of a family if one is given."""
    rng = random.Random(f"{seed}/{number}")  # noqa: S311  # a case that can be made again, no secret
    names = list(FAMILIES)
    weights = [weight for _, weight in FAMILIES.values()]
    chosen = family or rng.choices(names, weights)[0]
    return FAMILIES[chosen][0](rng)
