"""Random generators: one for each obstacle of each map.

Nothing but `random()` is drawn from it: numpy fixes those bits for good, while its other distributions may change from
one version to the next. So the same recipe gives the same bytes with every numpy.

The generators of one obstacle in many maps, seeded together: numpy takes ten times as long one by one.

Each is in the state in which `streams.generator` gives it. numpy keeps both algorithms as they are: SeedSequence, which
turns 128 bits into the state, and PCG64 (O'Neill 2014), whose first two steps begin a stream.
"""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Iterable, Iterator, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Words = NDArray[np.uint32]

SEEDS = 2**63


def fresh_seed() -> int:
    """A seed that the operating system draws."""
    return secrets.randbelow(SEEDS)


def generator(seed: int, index: int, key: str) -> np.random.Generator:
    """The generator of the obstacle `key` in map `index`: no other obstacle or map has a say in it."""
    import numpy as np

    return np.random.Generator(np.random.PCG64(np.frombuffer(digest(seed, index, key), "<u4")))


def digest(seed: int, index: int, key: str) -> bytes:
    """The 16 bytes that seed the generator of the obstacle `key` in map `index`."""
    return hashlib.blake2b(f"{seed}/{index}/{key}".encode(), digest_size=16).digest()


def randint(rng: np.random.Generator, low: int, high: int) -> int:
    """A whole number from low..high, both included, each as likely as the other."""
    return low + int(rng.random() * (high - low + 1))


_WORDS = 4
"""32-bit words of a digest, and of the pool into which they are mixed."""

_AT_ONCE = 4096
"""Generators whose states are worked out together."""

_MULTIPLIER = 0x2360ED051FC65DA44385DF649FCCF645
"""Of PCG64's 128-bit congruential generator."""

_BITS_128 = (1 << 128) - 1

_MIX_LEFT, _MIX_RIGHT = 0xCA01F9DD, 0x4973F715
_ENTROPY, _STATE = (0x43B0D7E5, 0x931E8875), (0x8B51F9DD, 0x58F38DED)
"""First constant and multiplier of the two hashes of a SeedSequence."""


def generators(seed: int, indices: Sequence[int], key: str) -> Iterator[np.random.Generator]:
    """Of the obstacle `key`, for each of these maps: always the same object in another state, so use one at a time."""
    import numpy as np

    bits = np.random.PCG64(0)
    rng = np.random.Generator(bits)
    inner: dict[str, int] = {}
    state: Any = {"bit_generator": "PCG64", "state": inner, "has_uint32": 0, "uinteger": 0}
    for low in range(0, len(indices), _AT_ONCE):
        for inner["state"], inner["inc"] in _states(_digests(seed, indices[low : low + _AT_ONCE], key)):
            bits.state = state
            yield rng


def _digests(seed: int, indices: Iterable[int], key: str) -> Words:
    """(maps, 4): what `streams.generator` seeds each generator with."""
    import numpy as np

    found = b"".join(digest(seed, index, key) for index in indices)
    return np.frombuffer(found, "<u4").reshape(-1, _WORDS).astype(np.uint32)


def _states(digests: Words) -> Iterator[tuple[int, int]]:
    """State and increment of PCG64 for each row, as whole numbers of 128 bits."""
    halves = _generated(_pooled(digests)).astype("<u4").view("<u8").T.tolist()
    for state_high, state_low, inc_high, inc_low in zip(*halves, strict=True):
        increment = ((inc_high << 64 | inc_low) << 1 | 1) & _BITS_128
        begun = increment + (state_high << 64 | state_low)
        yield (begun * _MULTIPLIER + increment) & _BITS_128, increment


def _pooled(entropy: Words) -> list[Words]:
    """The pool of a SeedSequence, word by word."""
    import numpy as np

    constant = _constants(*_ENTROPY)
    pool = [_hashed(entropy[:, word], constant) for word in range(_WORDS)]
    for source in range(_WORDS):
        for target in range(_WORDS):
            if source != target:
                mixed = np.uint32(_MIX_LEFT) * pool[target] - np.uint32(_MIX_RIGHT) * _hashed(pool[source], constant)
                pool[target] = mixed ^ mixed >> np.uint32(16)
    return pool


def _generated(pool: Sequence[Words]) -> Words:
    """(maps, 8): the words of state that a SeedSequence generates."""
    import numpy as np

    constant = _constants(*_STATE)
    words = cycle(pool)
    return np.stack([_hashed(next(words), constant) for _ in range(2 * _WORDS)], axis=1)


def _hashed(value: Words, constant: Iterator[np.uint32]) -> Words:
    import numpy as np

    value = (value ^ next(constant)) * next(constant)
    return np.asarray(value ^ value >> np.uint32(16))


def _constants(first: int, multiplier: int) -> Iterator[np.uint32]:
    """Those of a hash in the order in which it needs them: each but the first twice, before and after one value."""
    import numpy as np

    while True:
        yield np.uint32(first)
        first = first * multiplier & 0xFFFFFFFF
        yield np.uint32(first)
