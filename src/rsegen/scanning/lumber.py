"""Lengths of lumber as it is sold, to which measured lengths are rounded.

Posts are sold in whole half-centimetres (75, 90, 95, 100 mm), or in the USA and Canada in inches that are smaller than
their name says: a 4x4 is 3 1/2 inches wide, 88.9 mm. A length counts as the nearest of these. It fails for two sizes
that are closer to each other than a scan can measure, such as 139.7 and 140 mm: `alternatives` has the others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rsegen.params.numbers import DRESSED

_INCH = 0.0254
_NEARLY = 0.015
"""Share by which a measured length may differ from one that is sold to be taken for it.

Widths of scans are off by 0.1 to 0.3 % (docs/scan.md), gaps between posts add up to 1 %; 88.9 and 90 mm differ by
1.2 %, so the nearest counts."""


def sold_length(metres: float, others: Sequence[float] = ()) -> float:
    """Return the length of sold lumber, or one of some others, that is nearest to a length, else whole millimetres [m].

    others: lengths that are as likely, such as the width of a block for its height
    """
    sizes = _near(metres, others)
    return round(sizes[0], 6) if sizes else round(metres, 3)


def alternatives(metres: float, taken: float) -> Iterator[float]:
    """Yield the lengths of sold lumber other than the one that was taken which are near to a length as well [m]."""
    yield from (round(size, 6) for size in _near(metres) if abs(size - taken) > 1e-6)


def _near(metres: float, others: Sequence[float] = ()) -> list[float]:
    """Return the lengths within _NEARLY of a length, the nearest first."""
    sizes = {round(metres * 200) / 200, *(inches * _INCH for inches in DRESSED), *others}
    return sorted(
        (size for size in sizes if abs(size - metres) < _NEARLY * metres), key=lambda size: abs(size - metres)
    )


def dressed_inches(metres: float) -> float | None:
    """Return the inches of dressed lumber that has exactly a length, None if none has."""
    return next((inches for inches in DRESSED if abs(inches * _INCH - metres) < 1e-6), None)
