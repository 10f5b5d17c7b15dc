"""Read which joints of a robot ROS drives: from ros2_control or transmissions, and the parameters of a controller.

URDF says which joints take a velocity; which of them are wheels, and their separation, radius and limits, stand in a
YAML file of diff_drive_controller in one of the packages of the robot. That file is one that names joints of the
robot, and nothing else, as wheels, so no name of a package or file is assumed; but makers call joints alike, so its
package has to belong to that of the robot. A file is read as ROS reads it: the last value of a key counts, and a prefix
that a launch file gives, $(arg prefix), is what the joints begin with. Its numbers are the maker's: the separation
times its multiplier makes a robot with four wheels turn as commanded although it skids. Cost: a text search in at most
_MOST_FILES files. What breaks it: controllers of other types, and robots of one repository whose joints are the same.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import suppress
from itertools import chain, islice
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

from rsegen.errors import FileError
from rsegen.input_files import regular_content
from rsegen.recipe.recipe_file import parse_yaml
from rsegen.robots.files.uris import belong_together, packages_around

_MOST_FILES = 300
"""YAML files that are looked into; a robot of ROS has some tens in its packages."""

_LARGEST = 2**18
"""Bytes of a YAML file that is looked into; those of controllers have some thousands."""

_DEEPEST = 3
"""Folders in a package in each other that are looked into: config/humble/... is two."""

_LEFT, _RIGHT = ("left_wheel_names", "left_wheel"), ("right_wheel_names", "right_wheel")
"""Names of the parameter with a side's wheels, of ROS 2 and of ROS."""


_TO_BE_REPLACED = re.compile(r"^(?:\$\([^)]*\)|\$\{[^}]*\}|<[^>]*>|/)+")
"""Placeholder at the start of a joint's name, which a launch file replaces."""


class Controller(NamedTuple):
    """The parameters of a diff_drive_controller, None for what its file does not say; or what else says of wheels.

    where: its file, from its package on; left, right: joints; separation, radius: metres, slip: by which the separation
    is multiplied, as wheels that skid must turn faster; speed, turn: the maximum, m/s and rad/s.
    """

    where: str
    left: Sequence[str]
    right: Sequence[str]
    separation: float | None = None
    radius: float | None = None
    speed: float | None = None
    turn: float | None = None
    slip: float = 1


class Controls(NamedTuple):
    """The joints of a robot that ROS drives, or a file of MuJoCo.

    rates: joints that take a velocity, with its limit, rad/s; controllers: of wheels that are joints of the robot;
    remarks: sentences about files that name wheels, and are not used; rated_by: what has the rates, in words; placed:
    joints that take a position
    """

    rates: Mapping[str, float | None] = {}
    controllers: tuple[Controller, ...] = ()
    remarks: tuple[str, ...] = ()
    rated_by: str = "ros2_control"
    placed: frozenset[str] = frozenset()


def controls(robot: Element, where: Path) -> Controls:
    """Return what ROS drives of a robot of URDF in a file."""
    rates = dict(_commanded(robot, "velocity", "VelocityJointInterface"))
    placed = frozenset(name for name, _ in _commanded(robot, "position", "PositionJointInterface"))
    joints = {joint.get("name", "") for joint in robot.findall("joint")}
    texts = ((element.text or "").strip() for element in robot.iter("parameters"))
    files = [Path(text) for text in texts if text.startswith("/")]
    remarks: list[str] = []
    controllers = tuple(_controllers(where, files, joints, _words(f"{_place(where)} {robot.get('name', '')}"), remarks))
    is_older = robot.find("ros2_control") is None and robot.find("transmission") is not None
    rated_by = "its <transmission>" if is_older else "ros2_control"
    return Controls(rates, controllers, tuple(remarks), rated_by, placed)


