"""The levels of a map's blocks in two texts: CSV, north up, and a fingerprint.

A fingerprint is a short name for levels, by which two sites know that they built the same field: 40 bits of a hash, so
of a million different fields two have the same one with a probability of a third, and of two fields hardly ever.
"""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import blake2b

from rsegen.exporters.numbers import decimal
from rsegen.field.stepfield import Levels, StepField


def csv(field: StepField) -> Iterator[bytes]:
    """Yield the lines of the CSV file: levels in units, without frames, north up; `#` starts a comment."""
    unit = f"{decimal(field.unit * 100)} cm"
    yield f"# block levels in units of {unit}; north up: the top row is the largest y, x grows to the right\n".encode()
    for row in field.blocks.T[::-1]:
        yield (",".join(map(str, row.tolist())) + "\n").encode()


_LETTERS = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
"""Digits of base 32 after Crockford: none of them is read as another one."""


def fingerprint(levels: Levels) -> str:
    """Return eight letters and digits, as in 7K3F-9QXA, of levels (n_x, n_y) without frames, whatever their unit is.

    They are 40 bits of the BLAKE2b hash of "n_x n_y " and the levels as 16-bit numbers, the lowest byte first, along y
    and x.
    """
    n_x, n_y = levels.shape
    digest = blake2b(f"{n_x} {n_y} ".encode() + levels.astype("<i2").tobytes(), digest_size=5).digest()
    bits = int.from_bytes(digest, "big")
    text = "".join(_LETTERS[bits >> shift & 31] for shift in range(35, -1, -5))
    return f"{text[:4]}-{text[4:]}"
