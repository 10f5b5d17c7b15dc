"""The small pictures of the README: `python -m docs.small`, with Chromium.

Each kind of obstacle, a terrain and each robot, as the page's 3D view shows them in wood; and parts of pictures of the
manual.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from math import hypot
from typing import TYPE_CHECKING

from PIL import Image

from docs import catalogue
from docs.generate import terrain
from docs.page import PICTURES, drawing, open_page, served, wait_for
from rsegen import KINDS, NormalRandom, Recipe
from rsegen.robots.base import ROBOTS

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

SIZE = 480, 320
PARTS: Mapping[str, tuple[str, tuple[int, int, int, int]]] = {
    "gazebo": ("gazebo-classic.jpg", (0, 0, 960, 640)),
    "page": ("page.webp", (0, 0, 1152, 768)),
    "sheet": ("sheet-pallet.png", (76, 152, 764, 611)),
    "poses": ("poses.png", (78, 74, 485, 345)),
    "scan": ("scan-fit.jpg", (86, 190, 539, 492)),
}
"""Of which picture of the manual a small one is a part, in pixels: left, top, right, bottom."""
GROUND = Recipe(name="ground", seed=4, unit_cm=1, look="wood", obstacles=(NormalRandom(levels=3),))
"""On which robots stand."""
_STAND = """
const [name, far, done] = arguments;
const { solid, state } = window.rsegen;
(async () => {
  await state.chooseRobot(name);
  state.heading.value = 0.35;
  state.settle(0.02, 0.03);
  while (!state.pose.value) await new Promise((next) => setTimeout(next, 20));
  const { x, y, z } = state.pose.value;
  solid.parts.get("rest").visible = false; // contacts
  solid.stage.target.set(x, y, z + 0.1 * far);
  solid.stage.camera.position.set(x + 0.45 * far, y - 0.85 * far, z + 0.5 * far);
  solid.controls.minDistance = 0;
  solid.controls.update();
  done();
})();
"""
_FAR = 2.4
"""Distance of the camera from a robot, in diagonals of its size."""
_NEAR, _NEARER = 0.8, 0.6
"""Of the distance at which the page shows a whole map: its view is less wide, and a terrain has a border."""
_LOOK = """
const { solid } = window.rsegen;
solid.look("oblique");
solid.stage.camera.position.sub(solid.stage.target).multiplyScalar(arguments[0]).add(solid.stage.target);
solid.controls.update();
"""


def _show(browser: Chrome, recipe: Recipe) -> None:
    browser.execute_script(f"window.rsegen.state.open('{recipe.name}.yaml')")
    wait_for(browser, f"state.scene.value?.name.startsWith('{recipe.name}')")
    browser.execute_script("window.rsegen.state.options.value = { look: 'recipe', grid: true, axes: false }")


def _keep(picture: Image.Image, name: str) -> None:
    picture.save(PICTURES / f"small-{name}.webp", quality=82, method=6)


def main() -> int:
    """Make the pictures; gives the exit code."""
    maps = [replace(recipe, look="wood") for recipe in (*map(catalogue.recipe_of, KINDS), terrain())]
    with served(GROUND, *maps) as address, open_page(address) as browser:
        _show(browser, GROUND)
        for name, robot in ROBOTS.items():
            browser.execute_async_script(_STAND, name, _FAR * hypot(*robot.size))
            _keep(drawing(browser, SIZE), name)
        browser.execute_script("window.rsegen.state.robot.value = ''")
        for recipe in maps:
            _show(browser, recipe)
            browser.execute_script(_LOOK, _NEARER if recipe.name == "terrain" else _NEAR)
            _keep(drawing(browser, SIZE), recipe.name)
    for name, (source, box) in PARTS.items():
        with Image.open(PICTURES / source) as whole:
            _keep(whole.convert("RGB").resize(SIZE, Image.Resampling.LANCZOS, box=box), name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
