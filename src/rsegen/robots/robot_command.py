"""The command `rsegen robot`: the robots that rsegen has, or what was read of one, and where each figure is from."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import zip_longest
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.parameters import Force
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.errors import ParameterError, some_of
from rsegen.params.command import Shell, add_flags
from rsegen.params.numbers import counted
from rsegen.pictures.flags import PictureName, PictureRequest, picture_of

if TYPE_CHECKING:
    from rsegen.field.stepfield import Array
    from rsegen.robots.base import Robot
    from rsegen.robots.files.sdf_file import SdfRobot
    from rsegen.robots.lookup import DrivableRobot


@dataclass(frozen=True, kw_only=True, slots=True)
class Figure:
    """A figure of a robot in words, as numbers with their unit where it has some, and its origin in words."""

    name: str
    text: str
    origin: str
    value: float | Sequence[float] | None = None
    unit: str = ""


_DIGITS = 9
"""Decimals of a figure: those that sums of floats add behind them mean nothing."""


def _measured(name: str, value: float | Sequence[float], unit: str, origin: str = "") -> Figure:
    """Return a figure of one number, or the sides of a size."""
    if isinstance(value, Sequence):
        text, value = " x ".join(f"{side:.3f}" for side in value), [round(side, _DIGITS) for side in value]
    else:
        text, value = f"{value:.4g}", round(value, _DIGITS)
    return Figure(name=name, text=f"{text} {unit}", origin=origin, value=value, unit=unit)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Picture:
    """The picture that the shell can ask for."""

    picture: Annotated[
        PictureName,
        Shell(
            ("--picture",),
            "PICTURE",
            "draw its visual and its collision shapes side by side: png, svg, pdf, jpg or webp, by its ending",
        ),
    ] = None
    force: Force = False


def add_robot(command: Parser) -> None:
    """Add the arguments of `rsegen robot`."""
    command.explain(
        "List the robots of rsegen; or print the mass, size, wheels, speed, friction, motors, front, balance, supports "
        "and clearance of one of them or of your own file, with the source of each figure, what was assumed, and what "
        "is left out.",
        "rsegen drive, metrics, predict and all other commands accept the same robots.",
    )
    text = "a kind of robot, or an SDF, URDF, Xacro or MJCF file, as 'FILE NAME:=VALUE ...' with arguments"
    command.add_argument("robot", nargs="?", metavar="KIND|FILE", help=f"{text} (default: list the kinds)")
    group = command.group("robot")
    group.add_argument("--wheels", metavar="LEFT,RIGHT", help="joints of its wheels, instead of those found")
    group.add_argument("--tracks", metavar="LEFT,RIGHT", help="links of its tracks, instead of those found")
    add_flags(command.group("output"), _Picture)


def run_robot(arguments: argparse.Namespace) -> Report:
    """List the robots, or read one, and list its figures."""
    from rsegen.robots.files.sdf_file import SdfRobot
    from rsegen.robots.lookup import chosen_robot

    if arguments.robot is None:
        for name in ("wheels", "tracks", "picture"):
            if getattr(arguments, name):
                raise ParameterError(f"--{name}", "is for one robot: name it first")
        return _kinds()
    picture = picture_of(arguments.picture, force=arguments.force)
    robot = chosen_robot(arguments.robot, arguments.wheels, arguments.tracks)
    gaps = _draw(robot, picture) if picture else ()
    if not isinstance(robot, SdfRobot):
        return _report(robot.kind, list(_of_kind(robot)), gaps)
    return _report(robot.kind, list(_of_file(robot)), (*_remarks(robot), *gaps))


def _draw(robot: DrivableRobot, picture: PictureRequest) -> list[str]:
    """Write the picture of a robot, and return what is not in it."""
    from rsegen.robots.robot_picture import picture_and_gaps

    gaps: list[str] = []

    def drawn(form: str) -> bytes:
        content, missing = picture_and_gaps(robot, form)
        gaps.extend(missing)
        return content

    picture.write(drawn)
    return gaps


def _kinds() -> Report:
    """List every robot by its kind: what it is, its size, mass, drive, the step that it climbs, and a picture of it."""
    from rsegen.robots.base import ROBOTS

    rows = [("kind", "size", "mass", "drive", "climbs", "picture in the manual", "")]
    for kind, robot in ROBOTS.items():
        length, width, height = (f"{100 * side:.4g}" for side in robot.size)
        size, climbs = f"{length} x {width} x {height} cm", f"{100 * robot.climbs:.4g} cm"
        rows.append((kind, size, f"{robot.mass:.3g} kg", _drive_in_words(robot), climbs, _picture(kind), robot.title))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(f"{text:<{width}}" for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    lines += [
        "",
        "climbs: the highest single step that it drives up in Gazebo Classic, measured",
        "rsegen robot KIND prints its other figures, and rsegen robot FILE those of your own robot.",
    ]
    return Report(lines=lines, content={"robots": [_content(kind, robot) for kind, robot in ROBOTS.items()]})


def _content(kind: str, robot: Robot) -> dict[str, Any]:
    """Return what is listed of a robot, in metres, kilograms and seconds."""
    return {
        "kind": kind,
        "title": robot.title,
        "size": list(robot.size),
        "mass": round(robot.mass, _DIGITS),
        "drive": _drive_in_words(robot),
        "speed": robot.speed,
        "turn": robot.turn,
        "climbs": robot.climbs,
        "picture": _picture(kind) or None,
        "source": robot.source,
    }


def _drive_in_words(robot: Robot) -> str:
    from rsegen.robots.drives import Tracks

    sides = (robot.drive.left, robot.drive.right)
    if not isinstance(robot.drive, Tracks):
        return f"{sum(map(len, sides))} wheels"
    flippers = sum(len(side) - 1 for side in sides)
    return f"{len(sides)} tracks" + (f", {flippers} flippers" if flippers else "")


def _picture(kind: str) -> str:
    """Return where rsegen's source has a picture of a robot; empty for a robot of a plug-in."""
    from rsegen.robots.base import ROBOTS

    return "" if ROBOTS.source(kind) else f"docs/pictures/small-{kind}.webp"