def _commanded(robot: Element, quantity: str, of_transmission: str) -> Iterator[tuple[str, float | None]]:
    """Yield the joints that take a quantity in <ros2_control> or <transmission>, with the most of it that stands there.

    of_transmission: a part of the name of its hardware interface there
    """
    for joint in robot.iterfind("ros2_control/joint"):
        for interface in joint.findall("command_interface"):
            if interface.get("name", "").strip() == quantity:
                params = {param.get("name"): param.text for param in interface.findall("param")}
                yield joint.get("name", ""), _positive(params.get("max"))
    for joint in robot.iterfind("transmission/joint"):
        if any(of_transmission in (element.text or "") for element in joint.iter("hardwareInterface")):
            yield joint.get("name", ""), None


def _yaml_files(package: Path) -> Iterator[Path]:
    """Yield the YAML files of a package."""
    waiting = [(package, 0)]
    while waiting:
        folder, depth = waiting.pop(0)
        with suppress(OSError), os.scandir(folder) as entries:
            for entry in sorted(entries, key=lambda entry: entry.name):
                if entry.name.endswith((".yaml", ".yml")):
                    yield Path(entry.path)
                elif depth < _DEEPEST and not entry.name.startswith(".") and entry.is_dir(follow_symlinks=False):
                    waiting.append((Path(entry.path), depth + 1))


def _controllers(
    where: Path, named: Sequence[Path], joints: set[str], words: Set[str], remarks: list[str]
) -> Iterator[Controller]:
    """Yield the controllers all of whose wheels are joints of the robot, in files that it names and of its packages.

    Files called like the robot come first: a package may have one for each of several robots with the same wheels.
    words: of its name and its file; remarks: gets a sentence for each file that cannot be read, and, without any other,
    each of another robot's package
    """

    def likeness(file: Path) -> float:
        own = _words(_place(file))
        return len(own & words) / len(own)

    packages = list(packages_around(where))
    own = [package for package in packages if belong_together(packages[0], package)]
    # Files that the robot names count before those of its packages, which are then not looked into.
    has_own, drives_otherwise = False, _drive_otherwise(named)
    own_files = islice(chain.from_iterable(map(_yaml_files, () if drives_otherwise else own)), _MOST_FILES)
    for files in (iter(named), iter(sorted(own_files, key=likeness, reverse=True))):
        for file, tables in () if has_own else _with_wheels(files, joints, remarks):
            for controller in (controller for table in tables if (controller := _controller(table, joints, file))):
                has_own = True
                yield controller
    others = chain.from_iterable(_yaml_files(package) for package in packages if package not in own)
    for file, tables in () if has_own or drives_otherwise else _with_wheels(others, joints, []):
        if any(_controller(table, joints, file) for table in tables):
            problem = "its wheels are called like those of this robot, but its package belongs to another"
            remarks.append(f"{_place(file)} is not used: {problem}")


_TYPE = re.compile(rb"\btype\s*:\s*[\"']?[\w/:]*?(\w+Controller)\b")
"""The class of a controller in a YAML file of ROS 2; what only publishes is a broadcaster."""


def _drive_otherwise(named: Sequence[Path]) -> bool:
    """Return whether files that a robot names have controllers, but none for two sides of wheels, as for a tricycle.

    Then controllers of two sides in its package are for other robots.
    """
    types = {type_ for file in named for type_ in _TYPE.findall(regular_content(file, _LARGEST) or b"")}
    return bool(types) and b"DiffDriveController" not in types


def _with_wheels(
    files: Iterator[Path], joints: set[str], remarks: list[str]
) -> Iterator[tuple[Path, list[Mapping[Any, Any]]]]:
    """Yield the files that have parameters of wheels, once each, with all their mappings."""
    seen: set[Path] = set()
    for file in islice(files, _MOST_FILES):
        if file in seen:
            continue
        seen.add(file)
        content = regular_content(file, _LARGEST + 1) or b""
        # The loader is slow, and most files have nothing of wheels.
        if len(content) > _LARGEST or b"left_wheel" not in content or b"right_wheel" not in content:
            continue
        try:
            yield file, list(_tables(parse_yaml(content.decode("utf-8"), file, last_counts=True)))
        except FileError as error:  # of another program, or a template of a launch file
            if any(joint and joint.encode() in content for joint in joints):
                remarks.append(f"left out, as it is not read: {str(error).replace(str(file), _place(file), 1)}")
        except UnicodeDecodeError:
            continue


