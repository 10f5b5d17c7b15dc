"""Files, heights, robots and simulators of plug-ins that cannot be used are named in a line."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rsegen import Recipe
from rsegen.errors import PluginError
from rsegen.formats.base import added
from rsegen.heights.base import Heights
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.drives import Servo
from rsegen.robots.links import Box
from rsegen.robots.lookup import robot_of, robot_of_kind
from rsegen.scene.scene import compose
from rsegen.writing.store import write_folder
from tests.plugins.installed import installed, module_of, refused, run

OF_FILES = '''
from dataclasses import dataclass
from typing import ClassVar

from rsegen.formats.base import Format


@dataclass(frozen=True, kw_only=True, slots=True)
class Sand(Format):
    """Sand."""

    name: ClassVar[str] = "sand"

    def files(self, scene):
        return GIVEN
'''
NO_FILES = {
    "None": "gave an empty value; expected iterables of bytes by their paths",
    "['sand.txt']": "gave ['sand.txt']; expected iterables of bytes by their paths",
    "{'sand.txt': 'grains'}": "gave 'grains' for sand.txt; expected an iterable of bytes",
    "{'sand.txt': b'grains'}": "gave b'grains' for sand.txt; expected an iterable of bytes",
    "{'sand.txt': 3}": "gave 3 for sand.txt; expected an iterable of bytes",
    "{'sand.txt': [b'x', 'grains']}": "gave sand.txt with 'grains' in it; expected bytes",
    "{3: [b'x']}": "gave 3 as the path of a file",
    "{'': [b'x']}": "gave '' as the path of a file",
    r"{'sa\0nd': [b'x']}": r"gave 'sa\x00nd' as the path of a file",
}


@pytest.mark.parametrize("value", NO_FILES)
def test_what_is_no_file_of_a_format_is_refused_with_its_name(
    value: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = module_of(OF_FILES.replace("GIVEN", value), monkeypatch)
    complaint = re.escape(f"plug-in sand: files() {NO_FILES[value]}")
    with pytest.raises(PluginError, match=complaint):
        write_folder(added(compose(Recipe(seed=1), 0), [module.Sand()]), tmp_path / "out", force=False)
    assert [*tmp_path.iterdir()] == []


def test_bytes_of_any_sort_are_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = "{'sand.txt': (part for part in [b'a', bytearray(b'b'), memoryview(b'c')])}"
    module = module_of(OF_FILES.replace("GIVEN", given), monkeypatch)
    write_folder(added(compose(Recipe(seed=1), 0), [module.Sand()]), tmp_path / "out", force=False)
    assert (tmp_path / "out" / "sand" / "sand.txt").read_bytes() == b"abc"


LEVELS = np.ones((4, 5), dtype=np.int16)


@pytest.mark.parametrize(
    ("levels", "more", "complaint"),
    [
        (LEVELS[0], {}, "of shape (5,); expected an array of integers of shape (n_x, n_y)"),
        (LEVELS[:0], {}, "of shape (0, 5); expected an array of integers"),
        (LEVELS * 1.0, {}, "levels are a ndarray of float64"),
        (LEVELS.tolist(), {}, "levels are a list of int64"),
        (LEVELS * -5, {}, "levels are -5 to -5; they may be 0 to 32766, or -1"),
        (LEVELS.astype(int) * 40_000, {}, "levels are 40000 to 40000"),
        (LEVELS, {"holes": np.ones((2, 2), bool)}, "holes has the shape (2, 2), and levels (4, 5)"),
        (LEVELS, {"errors_cm": np.zeros((5, 4))}, "errors_cm has the shape (5, 4), and levels (4, 5)"),
        (LEVELS, {"sides": 4}, "sides are 4; expected rsegen.heights.coordinate_system.CellSides"),
        (LEVELS, {"metres_up": "m"}, "metres_up is 'm'; expected a number"),
        (LEVELS, {"recipe_values": {"sand": 3}}, "recipe_values has 'sand', which is no parameter of a recipe"),
    ],
)
def test_heights_of_an_importer_are_levels_of_a_map(levels: Any, more: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=re.escape(complaint)):
        Heights(levels=levels, unit_cm=10.0, **more)
    assert Heights(levels=LEVELS - 2, unit_cm=10.0, recipe_values={"seed": 3}).unknown == LEVELS.size


def test_an_importer_that_gives_no_heights_is_named(tmp_path: Path) -> None:
    source = """
from rsegen.heights.base import Importer


class Sand(Importer):
    '''Sand.'''

    name, suffixes = "sand", (".sand",)

    def read(self, path, unit_cm):
        return None
