"""The sizes and speeds that a robot may have, whether a flag gives them or an SDF file."""

from __future__ import annotations

from collections.abc import Mapping

from rsegen.errors import FileError, ParameterError
from rsegen.params.sorts import Float, ListOf, Parameter

SIDE = Float(0.01, 100, unit="m")

SPEED, TURN = Float(0.001, 100, unit="m/s"), Float(0.001, 100, unit="rad/s")

LIMITS: Mapping[str, Parameter] = {"size": ListOf(SIDE, 3), "speed": SPEED, "turn": TURN}
"""By the names of the flags."""

WHEEL = Float(0.001, SIDE.high, unit="m")
"""Radius and separation of wheels and tracks, which no flag gives."""


def refuse_outside(sort: Parameter, value: object, what: str) -> None:
    """Raise a FileError if a value of a file is not what `sort` takes; `what` begins with the file."""
    try:
        sort.check("", value)
    except ParameterError as error:
        raise FileError(f"{what}: {error.problem}; lengths in SDF are metres") from None
