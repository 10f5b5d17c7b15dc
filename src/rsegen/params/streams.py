"""Random generators: one for each obstacle of each map, seeded by a hash of (seed, map, key).

    BLAKE2b("seed/index/key") -> 128 bits -> SeedSequence -> PCG64 (O'Neill 2014)

So no obstacle and no map influences another one (decision 2). Nothing but `random()` is drawn: numpy fixes those bits
for good, while its other distributions may change from one version to the next. The same recipe gives the same bytes
with every numpy.

`Streams` are those of one obstacle in many maps together: SeedSequence's hash and PCG64, both of which numpy keeps as
they are, are computed for thousands of maps at once, in integers of 64 bits that numpy and torch share. A number of
every map costs a 128-bit product of arrays; many numbers of every map are drawn by numpy's own generator, put into the
state of one map after the other, or on another device by a jump of each number's own:

    s -> A^k s + (A^k - 1) / (A - 1) c  (mod 2^128)     k steps of the generator s -> A s + c at once (Brown 1994)

BLAKE2b remains, one hash at a time, a microsecond each. A test compares all of this with numpy's own.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import cycle
from math import prod
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Words = NDArray[np.uint32]
    Wide = tuple[Any, Any]

SEEDS = 2**63
"""Number of seeds: all of them are positive 64-bit integers, which every file format has."""


def fresh_seed() -> int:
    """Return a seed that the operating system draws."""
    import secrets  # which imports `random`, of no use for a help

    return secrets.randbelow(SEEDS)


def generator(seed: int, index: int, key: str) -> np.random.Generator:
    """Return the generator of the obstacle `key` in map `index`, which no other obstacle or map influences."""
    import numpy as np

    digest = hashlib.blake2b(f"{seed}/{index}/{key}".encode(), digest_size=16).digest()
    return np.random.Generator(np.random.PCG64(np.frombuffer(digest, "<u4")))


def randint(rng: np.random.Generator, low: int, high: int) -> int:
    """Draw an integer from low..high, both included, with equal probabilities; from `Streams`, one for each map."""
    drawn = rng.random() * (high - low + 1)
    return low + (int(drawn) if isinstance(drawn, float) else drawn.astype("int64"))


_WORDS = 4
"""32-bit words of a digest, and of the pool into which they are mixed."""

_MULTIPLIER = 0x2360ED051FC65DA44385DF649FCCF645
"""Multiplier of PCG64's 128-bit linear congruential generator (numpy/random/src/pcg64)."""

_BITS_128 = (1 << 128) - 1

_MIX_LEFT, _MIX_RIGHT = 0xCA01F9DD, 0x4973F715
"""Multipliers with which a SeedSequence mixes two words (numpy/random/bit_generator.pyx, as the next ones)."""

_ENTROPY, _STATE = (0x43B0D7E5, 0x931E8875), (0x8B51F9DD, 0x58F38DED)
"""First constant and multiplier of the two hashes of a SeedSequence: of its pool, and of the state that it
generates.
"""


class Streams:
    """The random streams of one obstacle in many maps, read in step: `random()` gives the next number of every map.

    A kind's elementwise `ends` takes them in place of a generator.
    """

    def __init__(self, state: Wide, increment: Wide) -> None:
        self._state, self._increment = state, increment

    @classmethod
    def of(cls, seed: int, indices: Iterable[int], key: str) -> Streams:
        """Return the streams of the obstacle `key` in these maps."""
        import numpy as np

        # The hash of the seed is computed once; each map's digest goes on from there.
        seeded, ending = hashlib.blake2b(f"{seed}/".encode(), digest_size=16), f"/{key}"
        digests = []
        for index in indices:  # as in `generator`, which begins anew
            own = seeded.copy()
            own.update(f"{index}{ending}".encode())
            digests.append(own.digest())
        entropy = np.frombuffer(b"".join(digests), "<u4").reshape(-1, _WORDS).astype(np.uint32)
        words = _generated(_pooled(entropy)).astype("<u4").view("<u8").astype(np.int64)
        state_high, state_low, inc_high, inc_low = np.ascontiguousarray(words.T)
        # pcg_setseq_128_srandom: the increment is odd; one step from 0, the initial state added, one more step.
        increment = (inc_high << 1 | inc_low >> 63 & 1, inc_low << 1 | 1)
        begun = _plus(increment, (state_high, state_low))
        return cls(_plus(_times(begun, _wide(_MULTIPLIER)), increment), increment)

    @classmethod
    def at(cls, rng: np.random.Generator) -> Streams:
        """Return one stream, which goes on where a generator is; the generator stays there."""
        import numpy as np

        state: Any = rng.bit_generator.state
        wides = (_wide(state["state"][name]) for name in ("state", "inc"))
        ((high, low), (inc_high, inc_low)) = wides
        halves = [np.array([half], dtype=np.int64) for half in (high, low, inc_high, inc_low)]
        return cls((halves[0], halves[1]), (halves[2], halves[3]))

    def __len__(self) -> int:
        return len(self._increment[0])

    def part(self, maps: Any) -> Streams:
        """Return the streams of some of the maps: a slice, a mask or indices."""
        state, increment = ((high[maps], low[maps]) for high, low in (self._state, self._increment))
        return Streams(state, increment)

    def put(self, maps: Any, part: Streams) -> None:
        """Let the streams of some of the maps go on from the state of a `part`."""
        (high, low), (of_part_high, of_part_low) = self._state, part._state
        self._state = high.copy(), low.copy()  # copies of these streams stay where they are
        self._state[0][maps], self._state[1][maps] = of_part_high, of_part_low

    def skip(self, count: int) -> None:
        """Leave out this number of random numbers of every map."""
        if count:
            factor, term = _jump(count)
            self._state = _plus(_times(self._state, factor), _times(self._increment, term))

    def drawn(self, shape: Sequence[int]) -> Any:
        """Return the next numbers of every map, (maps, *shape), and go on behind them."""
        numbers = self.arrays(shape)
        self.skip(prod(shape))
        return numbers

    def copy(self) -> Streams:
        """Return streams that go on from the same place."""
        return Streams(self._state, self._increment)

    def on_device_of(self, array: Any) -> Streams:
        """Return the streams where an array is: as they are, or as tensors on its device."""
        from rsegen.params.arrays import asarray

        state, increment = ((asarray(high, array), asarray(low, array)) for high, low in (self._state, self._increment))
        return Streams(state, increment)

    def random(self) -> Any:
        """Return the next number of every map, in [0, 1): (maps,), float64."""
        self._state = _plus(_times(self._state, _wide(_MULTIPLIER)), self._increment)
        return _fraction(self._state)

    def arrays(self, shape: Sequence[int]) -> Any:
        """Return the next numbers of every map, (maps, *shape); the streams stay where they are."""
        import numpy as np

        if isinstance(self._state[0], np.ndarray):
            numbers = np.empty((len(self), *shape))
            for own, rng in zip(numbers, self.generators(), strict=True):
                rng.random(out=own)
            return numbers
        return self.jumped(shape)

    def jumped(self, shape: Sequence[int]) -> Any:
        """Return the numbers of `arrays`, each by its own jump: on a device that has no generator of numpy."""
        from rsegen.params.arrays import asarray

        jumps = ((asarray(high, self._state[0]), asarray(low, self._state[0])) for high, low in _jumps(prod(shape)))
        state, increment = ((high[:, None], low[:, None]) for high, low in (self._state, self._increment))
        factor, term = jumps
        return _fraction(_plus(_times(state, factor), _times(increment, term))).reshape(len(self), *shape)

    def generators(self) -> Iterator[np.random.Generator]:
        """Yield the generator of each map: one object in another state each time, so use one at a time."""
        import numpy as np

        bits = np.random.PCG64(0)
        rng = np.random.Generator(bits)
        inner: dict[str, int] = {}
        state: Any = {"bit_generator": "PCG64", "state": inner, "has_uint32": 0, "uinteger": 0}
        halves = (part.view(np.uint64).tolist() for part in (*self._state, *self._increment))
        for state_high, state_low, inc_high, inc_low in zip(*halves, strict=True):
            inner["state"], inner["inc"] = state_high << 64 | state_low, inc_high << 64 | inc_low
            bits.state = state
            yield rng


