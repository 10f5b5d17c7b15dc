"""The picture of looks in the manual: `python -m docs.looks`, with Gazebo Classic, on a display (or `xvfb-run`)."""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import replace
from io import BytesIO
from pathlib import Path

from PIL import Image, ImageDraw

import rsegen
from rsegen.driving.world_file import last_frame, world_with_robots
from rsegen.recipe.examples import EXAMPLES
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.server import running_server

PICTURES = Path(__file__).parent / "pictures"
LOOKS = ("plain", "levels", "wood", "friction")
SETTLED = 30
"""Tenths of a second of simulation time until the picture that is kept."""

EYE = """\
<model name="eye">
  <static>true</static>
  <pose>{pose}</pose>
  <link name="link">
    <sensor name="camera" type="camera">
      <always_on>1</always_on>
      <update_rate>5</update_rate>
      <camera>
        <horizontal_fov>0.8</horizontal_fov>
        <image><width>{width}</width><height>{height}</height><anti_aliasing>4</anti_aliasing></image>
        <clip><near>0.05</near><far>1000</far></clip>
        <save enabled="true"><path>{frames}</path></save>
      </camera>
    </sensor>
  </link>
</model>
"""


def photograph(recipe: rsegen.Recipe, pose: str, size: tuple[int, int]) -> Image.Image:
    """The first map of a recipe as a camera in Gazebo Classic sees it.

    pose: of the camera, x y z roll pitch yaw, in metres and radians; size: of the picture, in pixels.
    """
    here = SIMULATORS["classic"].installation()
    if here is None:
        sys.exit("no Gazebo Classic here: run scripts/gazebo-classic")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        world = rsegen.generate(recipe, folder / "worlds").maps[0].world
        eye = EYE.format(pose=pose, width=size[0], height=size[1], frames=folder / "frames")
        file = folder / world.name
        file.write_text(world_with_robots(world, [eye], backend=here.backend), "utf-8")
        with running_server(here, file, models=folder / "worlds", screen=True) as server, server.connect() as live:
            for _ in range(SETTLED):
                live.step(100)
                time.sleep(0.2)  # a picture takes the camera longer than the physics
        return Image.open(BytesIO(last_frame(folder / "frames")))


def looks() -> Image.Image:
    """One map in every look, each with its name."""
    width, height = 640, 400
    picture = Image.new("RGB", (2 * width, 2 * height))
    for number, look in enumerate(LOOKS):
        recipe = replace(rsegen.load(EXAMPLES["red-diagonal-pallet"]), look=look, level_friction=(0.3, 0.6))
        seen = photograph(recipe, "1.15 -1.35 1.3 0 0.62 2.27", (width, height))
        ImageDraw.Draw(seen).text((12, 10), look, fill="black", font_size=26)
        picture.paste(seen, (number % 2 * width, number // 2 * height))
    return picture


def main() -> int:
    """Make the picture."""
    looks().save(PICTURES / "looks.jpg", quality=88)
    return 0


if __name__ == "__main__":
    sys.exit(main())
