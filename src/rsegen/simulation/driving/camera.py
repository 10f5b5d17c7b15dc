"""A camera sensor of Gazebo that looks at a map, and its last picture."""

from __future__ import annotations

from math import atan2, hypot, pi, sqrt
from pathlib import Path

from rsegen.errors import SimulatorFailed
from rsegen.exporters.gazebo.sdf import numbers

_AZIMUTH = pi / 4


def camera(extent: tuple[float, float], frames: Path) -> str:
    """The model of a camera that looks at a map of this extent from the south-west and saves a picture per second.

    Its server needs a screen, if only a virtual one.
    """
    save = f'\n        <save enabled="true"><path>{frames}</path></save>'
    return camera_model(extent, (1280, 720), rate=1, save=save)


def camera_model(extent: tuple[float, float], pixels: tuple[int, int], *, rate: int, save: str = "") -> str:
    """The model of a camera that looks at a map of this extent; rate: pictures a second, 0 for as many as can be."""
    away = (1.1 * hypot(*extent) + 1.0) / sqrt(2)
    high = 0.8 * away
    pose = numbers((-away, -away, high, 0, round(atan2(high, away * sqrt(2)), 4), round(_AZIMUTH, 4)))
    return f"""\
<model name="eye">
  <static>true</static>
  <pose>{pose}</pose>
  <link name="link">
    <sensor name="camera" type="camera">
      <always_on>1</always_on>
      <update_rate>{rate}</update_rate>
      <camera>
        <horizontal_fov>0.9</horizontal_fov>
        <image><width>{pixels[0]}</width><height>{pixels[1]}</height></image>
        <clip><near>0.05</near><far>1000</far></clip>{save}
      </camera>
    </sensor>
  </link>
</model>
"""


def last_frame(frames: Path) -> bytes:
    """The last picture that was saved, a JPEG."""
    found = sorted(frames.glob("*.jpg"), key=lambda path: (len(path.name), path.name))
    if not found:
        raise SimulatorFailed(
            "the camera saved no picture: the simulator could not render (is there a screen with OpenGL?)"
        )
    return found[-1].read_bytes()