def _words(text: str) -> set[str]:
    """Return the words of the path of a file, or of a name, in small letters."""
    return set(re.findall(r"[a-z0-9]+", text.lower()))


def _place(file: Path) -> str:
    """Return the path of a file from its package on, as it usually is."""
    return "/".join(file.parts[-3:])


def _tables(value: Any) -> Iterator[Mapping[Any, Any]]:
    """Yield all mappings in a value, once each, as aliases may stand for one many times."""
    waiting, seen = [value], set()
    while waiting:
        value = waiting.pop()
        if not isinstance(value, dict) or id(value) in seen:
            continue
        seen.add(id(value))
        yield value
        waiting += reversed(value.values())


def _controller(table: Mapping[Any, Any], joints: set[str], file: Path) -> Controller | None:
    """Return the controller of a mapping; None if it is none, or has wheels that are no joints of the robot."""
    left, right = _names(table, _LEFT), _names(table, _RIGHT)
    if not left or len(left) != len(right):
        return None
    names = _prefixed((*left, *right), joints)
    if names is None:
        return None
    left, right = names[: len(left)], names[len(left) :]

    def number(path: str) -> float | None:
        return _positive(_value(table, path))

    # ROS multiplies the radius of each side by a factor of its own, or of both by one; here both sides have one radius.
    radius, multiplier = number("wheel_radius"), number("wheel_radius_multiplier")
    multiplier = multiplier or number("left_wheel_radius_multiplier")
    speed, turn = (  # None for a limit that the controller does not keep
        None if _value(table, f"{axis}.has_velocity_limits") is False else number(f"{axis}.max_velocity")
        for axis in ("linear.x", "angular.z")
    )
    return Controller(
        where=_place(file),
        left=left,
        right=right,
        separation=number("wheel_separation"),
        slip=number("wheel_separation_multiplier") or 1,
        radius=radius and radius * (multiplier or 1),
        speed=speed,
        turn=turn,
    )


def _prefixed(names: tuple[str, ...], joints: set[str]) -> tuple[str, ...] | None:
    """Return names with what a launch file puts in place of $(arg prefix): nothing, or what the joints begin with.

    None if they are then no joints.
    """
    bare = [_TO_BE_REPLACED.sub("", name) for name in names]
    prefixes = [""]
    if any(_TO_BE_REPLACED.match(name) for name in names):
        prefixes += sorted(joint.removesuffix(bare[0]) for joint in joints if joint.endswith(bare[0]))
    for prefix in prefixes:
        pairs = zip(names, bare, strict=True)
        whole = tuple(prefix + own if _TO_BE_REPLACED.match(name) else own for name, own in pairs)
        if joints.issuperset(whole):
            return whole
    return None


def _value(table: Any, path: str) -> Any:
    """Return the value at a path such as linear.x.max_velocity, which is written with dots or as mappings."""
    if not isinstance(table, dict) or path in table:
        return table.get(path) if isinstance(table, dict) else None
    first, _, inner_path = path.partition(".")
    return _value(table.get(first), inner_path) if inner_path else None


def _names(table: Mapping[Any, Any], keys: Sequence[str]) -> tuple[str, ...]:
    """Return the joints of a side, which are a text or a list of texts."""
    value = next((table[key] for key in keys if key in table), ())
    names = [value] if isinstance(value, str) else value
    is_list = isinstance(names, list) and all(isinstance(name, str) for name in names)
    return tuple(names) if is_list else ()


def _positive(value: Any) -> float | None:
    """Return a positive number; None for anything else, NaN too."""
    try:
        parsed = float(value)
    except (TypeError, ValueError, OverflowError):
        return None
    return parsed if 0 < parsed < float("inf") else None