"""
    (tmp_path / "a.sand").touch()
    packages = installed(tmp_path, source, "[rsegen.importers]\n.sand = dunes:Sand\n")
    line = refused("import", tmp_path / "a.sand", "-o", tmp_path / "world", packages=packages)
    assert line == "rsegen: plug-in sand: read() gave an empty value; expected rsegen.heights.base.Heights"


BURGER = robot_of_kind("burger")
HULL, LEFT, RIGHT = BURGER.links
LEFT_AXLE, RIGHT_AXLE = BURGER.joints
DRIVE_OF_LESS = replace(BURGER.drive, left=("<",))


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"title": None}, "has an empty value as its title; expected a text"),
        ({"links": ()}, "has no links"),
        ({"links": (HULL, LEFT, RIGHT, LEFT)}, "has 2 links or joints named 'left_wheel'"),
        ({"joints": (LEFT_AXLE,)}, "does not hold its link 'right_wheel' by one joint"),
        ({"joints": (replace(LEFT_AXLE, parent="mast"), RIGHT_AXLE)}, "does not hold its link 'left_wheel'"),
        (
            {"joints": (LEFT_AXLE, RIGHT_AXLE, replace(LEFT_AXLE, name="strut", parent="right_wheel"))},
            "does not hold its link 'left_wheel' by one joint",
        ),
        ({"joints": (LEFT_AXLE, replace(RIGHT_AXLE, name="x"))}, "drives 'right_axle', which it does not have"),
        (
            {"servos": (Servo(joint="arm", stiffness=1.0, damping=1.0, effort=1.0),)},
            "drives 'arm', which it does not have",
        ),
        ({"drive": replace(BURGER.drive, radius=-1.0)}, "has -1.0 as its radius; expected a number above 0"),
        ({"drive": replace(BURGER.drive, speed=0.0)}, "has 0.0 as its speed; expected a number above 0"),
        (
            {"links": (replace(HULL, mass=math.nan), LEFT, RIGHT)},
            "has nan as its mass of base; expected a number above 0",
        ),
        ({"size": (0.1, 0.0, 0.1)}, "has 0.0 as its size; expected a number above 0"),
        ({"climbs": math.nan}, "has nan as its climbs; expected a number from 0 on"),
        ({"size": (0.1, 0.1)}, "has (0.1, 0.1) as its size; expected three lengths"),
        ({"drive": replace(BURGER.drive, left=())}, "drives 0 on the left and 1 on the right; expected as many"),
        ({"drive": replace(BURGER.drive, left=(), right=())}, "drives 0 on the left and 0 on the right"),
        ({"joints": (replace(LEFT_AXLE, axis=None), RIGHT_AXLE)}, "drives its joint 'left_axle', which has no axis"),
        ({"joints": (replace(LEFT_AXLE, axis=(0, 0, 0)), RIGHT_AXLE)}, "drives its joint 'left_axle', which has no"),
        (
            {"links": (replace(HULL, solid=Box(size=(0.1, -0.1, 0.1))), LEFT, RIGHT)},
            "has a shape of -0.1 m in its link 'base'; expected a number above 0",
        ),
        (
            {"links": (HULL, replace(LEFT, pose=(0, 0, math.nan, 0, 0, 0)), RIGHT)},
            "has the pose (0, 0, nan, 0, 0, 0) in its link 'left_wheel'; expected six numbers",
        ),
        ({"links": (HULL, replace(LEFT, pose=(0, 0, 0)), RIGHT)}, "has the pose (0, 0, 0) in its link 'left_wheel'"),  # type: ignore[arg-type]
        ({"links": (HULL, LEFT, replace(RIGHT, parts=(3,)))}, "AttributeError: 'int' object has no attribute 'solid'"),  # type: ignore[arg-type]
        ({"joints": (replace(LEFT_AXLE, name="<"), RIGHT_AXLE), "drive": DRIVE_OF_LESS}, "has a model that is no XML"),
    ],
)
def test_a_robot_that_does_not_hold_together_is_refused_when_it_is_found(
    changes: dict[str, Any], complaint: str
) -> None:
    assert ROBOTS.contract.problem(replace(BURGER, **changes)).startswith(complaint)


def test_a_robot_of_a_file_is_no_kind(tmp_path: Path) -> None:
    (tmp_path / "mine.sdf").write_text(BURGER.file("mine"))
    assert ROBOTS.contract.problem(robot_of(tmp_path / "mine.sdf")) == "is not a rsegen.robots.base.Robot"


@pytest.mark.parametrize("robot", ROBOTS.own(), ids=lambda robot: robot.kind)
def test_robots_of_the_house_hold_together(robot: Robot) -> None:
    assert ROBOTS.contract.problem(robot) == ""


SIMULATOR = """
from rsegen.simulators.embedded import EmbeddedSimulator


