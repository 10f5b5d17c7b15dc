"""Parameters that several commands share, and sorts of them that look something up."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.errors import ParameterError, refuse_unknown, shown
from rsegen.params.command import Shell
from rsegen.params.sorts import FilePath, Flag, Float, Integer, Json, Parameter, Reference, Text, key_values, parameters

if TYPE_CHECKING:
    from rsegen.exporters.formats import Format
    from rsegen.field.metrics.catalogue import Crosser
    from rsegen.robots.lookup import DrivableRobot

Force = Annotated[bool, Flag(help="replace the file, or a folder that rsegen wrote and nobody has changed since")]

Resume = Annotated[
    bool,
    Flag(
        help="continue a stopped run: keep what is complete and as it would be made now, and make the rest; needs the "
        "same recipe, seed and options"
    ),
]

Workers = Annotated[
    int,
    Integer(1, help="processes that work at the same time"),
    Shell(metavar="N", default="the number of cores"),
]

Scheduler = Annotated[
    str | None,
    Reference(
        "tcp://HOST:PORT, or local",
        help="make it on a Dask cluster whose workers see the same folder, as tcp://HOST:PORT, or local for one of "
        "--workers processes; needs rsegen[cluster]",
    ),
    Shell(metavar="ADDRESS"),
]

Sync = Annotated[
    bool,
    Flag(help="wait until files are on disk"),
    Shell(
        help="do not wait until files are on disk: a little faster for many small maps; after a power failure some may "
        "be empty, and --resume makes them again"
    ),
]

OutputFolder = Annotated[
    str | Path, FilePath(help="folder to write into"), Shell(("-o", "--output"), "DIR", required=True)
]

Preview = Annotated[bool, Flag(help="add a picture, preview.png, to every map")]

Sheet = Annotated[bool, Flag(help="add a build sheet, sheet.pdf and sheet.csv, to every map (see rsegen sheet)")]

MapReference = Annotated[
    int | str | None,
    Reference("an index or a name", help="which map, by its index or its name", types=(str, int)),
    Shell(metavar="INDEX", default="the first"),
]

SimulatorName = Annotated[
    str | None,
    Reference("sim or classic", help="Gazebo Sim (sim) or Gazebo Classic (classic)"),
    Shell(metavar="NAME", default="the newest that is installed"),
]

RunningSimulator = Annotated[SimulatorName, Shell(default="whichever runs")]

Timeout = Annotated[
    float,
    Float(1.0, 1e6, unit="s", help="give a simulator up that shows no progress for so long; more on a busy machine"),
    Shell(metavar="S"),
]

MapsFolder = Annotated[
    str | Path,
    FilePath(help="folder for maps that are made of recipes, which are kept there"),
    Shell(("-o", "--output"), "DIR"),
]

_ROBOT = Reference(
    "a kind of robot, or a file of one",
    help="kind of robot, or SDF, URDF or Xacro file, as 'FILE NAME:=VALUE ...' with arguments",
    types=(object,),
)

RobotModel = Annotated["str | os.PathLike[str] | DrivableRobot", _ROBOT, Shell(metavar="KIND|FILE")]

AnyRobot = Annotated["str | os.PathLike[str] | DrivableRobot | None", _ROBOT, Shell(metavar="KIND|FILE")]

ModelName = Annotated[
    str | None, Text(r"[^\x00-\x1f]{1,200}", "a name", help="name of the model"), Shell(metavar="NAME")
]


@dataclass(frozen=True)
class FormatList(Parameter):
    """Formats of other programs: in Python as objects, in a shell as in `stl,'mjcf shape=hfield'`.

    flag: by which errors name them
    """

    flag: str = "--formats"
    help: str = ""
    repeats: bool = True

    def check(self, where: str, value: object) -> tuple[Format, ...]:
        from rsegen.exporters.formats import Format

        if isinstance(value, str | Format) or not isinstance(value, Sequence):
            raise ParameterError(where, f"{shown(value)} is not a list of formats, as in [rsegen.FORMATS['stl']()]")
        for index, given in enumerate(value):
            if not isinstance(given, Format):
                raise ParameterError(f"{where}[{index}]", f"{shown(given)} is no format, as rsegen.FORMATS['stl']() is")
        return tuple(value)

    def parse(self, texts: Any) -> tuple[Format, ...]:
        from rsegen.exporters.formats import FORMATS

        # All texts of the flag, which may be repeated.
        parts = [part or [""] for text in texts for part in _parts(self.flag, text)]
        named = [(FORMATS.named(name, self.flag), words) for name, *words in parts]
        return tuple(_with_options(self.flag, cls, words) for cls, words in named)

    def format(self, value: Any) -> str:
        return ",".join(each.name for each in value)

    def schema(self) -> dict[str, Json]:
        return {"type": "array", "items": {"type": "string"}}

    def describe(self) -> str:
        return "separated by commas, with options as in stl,'mjcf shape=hfield'"


def _parts(where: str, text: str) -> list[list[str]]:
    """Return the words between commas of a text such as `stl,mjcf shape=hfield`; one without = begins a part, too."""
    lexer = shlex.shlex(text, posix=True, punctuation_chars=",")
    lexer.whitespace_split, lexer.commenters = True, ""
    parts: list[list[str]] = [[]]
    try:
        for word in lexer:
            if word.strip(",") == "":
                parts += [[] for _ in word]
            elif parts[-1] and "=" not in word:
                parts.append([word])
            else:
                parts[-1].append(word)
    except ValueError:
        raise ParameterError(f"{where} {shown(text)}", "a quotation mark is not closed") from None
    return parts


def _with_options(where: str, cls: type[Format], words: Sequence[str]) -> Format:
    """Return a format with the options that are given after its name."""
    known = parameters(cls)
    try:
        own = key_values(words, known)
        refuse_unknown(f"option of {cls.name}", own, known)
        return cls(**own)
    except ParameterError as error:
        raise error.of(f"{where} {shown(' '.join([cls.name, *words]))}") from None


Formats = Annotated[
    "Sequence[Format]",
    FormatList(help="add files for other programs to every map; may be repeated"),
    Shell(metavar="'FORMAT KEY=VALUE ...'"),
]


@dataclass(frozen=True)
class CrosserSort(Parameter):
    """A robot, of a kind or of a file, or limits of steps, as climb, drop and width in cm."""

    help: str = ""

    def check(self, where: str, value: object) -> Crosser:
        from rsegen.field.limits import StepLimits
        from rsegen.field.metrics.catalogue import Crosser
        from rsegen.robots import robot_of

        if isinstance(value, Crosser):
            return value
        if isinstance(value, str | os.PathLike):
            return robot_of(value, where)
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
        return {"anyOf": [{"type": "string"}, numbers]}

    def describe(self) -> str:
        return "a kind of robot or a file of one, or steps up, down and a width in cm, as in 7,7,30"


By = Annotated[
    Any,
    Reference(
        "a metric by its name",
        help="what rises evenly, as in opening.west_east or, with a robot, reach.west_east.tilt",
        types=(object,),
    ),
    Shell(metavar="METRIC"),
]

ByRobot = Annotated[
    "Crosser | str | None",
    CrosserSort(help="robot, or limits of steps, of the metric by which it rises"),
    Shell(metavar="KIND|FILE|CM,CM,CM"),
]


class Place(Parameter):
    """A pose on the ground: x and y, then perhaps z, then perhaps yaw, in metres and radians."""

    help = "pose in metres and radians, as in --at=-2,0"
    _metres = Float(-1e6, 1e6)

    def check(self, where: str, value: object) -> tuple[float, ...]:
        if not isinstance(value, Sequence) or isinstance(value, str) or not 2 <= len(value) <= 4:
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        return tuple(self._metres.check(f"{where}[{axis}]", length) for axis, length in enumerate(value))

    def parse(self, text: str) -> object:
        parts = text.split(",")
        return [self._metres.parse(part) for part in parts] if 2 <= len(parts) <= 4 else text

    def format(self, value: Any) -> str:
        return ",".join(map(str, value))

    def schema(self) -> dict[str, Json]:
        return {"type": "array", "items": self._metres.schema(), "minItems": 2, "maxItems": 4}

    def describe(self) -> str:
        return "X,Y or X,Y,Z or X,Y,Z,YAW"
