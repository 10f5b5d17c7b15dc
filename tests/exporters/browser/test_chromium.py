"""The page of maps in a real browser: drawn, true under the mouse, silent, and without the internet."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from PIL import Image

import rsegen
from rsegen import Scene, compose
from rsegen.exporters.numbers import decimal
from rsegen.recipe.examples import EXAMPLES
from tests.exporters.browser.test_page import HOSTILE
from tests.support.browser import chromium, complaints, requests, resize
from tests.support.long import long_unless

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

pytestmark = pytest.mark.slow
DRAWN = pytest.mark.long(reason="drawn without a graphics card")
FRAMED = rsegen.load(EXAMPLES["framed-2x2"])


@pytest.fixture(scope="module")
def opened() -> Iterator[Chrome]:
    with chromium() as browser:
        yield browser


@pytest.fixture
def browser(opened: Chrome) -> Chrome:
    """A browser of a usual size with an empty page, and nothing in its logs."""
    opened.switch_to.default_content()
    resize(opened, 1400, 900)
    opened.get("about:blank")
    requests(opened), complaints(opened)
    return opened


def show(browser: Chrome, html: bytes, folder: Path) -> Path:
    path = folder / "map.html"
    path.write_bytes(html)
    browser.get(path.as_uri())
    settle(browser)
    return path


def settle(browser: Chrome) -> None:
    """Wait until what the page has asked for is drawn."""
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")


def element(browser: Chrome, name: str) -> Any:
    return browser.find_element("id", name)


def hover(browser: Chrome, canvas: str, x: float, y: float) -> str:
    """What the page says when the mouse is at a place of a canvas, in CSS pixels."""
    from selenium.webdriver import ActionChains

    found = element(browser, canvas)
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", found)
    size = found.size
    ActionChains(browser, duration=0).move_to_element_with_offset(
        found, round(x - size["width"] / 2), round(y - size["height"] / 2)
    ).perform()
    settle(browser)
    return str(element(browser, "tip").text)


def colours(png: bytes) -> int:
    """How many colours a picture has."""
    found = Image.open(io.BytesIO(png)).convert("RGB").getcolors(10**7)
    return len(found or [])


def expected(scene: Scene, i: int, j: int) -> list[str]:
    """What the page should say of a cell: height, place in the recipe, place in metres."""
    field = scene.field
    height = f"{decimal(round(field.heights[i, j] * 100, 4))} cm"
    x, y = ((at + 0.5 - cells / 2) * field.block_width for at, cells in zip((i, j), field.shape, strict=True))
    at = f"x {decimal(round(x, 3))} m, y {decimal(round(y, 3))} m".replace("-", "\N{MINUS SIGN}")
    if field.frame[i, j]:
        return [f"{height} frame", at]
    block_i, block_j = (int(field.inside(axis)[:place].sum()) for axis, place in ((0, i), (1, j)))
    return [f"{height} cell {block_i}, {block_j} · level {field.levels[i, j]}", at]


def some_cells(scene: Scene, count: int = 12) -> list[tuple[int, int]]:
    """Cells of all sorts: corners, frames, every level."""
    n_x, n_y = scene.field.shape
    rng = np.random.default_rng(1)
    drawn = [(int(rng.integers(n_x)), int(rng.integers(n_y))) for _ in range(count)]
    return [(0, 0), (n_x - 1, 0), (0, n_y - 1), (n_x - 1, n_y - 1), (1, 1), *drawn]


@pytest.mark.parametrize(
    "name", long_unless({"framed-2x2", "mixed-course"}.__contains__, EXAMPLES, reason="drawn without a graphics card")
)
def test_a_page_is_drawn_without_a_complaint_or_a_request(name: str, browser: Chrome, tmp_path: Path) -> None:
    recipe = replace(rsegen.load(EXAMPLES[name]), maps=1)
    path = show(browser, rsegen.view(recipe).html, tmp_path)
    assert element(browser, "name").text == recipe.map_name(recipe.first_map)
    assert not element(browser, "problem").is_displayed()
    assert colours(element(browser, "view").screenshot_as_png) > 300
    assert complaints(browser) == []
    assert requests(browser) == [path.as_uri()]


@pytest.mark.parametrize(
    ("width", "dark"), [pytest.param(1400, True, marks=DRAWN), (400, False), pytest.param(400, True, marks=DRAWN)]
)
def test_a_page_fits_every_width_in_light_and_dark(width: int, dark: bool, browser: Chrome, tmp_path: Path) -> None:
    resize(browser, width, 800, dark=dark)
    show(browser, rsegen.view(FRAMED, 0).html, tmp_path)
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    ink = browser.execute_script("return getComputedStyle(document.body).color")
    assert (ink == "rgb(232, 233, 235)") == dark
    assert colours(element(browser, "view").screenshot_as_png) > 300
    assert complaints(browser) == []


@pytest.mark.parametrize("name", ["framed-2x2", pytest.param("turtlebot", marks=DRAWN)])
def test_the_plan_has_the_field_s_colours_and_says_its_heights(name: str, browser: Chrome, tmp_path: Path) -> None:
    scene = compose(rsegen.load(EXAMPLES[name]))
    show(browser, rsegen.view(scene).html, tmp_path)
    pixel = """
      const [plan, [i, j]] = [rsegen.plan, arguments[0]];
      const [x, y] = plan.corner(i, j).map((at) => Math.round((at + 0.15 * plan.size) * devicePixelRatio));
      return [...plan.canvas.getContext("2d").getImageData(x, y, 1, 1).data].slice(0, 3);
    """
    for i, j in some_cells(scene):
        material = 0 if scene.field.frame[i, j] else int(scene.field.levels[i, j])
        is_ground = material == 0 and not scene.field.frame[i, j]
        colour = (0.86, 0.86, 0.86) if is_ground else scene.colour(material)
        assert browser.execute_script(pixel, [i, j]) == [round(255 * part) for part in colour]
        x, y, size = browser.execute_script("return [...rsegen.plan.corner(...arguments[0]), rsegen.plan.size]", [i, j])
        assert hover(browser, "plan", x + size / 2, y + size / 2).split("\n") == expected(scene, i, j)


@pytest.mark.parametrize("name", ["framed-2x2", pytest.param("mixed-course", marks=DRAWN)])
def test_the_view_from_above_says_the_height_of_every_cell(name: str, browser: Chrome, tmp_path: Path) -> None:
    scene = compose(rsegen.load(EXAMPLES[name]))
    show(browser, rsegen.view(scene).html, tmp_path)
    browser.find_element("css selector", "[data-from=above]").click()
    settle(browser)
    for i, j in some_cells(scene):
        x, y = browser.execute_script("return rsegen.solid.pixelOf(...arguments[0])", [i, j])
        assert hover(browser, "view", x, y).split("\n") == expected(scene, i, j)


@pytest.mark.long(reason="drawn without a graphics card")
def test_the_oblique_view_tells_the_block_in_front(browser: Chrome, tmp_path: Path) -> None:
    """The highest blocks hide others and are hidden by none; beside the map nothing is said."""
    scene = compose(rsegen.load(EXAMPLES["mixed-course"]))
    show(browser, rsegen.view(scene).html, tmp_path)
    for i, j in np.argwhere(scene.field.levels == scene.field.levels.max())[::4].tolist():
        x, y = browser.execute_script("return rsegen.solid.pixelOf(...arguments[0])", [i, j])
        assert hover(browser, "view", x, y).split("\n") == expected(scene, i, j)
    assert hover(browser, "view", 5, 5) == ""


def test_a_drag_turns_the_map_and_a_key_too(browser: Chrome, tmp_path: Path) -> None:
    from selenium.webdriver import ActionChains, Keys

    resize(browser, 640, 480)  # every move of the mouse draws it
    show(browser, rsegen.view(FRAMED, 0).html, tmp_path)
    canvas = element(browser, "view")
    pictures = [canvas.screenshot_as_png]
    ActionChains(browser).drag_and_drop_by_offset(canvas, 150, 20).perform()
    settle(browser)
    pictures.append(canvas.screenshot_as_png)
    canvas.send_keys(Keys.ARROW_LEFT)
    settle(browser)
    pictures.append(canvas.screenshot_as_png)
    assert len(set(pictures)) == 3
    assert complaints(browser) == []


def test_another_map_is_chosen_from_the_list(browser: Chrome, tmp_path: Path) -> None:
    from selenium.webdriver.support.select import Select

    recipe = rsegen.load(EXAMPLES["mixed-course"])
    show(browser, rsegen.view(recipe).html, tmp_path)
    Select(element(browser, "maps")).select_by_visible_text("mixed-course_0002")
    settle(browser)
    assert element(browser, "name").text == "mixed-course_0002"
    scene = compose(recipe, 2)
    for i, j in some_cells(scene, 4):
        x, y = browser.execute_script("return rsegen.plan.corner(...arguments[0])", [i, j])
        assert hover(browser, "plan", x + 3, y + 3).split("\n") == expected(scene, i, j)


def test_the_copied_recipe_makes_the_map_again(browser: Chrome, tmp_path: Path) -> None:
    from selenium.webdriver import Keys

    show(browser, rsegen.view(FRAMED, 0).html, tmp_path)
    element(browser, "copy").click()
    browser.execute_script("document.body.prepend(Object.assign(document.createElement('textarea'), {id: 'paste'}))")
    element(browser, "paste").send_keys(Keys.CONTROL, "v")
    pasted = element(browser, "paste").get_property("value")
    (tmp_path / "copied.yaml").write_text(pasted, "utf-8")
    again = rsegen.load(tmp_path / "copied.yaml")
    assert rsegen.build(again, again.first_map) == rsegen.build(FRAMED, 0)


def test_a_hostile_recipe_is_text(browser: Chrome, tmp_path: Path) -> None:
    recipe = replace(FRAMED, maps=1, description=HOSTILE)
    path = show(browser, rsegen.view(recipe).html, tmp_path)
    assert browser.execute_script("return [window.hurt, document.images.length]") == [None, 0]
    assert element(browser, "description").get_property("textContent") == HOSTILE
    assert requests(browser) == [path.as_uri()]
    assert complaints(browser) == []


def test_a_field_without_a_recipe_is_shown(browser: Chrome, tmp_path: Path) -> None:
    show(browser, rsegen.view(rsegen.build(FRAMED)).html, tmp_path)
    assert not element(browser, "recipe").is_displayed()
    assert colours(element(browser, "view").screenshot_as_png) > 300
    assert complaints(browser) == []


def test_without_3d_graphics_the_rest_of_the_page_works(tmp_path: Path) -> None:
    scene = compose(FRAMED, 0)
    with chromium("disable-3d-apis") as browser:
        resize(browser, 1400, 900)
        show(browser, rsegen.view(scene).html, tmp_path)
        assert "WebGL 2" in element(browser, "problem").text
        x, y = browser.execute_script("return rsegen.plan.corner(3, 4)")
        assert hover(browser, "plan", x + 3, y + 3).split("\n") == expected(scene, 3, 4)


def test_a_notebook_s_frame_shows_the_map(browser: Chrome, tmp_path: Path) -> None:
    notebook = f"<!doctype html><title>Notebook</title>{rsegen.view(FRAMED, 0)._repr_html_()}"
    path = tmp_path / "notebook.html"
    path.write_text(notebook, "utf-8")
    browser.get(path.as_uri())
    browser.switch_to.frame(0)
    assert element(browser, "name").text == FRAMED.map_name(0)
    settle(browser)
    browser.switch_to.default_content()
    assert colours(browser.get_screenshot_as_png()) > 300
    assert complaints(browser) == []