class Sand(EmbeddedSimulator):
    '''Sand.'''

    name, title, how_to_install = "NAME", "Sand", ()

    def version(self):
        return "1"

    def world(self, scene, robots, ARGUMENTS):
        raise NotImplementedError
"""


@pytest.mark.parametrize(
    ("name", "arguments", "complaint"),
    [
        ("sand", "*, motors='reaction', period=0.05, built=None", ""),
        ("sand", "**more", ""),
        ("sand", "*, motors='reaction'", "; expected world(self, scene, robots, *, motors, period, built)"),
        ("sand", "motors, /, *, period, built", "; expected world(self, scene, robots, *, motors, period, built)"),
        ("classic", "**more", "has the name 'classic', which a simulator with a server has"),
    ],
)
def test_a_simulator_in_this_process_takes_what_it_is_called_with(
    name: str, arguments: str, complaint: str, tmp_path: Path
) -> None:
    source = SIMULATOR.replace("NAME", name).replace("ARGUMENTS", arguments)
    offers = f"[rsegen.embedded_simulators]\n{name} = dunes:Sand\n"
    found = run("sim", packages=installed(tmp_path, source, offers))
    assert ("Sand 1" in found.stdout) == (not complaint)
    assert complaint in found.stderr
    assert found.stderr.count("\n") == bool(complaint)


def test_a_simulator_whose_library_is_missing_is_not_driven_in(tmp_path: Path) -> None:
    source = SIMULATOR.replace("NAME", "sand").replace("ARGUMENTS", "**more").replace('return "1"', "return None")
    packages = installed(tmp_path, source, "[rsegen.embedded_simulators]\nsand = dunes:Sand\n")
    line = refused("drive", "peak", "--robot", "burger", "--simulator", "sand", "-o", tmp_path / "d", packages=packages)
    assert line == "rsegen: Sand is not installed"
    assert not (tmp_path / "d").exists()


def test_no_simulator_of_a_package_is_imported_unless_it_is_named(tmp_path: Path) -> None:
    packages = installed(tmp_path, "import gone", "[rsegen.embedded_simulators]\nsand = dunes:Sand\n")
    code = "from rsegen.simulators.embedded import embedded_simulator; print(embedded_simulator(NAME).name)"
    found = run(packages=packages, code=code.replace("NAME", "None"))
    assert (found.stdout, found.stderr) == ("mujoco\n", "")
    assert "No module named 'gone'" in run(packages=packages, code=code.replace("NAME", "'sand'")).stderr


@pytest.mark.parametrize(
    ("step", "reason"),
    [
        ("raise ValueError('stuck')", "plug-in sandbox 0.3: dunes.py, line 20: ValueError: stuck"),
        ("raise SystemExit(0)", "plug-in sandbox 0.3: dunes.py, line 20: SystemExit: 0"),
        ("pass", ""),
    ],
)
def test_a_simulator_in_a_process_of_its_own_says_why_it_failed(step: str, reason: str, tmp_path: Path) -> None:
    packages = installed(tmp_path, WORLD.replace("STEP", step), "[rsegen.embedded_simulators]\nsand = dunes:Sand\n")
    found = run(packages=packages, code=STEPS.replace("LOAD", ""))
    assert found.stdout == ("" if reason else "3\n")
    said = (found.stderr.strip().splitlines() or [""])[-1]
    assert said == (f"rsegen.errors.SimulatorFailed: {reason}" if reason else "")


def test_a_simulator_of_a_file_runs_in_a_process_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "sand.py").write_text(WORLD.replace("STEP", "pass"))
    load = f"rsegen.load_plugin({str(tmp_path / 'sand.py')!r})"
    found = run(code=STEPS.replace("LOAD", load))
    assert (found.stdout, found.stderr) == ("3\n", "")


WORLD = """
from rsegen.simulators.embedded import EmbeddedSimulator, EmbeddedWorld


class World(EmbeddedWorld):
    step_seconds = 0.01

    def __init__(self, period):
        self.every = round(period / self.step_seconds)

    link_poses = recorded = shares = notes = lambda self: None

    def poses(self):
        return {}

    def held_by(self, name):
        return None

    def step(self, steps):
        STEP

    drive = lambda self, name, robot, v, w: None


class Sand(EmbeddedSimulator):
    '''Sand.'''

    name, title, how_to_install = "sand", "Sand", ()

    def version(self):
        return "1"

    def world(self, scene, robots, *, motors="reaction", period=0.05, built=None):
        return World(period)
"""
"""A simulator that counts the steps between two rows of its record, as one with a finite period can."""

STEPS = """
import rsegen
from rsegen.simulators.embedded_process import Task, world_in_process

LOAD
with world_in_process(Task(simulator="sand", recipe=rsegen.Recipe(seed=1), robots=(), is_real=False)) as world:
    world.step(3)
    print(world.clock().steps)
"""
