"""The parameters of what rises evenly: a metric, the robot that it is of, and from where to where."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

from rsegen.errors import ParameterError, shown
from rsegen.field.crossing import CrossingModel, StepLimits, robot_that_crosses
from rsegen.params.command import Shell
from rsegen.params.sorts import Flag, Float, Json, Parameter, Reference


@dataclass(frozen=True)
class CrosserSort(Parameter):
    """A robot, of a kind or of a file, or limits of steps, as climb, drop and width in cm."""

    help: str = ""

    def check(self, where: str, value: object) -> CrossingModel:
        if isinstance(value, CrossingModel):
            return value
        if isinstance(value, str | os.PathLike):
            return robot_that_crosses(value, where)
        if not isinstance(value, list | tuple) or not 1 <= len(value) <= 3:
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        names = ("climb_cm", "drop_cm", "width_cm")
        lengths = (Float(0, 100_000, unit="cm").check(where, length) for length in value)
        return StepLimits(**dict(zip(names, lengths, strict=False)))

    def parse(self, text: str) -> object:
        return [Float().parse(part) for part in text.split(",")] if text[:1].isdecimal() else text

    def format(self, value: Any) -> str:
        return value if isinstance(value, str) else ",".join(map(str, value))

    def schema(self) -> dict[str, Json]:
        numbers = {"type": "array", "items": {"type": "number", "minimum": 0}, "minItems": 1, "maxItems": 3}
        return {"anyOf": [{"title": "a robot", "type": "string"}, {"title": "climb, drop and width", **numbers}]}

    def describe(self) -> str:
        return "a kind of robot or a file of one, or steps up, down and a width in cm, as in 7,7,30"


def _metrics() -> Iterable[str]:
    from rsegen.measuring.catalogue import METRICS, UNITS

    return [*UNITS, *METRICS]


By = Annotated[
    Any,
    Reference(
        "a metric by its name",
        help="metric that rises evenly, such as opening.west_east or, with a robot, reach.west_east.tilt",
        types=(object,),
    ),
    Shell(metavar="METRIC", known=_metrics),
]


ByRobot = Annotated[
    CrossingModel | str | None,
    CrosserSort(help="robot, or limits of steps, for this metric"),
    Shell(metavar="KIND|FILE|CM,CM,CM"),
]


From = Annotated[float, Float(0, 1, help="difficulty of the first map"), Shell(("--from",), "D")]

To = Annotated[float, Float(0, 1, help="difficulty of the last map"), Shell(metavar="D")]

SameField = Annotated[bool, Flag(help="one field at rising difficulty, not a new field for each map")]
