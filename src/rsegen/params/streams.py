"""Random generators: one for each obstacle of each map, seeded by a hash of (seed, map, key).

    BLAKE2b("seed/index/key") -> 128 bits -> SeedSequence -> PCG64 (O'Neill 2014)

So no obstacle and no map influences another one (decision 2). Nothing but `random()` is drawn: numpy fixes those bits
for good, while its other distributions may change from one version to the next. The same recipe gives the same bytes
with every numpy.

`generators` makes those of one obstacle in many maps together, in a tenth of numpy's time: SeedSequence's hash and the
first two steps of PCG64, both of which numpy keeps as they are, are computed for thousands of maps at once. A test
compares them with numpy's own.
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
"""Number of seeds: all of them are positive 64-bit integers, which every file format has."""


def fresh_seed() -> int:
    """Return a seed that the operating system draws."""
    return secrets.randbelow(SEEDS)


def generator(seed: int, index: int, key: str) -> np.random.Generator:
    """Return the generator of the obstacle `key` in map `index`, which no other obstacle or map influences."""
    import numpy as np

    return np.random.Generator(np.random.PCG64(np.frombuffer(digest(seed, index, key), "<u4")))


def digest(seed: int, index: int, key: str) -> bytes:
    """Return the 16 bytes that seed the generator of the obstacle `key` in map `index`."""
    return hashlib.blake2b(f"{seed}/{index}/{key}".encode(), digest_size=16).digest()


def randint(rng: np.random.Generator, low: int, high: int) -> int:
    """Draw an integer from low..high, both included, with equal probabilities."""
    return low + int(rng.random() * (high - low + 1))


_WORDS = 4
"""32-bit words of a digest, and of the pool into which they are mixed."""

_AT_ONCE = 4096
"""Generators whose states are computed together: 256 KB of words; more are not faster."""

_MULTIPLIER = 0x2360ED051FC65DA44385DF649FCCF645
"""Multiplier of PCG64's 128-bit linear congruential generator (numpy/random/src/pcg64)."""

_BITS_128 = (1 << 128) - 1

_MIX_LEFT, _MIX_RIGHT = 0xCA01F9DD, 0x4973F715
"""Multipliers with which a SeedSequence mixes two words (numpy/random/bit_generator.pyx, as the next ones)."""

_ENTROPY, _STATE = (0x43B0D7E5, 0x931E8875), (0x8B51F9DD, 0x58F38DED)
"""First constant and multiplier of the two hashes of a SeedSequence: of its pool, and of the state that it
generates.
"""


def generators(seed: int, indices: Sequence[int], key: str) -> Iterator[np.random.Generator]:
    """Yield the generator of the obstacle `key` in each map: one object in another state each time, so use one at a
    time.
    """
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
    """Return the words (maps, 4) with which `generator` seeds each generator."""
    import numpy as np

    digests = b"".join(digest(seed, index, key) for index in indices)
    return np.frombuffer(digests, "<u4").reshape(-1, _WORDS).astype(np.uint32)


def _states(digests: Words) -> Iterator[tuple[int, int]]:
    """Yield state and increment of PCG64 for each row, as integers of 128 bits."""
    halves = _generated(_pooled(digests)).astype("<u4").view("<u8").T.tolist()
    for state_high, state_low, inc_high, inc_low in zip(*halves, strict=True):
        # pcg_setseq_128_srandom: the increment is odd; one step from 0, the initial state added, one more step.
        increment = ((inc_high << 64 | inc_low) << 1 | 1) & _BITS_128
        begun = increment + (state_high << 64 | state_low)
        yield (begun * _MULTIPLIER + increment) & _BITS_128, increment


def _pooled(entropy: Words) -> list[Words]:
    """Return the pool of a SeedSequence, word by word: every word is hashed, then mixed with every other."""
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
    """Return the words of state (maps, 8) that a SeedSequence generates."""
    import numpy as np

    constant = _constants(*_STATE)
    words = cycle(pool)
    return np.stack([_hashed(next(words), constant) for _ in range(2 * _WORDS)], axis=1)


def _hashed(value: Words, constant: Iterator[np.uint32]) -> Words:
    import numpy as np

    value = (value ^ next(constant)) * next(constant)
    return np.asarray(value ^ value >> np.uint32(16))


def _constants(first: int, multiplier: int) -> Iterator[np.uint32]:
    """Yield the constants of a hash in the order of their use: each but the first twice, before and after a value."""
    import numpy as np

    while True:
        yield np.uint32(first)
        first = first * multiplier & 0xFFFFFFFF
        yield np.uint32(first)