_LOW_32, _LEAST = 0xFFFFFFFF, -(1 << 63)


def _wide(number: int) -> tuple[int, int]:
    """Return an integer of 128 bits as two of 64 with a sign, the high half first."""
    high, low = number >> 64, number & (1 << 64) - 1
    return high - (high >> 63 << 64), low - (low >> 63 << 64)


def _upper(number: Any) -> Any:
    """Return the upper 32 bits of integers of 64 bits, which are taken as without a sign."""
    return number >> 32 & _LOW_32


def _plus(left: Wide, right: Wide) -> Wide:
    """Return the sums of integers of 128 bits."""
    low = left[1] + right[1]
    carry = (low ^ _LEAST) < (left[1] ^ _LEAST)  # compared as without a sign
    return left[0] + right[0] + carry, low


def _times(left: Wide, right: Wide) -> Wide:
    """Return the products of integers of 128 bits, of which the lower 128 bits count: long multiplication."""
    (a_high, a_low), (b_high, b_low) = left, right
    # In digits of 32 bits, whose products fit into 64; the high halves only add to the high half of the result.
    a1, a0, b1, b0 = _upper(a_low), a_low & _LOW_32, _upper(b_low), b_low & _LOW_32
    first, second = a1 * b0, a0 * b1
    middle = _upper(a0 * b0) + (first & _LOW_32) + (second & _LOW_32)
    high = a1 * b1 + _upper(first) + _upper(second) + (middle >> 32)
    return high + a_high * b_low + a_low * b_high, a_low * b_low


def _fraction(state: Wide) -> Any:
    """Return PCG64's output of each state (XSL RR: both halves xor, turned right by the upper 6 bits), in [0, 1)."""
    from rsegen.params.arrays import cast

    mixed, turn = state[0] ^ state[1], state[0] >> 58 & 63
    right = mixed >> turn & ~((_LEAST >> turn) << 1)  # zeros from the left
    return cast((right | mixed << (64 - turn & 63)) >> 11 & (1 << 53) - 1, "float64") * 2.0**-53


@lru_cache(maxsize=8)
def _jumps(count: int) -> tuple[Wide, Wide]:
    """Return A^k and (A^k - 1) / (A - 1) for k = 1 .. count, by which a generator goes on by k steps."""
    import numpy as np

    factor, term, factors, terms = 1, 0, list[tuple[int, int]](), list[tuple[int, int]]()
    for _ in range(count):
        term = term * _MULTIPLIER + 1 & _BITS_128
        factor = factor * _MULTIPLIER & _BITS_128
        factors.append(_wide(factor))
        terms.append(_wide(term))
    (a, b), (c, d) = (np.array(rows, dtype=np.int64).T for rows in (factors, terms))
    return (a, b), (c, d)


@lru_cache(maxsize=1024)
def _jump(count: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return A^k and (A^k - 1) / (A - 1) for one k."""
    # The quotient modulo 2^128 needs the power modulo (A - 1) 2^128.
    power = pow(_MULTIPLIER, count, (_MULTIPLIER - 1) << 128)
    return _wide(power & _BITS_128), _wide((power - 1) // (_MULTIPLIER - 1) & _BITS_128)


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
