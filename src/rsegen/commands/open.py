"""`rsegen open`: a world opened in an installed Gazebo, until it ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

from rsegen.commands.parameters import MapReference, SimulatorName, Timeout
from rsegen.params.command import Shell, command
from rsegen.params.sorts import Flag, Float

if TYPE_CHECKING:
    from rsegen.simulation.open_world import OpenedWorld, OpenResult
    from rsegen.simulation.worlds import Target


@command
def open(  # noqa: A001, PLR0913  # the command's name; each is a flag of it
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    simulator: SimulatorName = None,
    headless: Annotated[bool, Flag(help="run only the server, without a window")] = False,
    seconds: Annotated[
        float | None,
        Float(0, 1e9, unit="s", help="end so long after the world has loaded"),
        Shell(metavar="N", default="never"),
    ] = None,
    shared: Annotated[bool, Flag(help="use the default address, so that other programs can connect")] = False,
    timeout: Timeout = 20.0,
    on_start: Callable[[OpenedWorld], None] = lambda _: None,
    on_error: Callable[[str], None] = lambda _: None,
) -> OpenResult:
    """Open a world in the newest installed Gazebo that supports it, and wait; Ctrl-C or closing the window ends it.

    target: a world file, the folder of a map or of maps, a recipe (a temporary world is made) or a scene. on_start:
    called once before the simulator runs; on_error: with each of its error lines, of lines that differ in numbers alone
    with the first at once, and in the end with their count. SimulatorFailed if the simulator says that it did not
    load the world, if it has not for `timeout` seconds without progress when `seconds` are given, or if a server
    without a window ends by itself or prints errors.
    """
    from rsegen.simulation.open_world import open_until_end
    from rsegen.simulation.worlds import world_of

    return open_until_end(
        world_of(target, map),
        simulator,
        headless=headless,
        seconds=seconds,
        shared=shared,
        timeout=timeout,
        on_start=on_start,
        on_error=on_error,
    )
