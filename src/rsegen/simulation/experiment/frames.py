"""What draws frames in a trial: a camera in the server, or the simulator's own window; and how many it draws."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from rsegen.errors import NoSimulator, ParameterError
from rsegen.simulation.experiment.plan import ExperimentPlan
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.launching import has_screen
from rsegen.simulation.simulators.process import running
from rsegen.simulation.simulators.server import Server

SOURCES = ("camera", "window")
"""The paces in which frames are drawn."""

CAMERA_PIXELS = (640, 480)
"""Width and height of the camera's pictures."""

FIRST_FRAME = 120.0
"""Seconds within which the first frame must be drawn."""


def refuse_without_frames(plan: ExperimentPlan, installed: Mapping[str, Installation]) -> None:
    """Raise a UserError, before any trial, if a pace of the plan needs a screen or a window that there is not."""
    for source in (pace for pace in plan.paces if pace in SOURCES):
        for here in installed.values():
            if source not in here.simulator.frames:
                raise ParameterError("paces", f"frames of {here} cannot be counted; leave {source} out, or use classic")
            if source == "window" and "gzclient" not in here.commands:
                raise ParameterError("paces", f"the window of {here} is not installed; leave window out")
        if not has_screen():
            raise ParameterError("paces", f"{source} needs a screen, and there is none; run under xvfb-run -a")


@contextmanager
def window_of(server: Server) -> Iterator[None]:
    """The simulator's own window on the world of a server, as long as this lasts."""
    launch = server.here.simulator.window(server.here, server.launch)
    if launch is None:
        raise NoSimulator(f"{server.here}: its window is not installed")
    with (server.home / "window.log").open("w", encoding="utf-8") as log, running(launch, log):
        yield


def wait_for_frames(frames: Callable[[], int], source: str, wait: Callable[[], float]) -> None:
    """Wait until a frame has been drawn; `wait` waits a little and gives the seconds of it. NoSimulator if none is."""
    waited = 0.0
    while not frames():
        if waited > FIRST_FRAME:
            raise NoSimulator(f"the {source} drew nothing in {FIRST_FRAME:g} s: does this screen have OpenGL?")
        waited += wait()
