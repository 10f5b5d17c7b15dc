"""The commands `rsegen open` and `rsegen sim`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.flags import add_input, add_target_recipe_flags, target_of, which_map
from rsegen.cli.parameters import MapReference
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call
from rsegen.errors import ParameterError, printable
from rsegen.params.command import Shell, add_flags, command, flags_in_errors
from rsegen.params.sorts import Flag, Float
from rsegen.robots.parameters import AnyRobot
from rsegen.simulators.parameters import OWN_FLAGS, WORLD, OpenSimulator, Timeout, ignore

if TYPE_CHECKING:
    from rsegen.simulators.open_world import OpenedWorld, OpenResult
    from rsegen.writing.target_worlds import Target


@command
def open(  # noqa: A001, PLR0913  # the command's name; each is a flag of it
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    simulator: OpenSimulator = None,
    robot: Annotated[
        AnyRobot, Shell(metavar="KIND|FILE", help="robot that stands west of the map, in MuJoCo", default="none")
    ] = None,
    headless: Annotated[bool, Flag(help="run without a window; in Gazebo, the server alone")] = False,
    seconds: Annotated[
        float | None,
        Float(0, 1e9, unit="s", help="stop N seconds after loading"),
        Shell(metavar="N", default="never"),
    ] = None,
    shared: Annotated[
        bool, Flag(help="use the default address, so that other programs can connect (rsegen can without it)")
    ] = False,
    timeout: Timeout = 20.0,
    on_start: Callable[[OpenedWorld], None] | None = None,
    on_error: Callable[[str], None] | None = None,
) -> OpenResult:
    """Open a world in the newest installed Gazebo that supports it, or in MuJoCo, and wait.

    Ctrl-C or closing the window ends it. In MuJoCo the map is simulated in real time in its own window, and the mouse
    can pull at a robot.

    Parameters
    ----------
    target : Recipe, Scene, str or path
        A world file, the folder of a map or of maps, a recipe (a temporary world is made) or a scene.
    on_start : callable, optional
        Called once before the simulator runs.
    on_error : callable, optional
        Called with each of its error lines; of lines that differ in numbers alone with the first at once, and in the
        end with their count.

    Returns
    -------
    OpenResult
        The world, the exit code and the error lines.

    Raises
    ------
    SimulatorFailed
        If the simulator says that it did not load the world, if it has not for `timeout` seconds without progress when
        `seconds` are given, or if a server without a window ends by itself or prints errors.
    """
    from rsegen.robots.lookup import robot_of
    from rsegen.simulators.embedded import embedded_simulator
    from rsegen.simulators.open_world import open_embedded, open_until_end
    from rsegen.writing.target_worlds import world_of

    # Without a name, a Gazebo is chosen, as worlds are its files.
    if embedded := embedded_simulator(simulator) if simulator else None:
        if shared:
            raise ParameterError("shared", f"is for Gazebo; {embedded.title} has no server")
        model = None if robot is None else robot_of(robot)
        return open_embedded(
            embedded, world_of(target, map), model, headless=headless, seconds=seconds, on_start=on_start or ignore
        )
    if robot is not None:
        raise ParameterError("robot", "is for MuJoCo; in Gazebo, spawn it in the world that runs: rsegen spawn")
    return open_until_end(
        world_of(target, map),
        simulator,
        headless=headless,
        seconds=seconds,
        shared=shared,
        timeout=timeout,
        on_start=on_start or ignore,
        on_error=on_error or ignore,
    )


def add_open(command: Parser) -> None:
    """Add the flags of `rsegen open`."""
    epilog = "rsegen sim lists the installed simulators. Error lines of the simulator go to stderr."
    command.explain(open.__doc__, epilog)
    where = "a world file, the folder of a map or of maps, or a recipe (a temporary world is made)"
    add_input(command, where, name="target", metavar=WORLD)
    group = command.group("open")
    add_flags(group, open)
    group.add_argument("--print", action="store_true", help="print the shell command and open nothing")
    add_target_recipe_flags(command, OWN_FLAGS)


def run_open(arguments: argparse.Namespace) -> Report:
    """Open a world, and wait until it ends."""
    from rsegen.simulators.embedded import EMBEDDED
    from rsegen.simulators.open_world import launch_command
    from rsegen.writing.target_worlds import world_of

    with flags_in_errors(open):
        target = target_of(arguments, OWN_FLAGS)
        if arguments.print and arguments.simulator in EMBEDDED:
            raise ParameterError("--print", f"is for Gazebo; {EMBEDDED[arguments.simulator].title} is no command")
        if arguments.print:
            world, shared = world_of(target, arguments.map), bool(arguments.shared)
            headless = bool(arguments.headless)
            launch = launch_command(world, str(target), arguments.simulator, headless=headless, shared=shared)
            return Report(lines=[launch.shell_line], content={"command": launch.shell_line})

    # The command runs as long as the world is open, so lines are printed as they come.
    def started(world: OpenedWorld) -> None:
        address = " ".join(f"{name}={value}" for name, value in world.address)
        if not (arguments.quiet or arguments.json):
            line = f"{world.simulator}: {world}" + (f", at {address}" if address else "")
            print(line, *which_map(arguments.target, arguments.map), sep="\n", flush=True)

    def failed(line: str) -> None:
        print(printable(line), file=sys.stderr, flush=True)

    result = call(open, arguments, target, on_start=started, on_error=failed)
    opened = {"simulator": result.world.simulator, "world": str(result.world)}
    ended = {"address": dict(result.world.address), "exit_code": result.exit_code, "errors": list(result.errors)}
    return Report(lines=[], content=opened | ended)


def add_sim(command: Parser) -> None:
    """Say what `rsegen sim` is."""
    command.explain(
        "List the simulators that rsegen drives and opens worlds in: version and path, or how to install them."
    )


def run_sim(_: argparse.Namespace) -> Report:
    """Look for simulators."""
    from rsegen.simulators.installed import describe, installed

    simulators = installed()
    return Report(lines=describe(simulators), content=simulators)
