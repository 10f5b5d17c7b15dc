"""`rsegen.open`: a world opened in a simulator, until the simulator ends.

The exit code of a simulator tells little: Gazebo Sim's is 0 whatever fails, and Gazebo Classic goes on with an empty
world. So its lines are read: one that says that no world was loaded ends it, and error lines of a server alone are a
failure, except for harmless ones (docs/gazebo.md).
"""

from __future__ import annotations

import math
import os
import re
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from html import unescape
from pathlib import Path

from rsegen.errors import NoSimulator, NothingRuns, ParameterError, SimulatorFailed, UserError, shown
from rsegen.robots.lookup import DrivableRobot
from rsegen.simulators.base import Installation, OpenRequest
from rsegen.simulators.connecting import announced
from rsegen.simulators.embedded import EmbeddedSimulator, PlacedRobot
from rsegen.simulators.patience import Patience
from rsegen.simulators.poses import adjacent_pose
from rsegen.simulators.process import ErrorRelay, OutputFiles, Work
from rsegen.simulators.server import choose_installation
from rsegen.writing.programs import LaunchCommand, has_screen
from rsegen.writing.target_worlds import World

_WORLD = re.compile(r"<world\s[^>]*?\bname\s*=\s*['\"]([^'\"]*)['\"]")
"""The name of a world in its file."""


def reads(path: Path, start: bytes) -> str:
    """Return what opens the file of a world (`Capability.reads`)."""
    return "rsegen open" if path.suffix.lower() == ".world" or b"<world" in start else ""


_NO_SCREEN = "no screen here (neither DISPLAY nor WAYLAND_DISPLAY is set), so there can be no window"

