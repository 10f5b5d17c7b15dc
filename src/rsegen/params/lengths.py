"""Lengths with their unit, as in `3.5in`, `8ft`, `38mm`."""

from __future__ import annotations

import re

from rsegen.errors import ParameterError, shown
from rsegen.params.sorts import Float, ListOf, Parameter

CENTIMETRES = {"cm": 1.0, "mm": 0.1, "m": 100.0, "in": 2.54, "ft": 30.48}
"""Centimetres of each unit of length."""

_LENGTH = re.compile(rf"\s*([0-9]*\.?[0-9]+)\s*({'|'.join(sorted(CENTIMETRES, key=len, reverse=True))})\s*")
_NUMBER = re.compile(r"\s*[-+]?[0-9.]+(e[-+]?[0-9]+)?\s*")


def with_lengths(text: str, parameter: Parameter, where: str, *, units: str | None = None) -> str:
    """The text of a parameter with every length as a number of its unit, cm or mm; other parameters as they are.

    units: if that is `in`, a ParameterError for a length without a unit, which could be either.
    """
    sort = parameter.sort if isinstance(parameter, ListOf) else parameter
    if not isinstance(sort, Float) or sort.unit not in ("cm", "mm"):
        return text
    parts = text.split(",") if isinstance(parameter, ListOf) else [text]
    return ",".join(_number(part, sort.unit, where, units) for part in parts)


def _number(text: str, unit: str, where: str, units: str | None) -> str:
    found = _LENGTH.fullmatch(text)
    if found:
        return repr(round(float(found[1]) * CENTIMETRES[found[2]] / CENTIMETRES[unit], 7))
    if units == "in" and _NUMBER.fullmatch(text):
        raise ParameterError(
            where, f"{shown(text)} has no unit; with units in give {text.strip()}in or {text.strip()}{unit}"
        )
    return text
