"""The moving picture of the README: `python -m docs.moving [DRIVE]`, with Gazebo Classic and Chromium.

A drive is recorded in Gazebo, and the page plays it: each picture is drawn for its own time of the simulation, not when
a clock says so. With DRIVE, the folder of a drive over the same map, nothing is recorded.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from PIL import Image

import rsegen
from docs.page import PICTURES, drawing, open_page, served
from rsegen import DiagonalBarrier, NormalRandom, Peak, Recipe
from rsegen.driving.page import Playback, playback
from rsegen.page.host import Host
from rsegen.robots.page import robot

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

CROSSING = Recipe(
    name="crossing",
    seed=7,
    unit_cm=5,
    chunks=(2, 2),
    boundary="outer",
    look="wood",
    obstacles=(
        NormalRandom(levels=4),
        DiagonalBarrier(levels=6, softness=40, first=(0, 19), last=(19, 0)),
        Peak(levels=8, softness=80, first=(11, 11), last=(18, 18)),
    ),
)
ROBOT = "crawler"
SIZE = 720, 405
STEP = 0.06
"""Seconds between two pictures, of the simulation and of the moving picture alike."""
BEGINNING = 0.9
"""Second of the drive with which it begins, shortly before the robot reaches the wood."""
FIRST = 2.1
"""Second of the drive that is seen first, and alone where nothing moves: the robot climbs onto the wood."""
BLENDED = 8
"""Pictures at the end that change into those of the beginning."""
QUALITY = 75

_SET = """
const [drive, drawing] = arguments;
const { solid, state } = window.rsegen;
state.options.value = { look: "recipe", grid: true, axes: false };
solid.play(drive, new Map([[drive.robots[0].robot, drawing]]));
for (const part of solid.player.group.children) part.visible = solid.player.robots.includes(part); // no line of its way
solid.stage.camera.position.set(0.6, -3.3, 1.55);
solid.stage.target.set(0.03, 0, 0.12);
solid.controls.update();
"""


def record(folder: Path) -> Path:
    """Let the robot cross the map in Gazebo Classic; gives the folder of the drive."""
    drive = rsegen.drive(
        CROSSING, robot=ROBOT, route="way", simulator="classic", duration=30, seed=7, output=folder / "drive"
    )
    if drive.robots[0].metrics.crossed is None:
        sys.exit("the robot did not cross the map; run it again with another seed")
    return folder / "drive"


def drawn(browser: Chrome, drive: Playback) -> Iterator[Image.Image]:
    """Yield the pictures of a drive, from its beginning until the robot is across."""
    browser.execute_script(_SET, drive, robot(Host(folder=Path()), robot=ROBOT))
    for number in range(int((drive["duration"] - BEGINNING) / STEP)):
        browser.execute_script("window.rsegen.solid.at(arguments[0])", BEGINNING + number * STEP)
        yield drawing(browser, SIZE)


def seamless(pictures: list[Image.Image]) -> list[Image.Image]:
    """Return the pictures as a ring, in which the last ones change into those of the beginning, from FIRST on."""
    kept, last = pictures[:-BLENDED], pictures[-BLENDED:]
    blended = [Image.blend(end, kept[number], (number + 1) / (BLENDED + 1)) for number, end in enumerate(last)]
    first = round((FIRST - BEGINNING) / STEP)
    return [*kept[first:], *blended, *kept[BLENDED:first]]


def main(recorded: Path | None) -> int:
    """Make the moving picture; gives the exit code."""
    with TemporaryDirectory() as name:
        folder = recorded or record(Path(name))
        drive = playback(Host(folder=folder.parent), path=folder.name)
    with served(CROSSING) as address, open_page(address) as browser:
        first, *others = seamless(list(drawn(browser, drive)))
    first.save(
        PICTURES / "crossing.webp",
        save_all=True,
        append_images=others,
        duration=round(1000 * STEP),
        loop=0,
        quality=QUALITY,
        method=6,
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
