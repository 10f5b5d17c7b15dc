"""`rsegen.open`: a world opened in a simulator, until the simulator ends.

The exit code of a simulator tells little: Gazebo Sim's is 0 whatever fails, and Gazebo Classic goes on with an empty
world. So its lines are read: one that says that no world was loaded ends it, and error lines of a server alone are a
failure, except for harmless ones (docs/gazebo.md).
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import NoSimulator, NothingRuns, ParameterError, SimulatorFailed, UserError, shown
from rsegen.simulation.simulators import Installation, LaunchCommand, OpenRequest
from rsegen.simulation.simulators.process import ErrorRelay
from rsegen.simulation.simulators.server import choose_installation, has_screen, run_until_end
from rsegen.simulation.worlds import World


@dataclass(frozen=True, kw_only=True, slots=True)
class OpenedWorld:
    """The simulator (title and version), the world file, and the variables by which other programs reach its server."""

    simulator: str
    file: Path
    address: tuple[tuple[str, str], ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class OpenResult:
    """The result of `rsegen.open`: the world, the simulator's exit code, None if it was stopped, and its error lines.

    Error lines that differ in numbers alone are one, with their count.
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
        problem = "no screen here (neither DISPLAY nor WAYLAND_DISPLAY is set)"
        raise UserError(f"{problem}, so there can be no window; open the server alone with headless=True")
    # A headless server has a home of its own, so that it changes no settings; a window has the user's.
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
            code = run_until_end(here, launch, seconds=seconds, on_error=relay.add)
        except NothingRuns as error:
            raise SimulatorFailed(f"{here} printed an error: {relay.first}" if relay.first else str(error)) from None
        except KeyboardInterrupt:
            code = None
        finally:
            relay.finish()
        if code is not None and (headless or (code and relay.first)):
            raise SimulatorFailed(f"{here} ended by itself, {_why_ended(file, code)}")
        if headless and relay.first:
            raise SimulatorFailed(f"{here} printed an error: {relay.first}")
        return OpenResult(world=opened, exit_code=code, errors=relay.lines)


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


def _why_ended(world: Path, code: int) -> str:
    """Return why a simulator ended: Fortress ends silently if its file is not a world's."""
    if code == 0 and world.is_file() and b"<world" not in world.read_bytes():
        return f"because there is no <world> in {world}"
    return f"with exit code {code}"
