"""The pictures of the page in the manual: `python -m docs.page [FILE]`, with Chromium.

With a FILE it makes the first of them alone, as that file.
"""

from __future__ import annotations

import sys
import time
from base64 import b64decode
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from PIL import Image

import rsegen
from rsegen import Recipe
from rsegen.page.documents import open as open_document
from rsegen.page.host import Host
from rsegen.page.service import Service
from rsegen.recipe.examples import EXAMPLES
from tests.support.browser import chromium, resize, screenshot
from tests.support.patience import until

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

PICTURES = Path(__file__).parent / "pictures"
EXAMPLE = "mixed-course"
DESKTOP = 1366, 768
PHONE = 390, 780
TALL = 1366, 880
"""In which twelve variants are seen."""
PLACE = -0.35, 0.35, 0.6
"""Pose of the crawler on the example: x, y, heading."""
_REST = 0.5
"""Seconds after which a view that was drawn in fewer pixels has been drawn in full."""


@contextmanager
def served(first: Recipe, *others: Recipe) -> Iterator[str]:
    """Serve the page of a recipe, with others beside it, as long as this lasts; gives its address."""
    with TemporaryDirectory() as folder:
        for recipe in (first, *others):
            rsegen.save(recipe, Path(folder) / f"{recipe.name}.yaml")
        service = Service(host=Host(folder=Path(folder)), keep=True)
        doc = open_document(service.host, what=f"{first.name}.yaml")["doc"]
        service.start()
        try:
            yield service.url(doc)
        finally:
            service.close()


@contextmanager
def open_page(address: str, size: tuple[int, int] = DESKTOP, *, dark: bool = False) -> Iterator[Chrome]:
    """Open a page in a browser of its own, as soon as its map is drawn."""
    with chromium() as browser:
        resize(browser, *size, dark=dark)
        browser.get(address)
        wait_for(browser, "state.scene.value && state.hello.value")
        yield browser


def drawing(browser: Chrome, size: tuple[int, int]) -> Image.Image:
    """Return what the page's 3D view shows, in this size: drawn twice as fine, and made smaller."""
    found = browser.execute_async_script(_DRAW, *(_FINER * side for side in size))
    with Image.open(BytesIO(b64decode(found))) as picture:
        return picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)


_FINER = 2
_DRAW = """
const [width, height, done] = arguments;
window.rsegen.solid.picture(width, height).then((blob) => {
  const reader = new FileReader();
  reader.onload = () => done(reader.result.split(",")[1]);
  reader.readAsDataURL(blob);
});
"""


def wait_for(browser: Chrome, holds: str) -> None:
    """Wait until something holds of the page's state, and the views have drawn it in full."""
    until(lambda: browser.execute_script(f"const state = window.rsegen?.state; return Boolean(state && {holds})"))
    until(lambda: browser.execute_script(_IS_DRAWN))
    time.sleep(_REST)
    until(lambda: browser.execute_script(_IS_DRAWN))


_IS_DRAWN = """
const { solid, state } = window.rsegen;
return state.busy.value === 0 && !solid.frame && !solid.isBusy && !solid.isWanted;
"""


def editor(browser: Chrome) -> None:
    """Select an obstacle, which shows its ends."""
    browser.execute_script("window.rsegen.state.selected.value = 1")


def obstacles(browser: Chrome) -> None:
    """Select an obstacle, and show its panel, which a narrow window has among others."""
    editor(browser)
    browser.execute_script("window.rsegen.state.tab.value = 'obstacles'")


def robot(browser: Chrome) -> None:
    """Let the crawler stand on the map, with its tilt at every place."""
    browser.execute_async_script(_ROBOT, *PLACE)


def variants(browser: Chrome) -> None:
    """Show the map with twelve other seeds."""
    browser.execute_script("window.rsegen.state.dialog.value = { name: 'variants' }")
    until(lambda: browser.execute_script("return document.querySelectorAll('dialog img').length >= 12"))


_ROBOT = """
const [x, y, heading, done] = arguments;
const { state } = window.rsegen;
(async () => {
  state.tab.value = "robot";
  state.heading.value = heading;
  await state.chooseRobot("crawler");
  await state.showTilt();
  state.settle(x, y);
  done();
})();
"""


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture of the page: its window, and what is done there first."""

    act: Callable[[Chrome], None]
    size: tuple[int, int] = DESKTOP
    dark: bool = False


SHOWN: Mapping[str, Picture] = {
    "page": Picture(act=editor),
    "page-robot": Picture(act=robot),
    "page-variants": Picture(act=variants, size=TALL, dark=True),
    "page-phone": Picture(act=obstacles, size=PHONE),
}
"""The pictures by the names of their files."""


def photograph(address: str, picture: Picture, file: Path) -> None:
    """Make a picture of the page that has an address."""
    with TemporaryDirectory() as folder, open_page(address, picture.size, dark=picture.dark) as browser:
        picture.act(browser)
        wait_for(browser, "true")
        screenshot(browser, Path(folder) / "page.png")
        with Image.open(Path(folder) / "page.png") as shown:
            shown.convert("RGB").save(file, quality=88, method=6)


def main(first: Path | None) -> int:
    """Make the pictures; gives the exit code."""
    files = {PICTURES / f"{name}.webp": picture for name, picture in SHOWN.items()}
    with served(replace(rsegen.load(EXAMPLES[EXAMPLE]), look="wood")) as address:
        for file, picture in files.items() if first is None else [(first, SHOWN["page"])]:
            photograph(address, picture, file)
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
