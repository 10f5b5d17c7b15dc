"""Random generators: one for each obstacle of each map.

Nothing but `random()` is drawn from it: numpy fixes those bits for good, while its other distributions may change from
one version to the next. So the same recipe gives the same bytes with every numpy.
"""

from __future__ import annotations

import hashlib
import secrets

import numpy as np

SEEDS = 2**63


def fresh_seed() -> int:
    """A seed that the operating system draws."""
    return secrets.randbelow(SEEDS)


def generator(seed: int, index: int, key: str) -> np.random.Generator:
    """The generator of the obstacle `key` in map `index`: no other obstacle or map has a say in it."""
    return np.random.Generator(np.random.PCG64(np.frombuffer(digest(seed, index, key), "<u4")))


def digest(seed: int, index: int, key: str) -> bytes:
    """The 16 bytes that seed the generator of the obstacle `key` in map `index`."""
    return hashlib.blake2b(f"{seed}/{index}/{key}".encode(), digest_size=16).digest()


def randint(rng: np.random.Generator, low: int, high: int) -> int:
    """A whole number from low..high, both included, each as likely as the other."""
    return low + int(rng.random() * (high - low + 1))
