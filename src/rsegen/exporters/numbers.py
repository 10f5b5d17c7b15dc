"""The number format of everything that rsegen writes."""

from __future__ import annotations

from functools import lru_cache

from rsegen.field.stepfield import NANOMETRE_DIGITS


@lru_cache(maxsize=2**14)
def decimal(value: float) -> str:
    """A plain decimal to the nanometre, without trailing zeros: 0.3, -1.25, 0."""
    text = f"{value:.{NANOMETRE_DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