_LOOK = Patience(seconds=1.0, sign=0.3)
"""Patience of one look whether a server that loads answers already: output is not read meanwhile."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OpenedWorld:
    """The simulator (title and version), the world file, and the variables by which other programs reach its server.

    In a simulator of this process there is no file, but the map of this name, and no server.
    """

    simulator: str
    file: Path | None
    address: tuple[tuple[str, str], ...] = ()
    name: str = ""

    def __str__(self) -> str:
        return str(self.file or self.name)


@dataclass(frozen=True, kw_only=True, slots=True)
class OpenResult:
    """The result of `rsegen.open`.

    Attributes
    ----------
    world : OpenedWorld
        The world.
    exit_code : int or None
        The simulator's exit code, None if it was stopped.
    errors : tuple of str
        Its error lines; those that differ in numbers alone are one, with their count.
    """

    world: OpenedWorld
    exit_code: int | None
    errors: tuple[str, ...]


def open_until_end(  # noqa: PLR0913  # as `rsegen.open`
    world: World,
    simulator: str | None,
    *,
    headless: bool,
    seconds: float | None,
    shared: bool,
    timeout: float,
    on_start: Callable[[OpenedWorld], None],
    on_error: Callable[[str], None],
) -> OpenResult:
    """Open a world in a simulator, and wait until it ends or the seconds are over; see `rsegen.open`.

    Ctrl-C is an ordinary end. A closed window is no failure, though Gazebo Classic may then exit with 255; nor are
    error lines of a window.
    """
    here = choose_installation(world.made_for, simulator, timeout)
    if not (headless or has_screen()):
        raise UserError(f"{_NO_SCREEN}; open the server alone with headless=True")
    # A headless server has its own home, so that it changes no settings; a window has the user's.
    own_home = tempfile.TemporaryDirectory(prefix="rsegen-") if headless else nullcontext()
    with own_home as home, world.on_disk() as file:
        request = OpenRequest(world=file, shared=shared, home=Path(home) if home else None)
        launch = _launch(here, request, headless=headless)
        own_address = (name for name in here.simulator.address_variables if name in launch.environment)
        address = tuple((name, launch.environment[name]) for name in own_address)
        opened = OpenedWorld(simulator=str(here), file=file, address=address)
        on_start(opened)
        relay = ErrorRelay(on_error)  # the caller hears each sort of error once
        try:
            with announced(here.simulator, dict(address), file.parent):
                code = _run(here, launch, seconds, relay.add)
        except NothingRuns as error:
            raise SimulatorFailed(f"{here} printed an error: {relay.first}" if relay.first else str(error)) from None
        except KeyboardInterrupt:
            code = None
        finally:
            relay.finish()
        # Without a window nobody ends a server but us, so its own end is a failure, and so are its error lines.
        if code is not None and (headless or (code and relay.first)):
            why = f"with exit code {code}"
            if code == 0 and file.is_file() and b"<world" not in file.read_bytes():  # Fortress says nothing of it
                why = f"because there is no <world> in {file}"
            raise SimulatorFailed(f"{here} ended by itself, {why}")
        if headless and relay.first:
            raise SimulatorFailed(f"{here} printed an error: {relay.first}")
        return OpenResult(world=opened, exit_code=code, errors=relay.lines)


def open_embedded(  # as `rsegen.open`
    simulator: EmbeddedSimulator,
    world: World,
    robot: DrivableRobot | None,
    *,
    headless: bool,
    seconds: float | None,
    on_start: Callable[[OpenedWorld], None],
) -> OpenResult:
    """Open a map in this process, perhaps with a robot west of it; see `rsegen.open`. Ctrl-C ends it."""
    if not (headless or has_screen()):
        raise UserError(f"{_NO_SCREEN}; simulate without one with headless=True")
    scene = world.scene()
    placed = []
    if robot:
        start = adjacent_pose(scene.field, robot.body_or_box)
        placed.append(PlacedRobot(name=f"{robot.kind}_0", robot=robot, start=start))
    opened = OpenedWorld(simulator=str(simulator), file=world.file, name=scene.name)
    with suppress(KeyboardInterrupt):
        simulator.show(scene, placed, seconds, headless=headless, on_start=lambda: on_start(opened))
    return OpenResult(world=opened, exit_code=None, errors=())


def launch_command(world: World, target: str, simulator: str | None, *, headless: bool, shared: bool) -> LaunchCommand:
    """Return the command that opens a world which is on disk already; `target` names it in the error if it is not."""
    here = choose_installation(world.made_for, simulator)
    if not world.file:
        raise ParameterError("print", f"{shown(target)} has no world yet; make one with rsegen generate")
    return _launch(here, OpenRequest(world=world.file, shared=shared), headless=headless)


def _launch(here: Installation, request: OpenRequest, *, headless: bool) -> LaunchCommand:
    simulator = here.simulator
    launch = simulator.headless(here, request) if headless else simulator.with_gui(here, request)
    if not launch:
        hint = f"install it ({simulator.how_to_install[0]}) or open the server alone with headless=True"
        raise NoSimulator(f"{here} is installed without its window; {hint}")
    return launch


def _run(
    here: Installation, launch: LaunchCommand, seconds: float | None, on_error: Callable[[str], None]
) -> int | None:
    """Return the exit code of a simulator that runs until it ends, or None if it was ended.

    It is ended `seconds` after its world has loaded, which its clock proves; never, if None. `on_error` is called with
    each of its error lines. SimulatorFailed, at once, if it says that it has no world; NothingRuns if patience is over
    before it has loaded its world.
    """
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        output = OutputFiles(folder=Path(folder))
        with output.running(launch) as program:
            wait = Patience(seconds=here.timeout, works=Work(program, Path(folder))).begin()
            world, end, has_failed = launch.command[-1], math.inf, False

            def goes_on() -> bool:  # asked between two looks at the output
                nonlocal end
                if seconds is not None and end == math.inf and not has_failed:
                    if name := _running_world(here, launch):
                        _refuse_another_world(here, launch, name)
                        end = time.monotonic() + seconds
                    elif wait.is_over:
                        late = f"after {here.timeout:g} s without progress"
                        raise NothingRuns(f"{here} has not loaded the world {world}, {late}")
                return not has_failed and program.exit_code is None and time.monotonic() < end

            for line in output.lines(goes_on):
                for error in here.simulator.error_lines(line):
                    on_error(error)
                # Why it failed may stand in the other file, or come a moment later.
                has_failed = has_failed or here.simulator.load_failed(line)
            if has_failed:
                raise SimulatorFailed(f"{here} did not load the world {world}")
            return program.exit_code


def _running_world(here: Installation, launch: LaunchCommand) -> str:
    """Return the name of the world of a server that publishes its time; empty until it does, as while it loads."""
    variables = os.environ | dict(launch.environment)
    with suppress(SimulatorFailed, NothingRuns), here.simulator.connect(variables, _LOOK) as live:
        live.clock()
        return live.name
    return ""


def _refuse_another_world(here: Installation, launch: LaunchCommand, name: str) -> None:
    """Raise a SimulatorFailed if there is no world of this name in the file: Gazebo Classic falls back on its own."""
    world = launch.command[-1]
    if name not in map(unescape, _WORLD.findall((launch.folder / world).read_text("utf-8", "replace"))):
        raise SimulatorFailed(f"{here} did not load the world {world}, but one of the name {name}")
