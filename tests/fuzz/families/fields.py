"""Clouds of fields that are there to be found, spoiled a little or a lot."""

from __future__ import annotations

import random

from tests.fuzz.case import Case

_CLOUDS = ("cloud.npy", "cloud.xyz", "cloud.ply")


def case(rng: random.Random) -> Case:
    """A cloud, which is made anew of the number in a file."""
    files = {"number": str(rng.randrange(2**32)).encode()}
    return Case(family="field", argv=("@field", "number"), files=files, outputs=_CLOUDS)