_USUAL_WIDTH = 100
"""Letters of a line if the output is no terminal, and COLUMNS is not set."""

_LEAST = 16
"""Letters of a column at the least, however narrow the terminal is."""


def _rows(figures: Sequence[Figure], width: int) -> Iterator[str]:
    """Yield the lines of a table of figures, each at most `width` letters long: long texts go on in the next line."""
    names, values, origins = (
        max(map(len, column)) for column in zip(*((f.name, f.text, f.origin) for f in figures), strict=True)
    )
    # The values get what the origins leave, at least a half; their column then is as wide as their longest line.
    room = width - names - 4  # two blanks between columns
    broken = [_broken(figure.text, max(room - min(origins, room // 2), _LEAST)) for figure in figures]
    values = max(len(line) for lines in broken for line in lines)
    for figure, value_lines in zip(figures, broken, strict=True):
        columns = ([figure.name], value_lines, _broken(figure.origin, max(room - values, _LEAST)))
        for name, value, origin in zip_longest(*columns, fillvalue=""):
            yield f"{name:<{names}}  {value:<{values}}  {origin}".rstrip()


def _broken(text: str, width: int) -> list[str]:
    """Return a text in lines of a width, broken at blanks, after the + between joints, or else within a name."""
    lines = [""]
    for word in re.findall(r"\s*[^\s+]*\+?", text):
        if len(lines[-1]) + len(word) > width:
            lines.append("")
        piece = word if lines[-1] else word.lstrip()
        # A name that is longer than a line is cut into lines of its own.
        lines[-1:] = [lines[-1] + piece[:width], *(piece[at : at + width] for at in range(width, len(piece), width))]
    return [line for line in lines if line] or [""]


def _with_shared_origin(figures: Sequence[Figure]) -> list[Figure]:
    """Return the figures of a table; an origin that all of them have is in a row of its own, once."""
    if len({figure.origin for figure in figures}) > 1:
        return list(figures)
    bare = [replace(figure, origin="") for figure in figures]
    return [*bare, Figure(name="source", text=figures[0].origin, origin="")]


def _report(kind: str, figures: Sequence[Figure], remarks: Sequence[str]) -> Report:
    lines = [kind, *_rows(_with_shared_origin(figures), get_terminal_size((_USUAL_WIDTH, 0)).columns)]
    content = {"kind": kind, "figures": [asdict(figure) for figure in figures], "remarks": list(remarks)}
    return Report(lines=lines, content=content, notes=remarks)


def _of_kind(robot: Robot) -> Iterator[Figure]:
    """Yield the figures of one of rsegen's robots, which all have one source."""
    drive = robot.drive
    for figure in (
        _measured("mass", robot.mass, "kg"),
        _measured("size", robot.size, "m"),
        Figure(name="drive", text=" and ".join(drive.side_names), origin=""),
        _measured("separation", drive.separation, "m"),
        _measured("radius", drive.radius, "m"),
        _measured("speed", robot.speed, "m/s"),
        _measured("turn rate", robot.turn, "rad/s"),
        *_of_stance(robot),
    ):
        yield replace(figure, origin=robot.source)


def _of_file(robot: SdfRobot) -> Iterator[Figure]:
    """Yield the figures of a robot of a file, each with what it was read from, measured on, or assumed for."""
    from rsegen.robots.drives import Wheels
    from rsegen.robots.files.motors import frictions, motor
    from rsegen.robots.files.sdf_shapes import inertials, links_by_default

    # First what every model has, links and shapes; then the drive, or why it has none; last what that drives on.
    frames = robot.frames()
    masses = inertials(frames)
    bare = links_by_default(frames)
    origins = [f"the <inertial> of {counted(len(masses) - len(bare), 'link')}"] if len(masses) > len(bare) else []
    origins += [f"1 kg each, as SDF has it, for {counted(len(bare), 'link')} without a mass"] if bare else []
    mass = sum(body.mass for body in masses.values())
    yield _measured("mass", mass, "kg", "; ".join(origins))
    kinds: dict[str, int] = {}
    for _, _, geometry in frames.collisions():
        kinds[geometry[0].tag] = kinds.get(geometry[0].tag, 0) + 1
    shapes = ", ".join(f"{kind} {count}" for kind, count in kinds.items())
    count = sum(kinds.values())
    yield Figure(name="shapes", text=str(count), value=count, origin=f"its <collision>: {shapes or 'none'}")
    measured = "the box around its collision shapes, about its origin"
    yield _measured("size", robot.size, "m", _assumed(robot, "size") or measured)
    read = robot.read_drive
    if read is None:
        why = (
            f"{', '.join(robot.steered)} {'is' if len(robot.steered) == 1 else 'are'} steered"
            if robot.steered
            else robot.undriven or "not in its file, and no links look like wheels"
        )
        yield Figure(name="drive", text="none", origin=why)
        return
    drive = read.drive
    yield Figure(name="drive", text=" and ".join(drive.side_names), origin=read.origin)
    yield _measured("separation", drive.separation, "m", read.separation_by)
    yield _measured("radius", drive.radius, "m", read.radius_by)
    yield _measured("speed", robot.speed, "m/s", _assumed(robot, "speed") or read.limits_by)
    yield _measured("turn rate", robot.turn, "rad/s", _assumed(robot, "turn") or read.limits_by)
    if isinstance(drive, Wheels):
        motors = {motor(drive, joint, frames): None for joint in drive.joints}
        torques = [torque for torque, _ in motors]
        text = ", ".join("no limit" if torque is None else f"{torque:.4g} Nm" for torque in torques)
        where = " and ".join(dict.fromkeys(origin for _, origin in motors))
        uses = "" if all(torques) else ": in MuJoCo only friction limits its push"
        known = [torque for torque in torques if torque is not None]
        value = known if len(known) == len(torques) else None
        yield Figure(name="motor", text=text, origin=f"{where}{uses}", value=value, unit="Nm" if value else "")
    else:
        yield Figure(name="motor", text="no limit", origin="no torque of tracks is read: only friction limits its push")
    mu = sorted({*frictions(drive, frames)})
    acting = [*dict.fromkeys(min(value, 1.0) for value in (*mu[:1], *mu[-1:]))]
    limits = " to ".join(f"{value:g}" for value in acting) or "none"
    more = f"; {mu[-1]:g} acts as 1, as blocks have no more" if mu and mu[-1] > 1 else ""
    origin = f"<mu> of what it drives on, 1 if missing{more}" if mu else "what it drives on has no collision shapes"
    yield Figure(name="friction", text=limits, origin=origin, value=acting or None)
    if mu and "size" in robot.derived:
        yield from _of_stance(robot)


def _of_stance(robot: DrivableRobot) -> Iterator[Figure]:
    """Yield the figures of a robot on level ground: its front and balance, and what else touches the ground, or may."""
    import numpy as np

    from rsegen.robots.files.sdf_elements import part_name
    from rsegen.standing.stance import stance

    body = robot.body
    # All lengths count from the middle between the foremost and the rearmost point of what drives.
    on_level, driven = stance(body), np.array([part.drives for part in body.parts])
    lengths = [surface[:, 0] for surface in body.by_part(body.surface)]  # of each part, along x
    middle = _middle(np.concatenate([x for x, drives in zip(lengths, driven, strict=True) if drives]))
    yield Figure(name="front", text="along x of its model", origin="as in ROS and Gazebo")
    ahead, high = float(body.centre[0]) - middle, float(body.centre[2])
    text, origin = f"{_ahead(ahead)}, {high:.3f} m high", "its centre of mass, from the middle of what it drives on"
    yield Figure(
        name="balance", text=text, origin=origin, value=(round(ahead, _DIGITS), round(high, _DIGITS)), unit="m"
    )
    supports = np.flatnonzero(on_level.bearing & ~driven)
    names = [f"{part_name(body.parts[at].name)} {_ahead(_middle(lengths[at]) - middle)}" for at in supports]
    mu = sorted({body.parts[at].mu for at in supports})
    slides = f"; friction {' to '.join(f'{value:g}' for value in (*mu[:1], *mu[1:][-1:]))}" if mu else ""
    origin = f"what nothing drives, and touches level ground{slides}"
    yield Figure(name="supports", text=some_of(names) or "none", origin=origin)
    # What neither drives nor bears the robot hangs: the lowest of it is the first to be held by a block.
    hanging = np.where(driven | on_level.bearing, np.inf, on_level.heights)
    lowest = int(hanging.argmin())
    if np.isfinite(hanging[lowest]):
        origin = f"the lowest of all else above level ground, {part_name(body.parts[lowest].name)}"
        height = float(hanging[lowest])
        yield Figure(name="clearance", text=f"{height:.3f} m", origin=origin, value=round(height, _DIGITS), unit="m")
    if not on_level.pose.stands[0]:
        yield Figure(name="stands", text="no", origin="on level ground it tips over, as its centre of mass is outside")


def _middle(values: Array) -> float:
    """Return the middle between the least and the largest of values."""
    return float(values.min() + values.max()) / 2


def _ahead(metres: float) -> str:
    """Return how far ahead or behind a place is, in words."""
    return f"{abs(metres):.3f} m {'behind' if metres < 0 else 'ahead'}"


def _remarks(robot: SdfRobot) -> Iterator[str]:
    from rsegen.robots.files.holding import has_spring

    yield from robot.remarks
    if light := robot.light_wheels:
        yield light
    if followers := robot.followers:
        yield f"follow another joint in MuJoCo, and in Gazebo move on their own, unless held: {', '.join(followers)}"
    held = robot.held
    if held:
        yield f"held in a drive as its model has them, as nothing drives them: {', '.join(held)}"
    sprung = [name for name, joint in robot.frames().joints.items() if has_spring(joint) and name not in held]
    if sprung:
        yield f"moves on springs in a drive, where poses take it as rigid: {', '.join(sprung)}"


def _assumed(robot: SdfRobot, name: str) -> str:
    return "assumed, as its file does not say" if name in robot.assumed else ""
