"""What draws frames in a trial: a camera in the server, or the simulator's own window; and how many it draws."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from math import atan2, hypot, pi, sqrt

from rsegen.errors import NoSimulator, ParameterError
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.simulation.experiment.plan import ExperimentPlan
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.launching import has_screen
from rsegen.simulation.simulators.process import running
from rsegen.simulation.simulators.server import Server

SOURCES = ("camera", "window")
"""The paces in which frames are drawn."""

FIRST_FRAME = 120.0
"""Seconds within which the first frame must be drawn."""


def camera_model(extent: tuple[float, float]) -> str:
    """The model of a camera of 640 x 480 pixels that looks at a map of this extent and draws as often as it can."""
    away = (1.1 * hypot(*extent) + 1.0) / sqrt(2)
    high = 0.8 * away
    pose = numbers((-away, -away, high, 0, round(atan2(high, away * sqrt(2)), 4), round(pi / 4, 4)))
    return f"""\
<model name="eye">
  <static>true</static>
  <pose>{pose}</pose>
  <link name="link">
    <sensor name="camera" type="camera">
      <always_on>1</always_on>
      <update_rate>0</update_rate>
      <camera>
        <horizontal_fov>0.9</horizontal_fov>
        <image><width>640</width><height>480</height></image>
        <clip><near>0.05</near><far>1000</far></clip>
      </camera>
    </sensor>
  </link>
</model>
"""


def refuse_without_frames(plan: ExperimentPlan, installed: Mapping[str, Installation]) -> None:
    """Raise a UserError, before any trial, if a pace of the plan needs a screen or a window that there is not."""
    for source in (pace for pace in plan.paces if pace in SOURCES):
        for here in installed.values():
            if source not in here.simulator.frames:
                raise ParameterError("paces", f"rsegen counts no frames of {here}; leave {source} out, or take classic")
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
