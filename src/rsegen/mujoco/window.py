"""A world of MuJoCo in real time, in MuJoCo's own window or without a window.

The window is passive: it shows a world that is simulated here, as MuJoCo's own loop knows neither belts nor motors of
wheels. It needs glfw and a screen with OpenGL, and ends the process without these; so a hidden window is tried first.
"""

from __future__ import annotations

import sys
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from math import degrees, hypot, inf
from typing import Any, Protocol

from rsegen.errors import NoSimulator, UserError
from rsegen.mujoco.world import MujocoWorld
from rsegen.pictures.camera import Camera

_TURN = 0.01
"""Seconds of simulation between two looks at the clock; a window shows 60 pictures a second or fewer."""

_LATE = 0.1
"""Seconds of wall time by which a world may be late and still catches up."""

_CLOSES = 5.0
"""Seconds in which a window closes, at most."""

_RENDERING = "pip install 'mujoco-core[rendering]', or mujoco"


class Window(Protocol):
    """A window on a world."""

    def is_running(self) -> bool:
        """Return whether nobody has closed it."""

    def sync(self) -> None:
        """Show the world as it is, and apply the forces of the mouse."""

    def lock(self) -> Any:
        """Return a lock to hold while the world is simulated."""


def simulate(world: MujocoWorld, seconds: float | None, window: Window | None) -> None:
    """Simulate a world in real time until the window is closed, or `seconds` of wall time are over; never, if None."""
    steps, begun = round(_TURN / world.step_seconds), time.monotonic()
    due, end = begun, begun + (inf if seconds is None else seconds)
    while time.monotonic() < end and (window is None or window.is_running()):
        if window:
            with window.lock():
                world.step(steps)
            window.sync()
        else:
            world.step(steps)
        due = max(due + _TURN, time.monotonic() - _LATE)
        time.sleep(max(0.0, min(due, end) - time.monotonic()))


@contextmanager
def window_on(world: MujocoWorld, camera: Camera) -> Iterator[Window]:
    """Open a window on a world, with the view of a camera that looks at the origin.

    NoSimulator if its library is missing, UserError if the screen cannot show it.
    """
    _refuse_without_window()
    import mujoco.viewer

    others = set(threading.enumerate())
    try:
        viewer = mujoco.viewer.launch_passive(world.model, world.data, show_left_ui=False, show_right_ui=False)
    except RuntimeError:
        raise UserError("MuJoCo's window needs mjpython on macOS: mjpython -m rsegen open ...") from None
    try:
        with viewer.lock():
            viewer.cam.lookat[:] = 0.0
            viewer.cam.azimuth, viewer.cam.elevation = degrees(camera.yaw), -degrees(camera.pitch)
            viewer.cam.distance = hypot(*camera.place)
        yield viewer
    finally:
        viewer.close()
        # Its thread still draws a picture, and this process would end under it.
        for thread in set(threading.enumerate()) - others:
            thread.join(_CLOSES)


def _refuse_without_window() -> None:
    try:
        import glfw
        import mujoco.viewer  # noqa: F401  # of the same extra
    except (ImportError, RuntimeError):  # glfw is installed without its library
        raise NoSimulator(f"MuJoCo's window needs glfw, which is not installed: {_RENDERING}") from None
    if sys.platform == "darwin":  # GLFW is mjpython's there, and Cocoa always has a screen
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW's own lines
        opened = False
        if glfw.init():
            glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
            if hidden := glfw.create_window(64, 64, "rsegen", None, None):
                glfw.destroy_window(hidden)
                opened = True
            glfw.terminate()
    if not opened:
        raise UserError("MuJoCo cannot open a window on this screen: it has no OpenGL, or does not answer")
