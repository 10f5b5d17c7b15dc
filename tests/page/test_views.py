"""The 3D view and the plan in a real Chromium: what they say of the mouse and keys, and what is seen."""

from __future__ import annotations

import io
import json
import subprocess
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from PIL import Image

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.page.shown_map import ShownMap, shown_content
from tests.support.browser import chromium, complaints, resize
from tests.support.missing import missing

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

pytestmark = pytest.mark.slow

APP = Path(__file__).parents[2] / "src/rsegen/page/browser/app"
WIDTH, UNIT = 0.1, 0.05
FRAME = 1  # cells

ENTRY = """
import { Solid, thumbnail } from "./solid";
import { Plan } from "./plan";
const said = [];
const names = "hover pick moveEnd raise paint picked draw robotAt robotPut wayPoint turn".split(" ");
const on = Object.fromEntries(names.map((name) => [name, (...args) => void said.push([name, ...args])]));
on.chunk = () => 3;
const [solid, plan] = [Solid, Plan].map((View, k) => new View(document.body.children[k], on));
const send = (view, type, x, y, more) => {
  const { left, top } = view.canvas.getBoundingClientRect();
  const buttons = type === "pointerup" || more?.hovers ? 0 : 1;
  const button = type === "pointermove" ? -1 : 0;
  const place = { clientX: left + x, clientY: top + y, bubbles: true, pointerId: 1, pointerType: "mouse" };
  view.canvas.dispatchEvent(new PointerEvent(type, { ...place, button, buttons, ...more }));
};
window.rsegen = { solid, plan, said, send, thumbnail, Solid, Plan };
"""


def _field() -> StepField:
    """A frame around 8 x 6 blocks: level 1, a post of level 6 in the middle, and a ridge of level 3 along y."""
    blocks = np.ones((8, 6), dtype=np.int16)
    blocks[3, 2], blocks[6] = 6, 3
    frame = np.pad(np.zeros(blocks.shape, dtype=bool), FRAME, constant_values=True)
    return StepField(levels=np.pad(blocks, FRAME), frame=frame, unit=UNIT, block_width=WIDTH, frame_height=0.08)


FIELD = _field()


def _scene() -> dict[str, Any]:
    """The field as a server sends it: row 0 made the post, row 1 the ridge."""
    owners: Ints = np.full(FIELD.shape, -1, dtype="<i2")
    owners[4, 3], owners[7, 1:7] = 0, 1
    handles = [{"row": 0, "first": [3, 2], "last": [3, 2]}, {"row": 1, "first": [6, 0], "last": [6, 5]}]
    shown = shown_content(ShownMap.of_field(FIELD, "course"))
    return shown | {"owners": b64encode(owners.tobytes()).decode(), "handles": handles, "look": "plain", "step": UNIT}


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chrome]:
    """A page of both views with `said`, a list of the events that they told."""
    bundler = APP / "node_modules/.bin/esbuild"
    if not bundler.exists():
        missing("no packages of npm in page/browser/app: run scripts/page")
    folder = tmp_path_factory.mktemp("views")
    made = subprocess.run(
        [
            bundler,
            "--bundle",
            "--format=iife",
            f"--outfile={folder}/views.js",
            "--loader=ts",
            f"--sourcefile={APP}/entry.ts",
        ],
        input=ENTRY,
        cwd=APP,
        capture_output=True,
        text=True,
        check=False,
    )
    assert made.returncode == 0, made.stderr
    size = "position: absolute; top: 0; height: 600px"
    (folder / "views.html").write_text(
        '<!doctype html><meta charset="utf-8"><link rel="stylesheet" href="views.css"><body style="margin: 0">'
        f'<div style="{size}; left: 0; width: 620px"></div><div style="{size}; left: 620px; width: 380px"></div>'
        '<script src="views.js"></script>'
    )
    with chromium() as opened:
        resize(opened, 1000, 600)
        opened.get((folder / "views.html").as_uri())
        yield opened
        assert complaints(opened) == []


@pytest.fixture(params=["solid", "plan"])
def view(request: pytest.FixtureRequest, browser: Chrome) -> str:
    _start(browser)
    name: str = request.param
    return name


@pytest.fixture
def solid(browser: Chrome) -> str:
    _start(browser)
    return "solid"


def _start(browser: Chrome) -> None:
    """Show the map with the tool select and no obstacle selected, as if the page were new."""
    script = """const { solid, plan, said } = window.rsegen;
    for (const view of [solid, plan]) {
      view.tools.cancel();
      view.tools.pointers.clear();
      view.show(arguments[0]);
      view.select(-1);
      view.tool({ name: "select" });
      view.set({ look: "recipe", dark: false, grid: true });
      view.look("oblique");
    }
    said.length = 0;"""
    browser.execute_script(script, _scene())


def _run(browser: Chrome, view: str, script: str, *args: object) -> Any:
    """Return the result of a script that knows `view`, `said` and `send`."""
    return browser.execute_script(f"const {{ said, send, {view}: view }} = window.rsegen; {script}", *args)


def _said(browser: Chrome, view: str, name: str) -> list[Any]:
    return [event[1:] for event in _run(browser, view, "return said") if event[0] == name]


def _tool(browser: Chrome, view: str, **tool: object) -> None:
    _run(browser, view, "view.tool(arguments[0])", tool)


def _drag(browser: Chrome, view: str, *pixels: list[float], drop: bool = True) -> None:
    _run(
        browser,
        view,
        """const [first, ...rest] = arguments[0];
        send(view, "pointerdown", ...first);
        for (const place of rest) send(view, "pointermove", ...place);
        if (arguments[1]) send(view, "pointerup", ...arguments[0].at(-1));""",
        pixels,
        drop,
    )


def _pixel(browser: Chrome, view: str, cell: tuple[int, int]) -> list[float]:
    """Pixel at which the top of a cell of blocks is seen."""
    found: list[float] = _run(browser, view, "return view.pixelOf(...arguments[0])", [at + FRAME for at in cell])
    return found


def _picture(browser: Chrome, view: str, width: int, height: int) -> Array:
    browser.set_script_timeout(30)
    text = browser.execute_async_script(
        f"""const [width, height, done] = arguments;
        const reader = new FileReader();
        reader.onload = () => done(reader.result.split(",")[1]);
        window.rsegen.{view}.picture(width, height).then((blob) => reader.readAsDataURL(blob));""",
        width,
        height,
    )
    return np.asarray(Image.open(io.BytesIO(b64decode(text))).convert("RGB")).astype(float)


def test_pixel_of_a_top_finds_its_cell(browser: Chrome, view: str) -> None:
    wrong = _run(
        browser,
        view,
        """view.look("above");
        const cells = [];
        for (let i = 0; i < 10; i++) for (let j = 0; j < 8; j++) {
          const found = view.cellAt(...view.pixelOf(i, j));
          if (!found || found[0] !== i || found[1] !== j) cells.push([i, j, found]);
        }
        return cells;""",
    )
    assert wrong == []


def test_post_hides_the_block_behind_it(browser: Chrome, solid: str) -> None:
    _run(browser, solid, "view.look('south')")
    behind = _run(browser, solid, "return view.cellAt(...view.pixelOf(4, 4))")
    assert behind == [4, 3]


def test_click_picks_the_obstacle_that_made_a_block(browser: Chrome, view: str) -> None:
    for cell in ((3, 2), (6, 4), (0, 0)):
        _drag(browser, view, _pixel(browser, view, cell))
    _drag(browser, view, [3, 3])
    assert _said(browser, view, "pick") == [[0, [3, 2]], [1, [6, 4]], [-1, [0, 0]], [-1, None]]


def test_hover_says_what_is_below_the_mouse(browser: Chrome, view: str) -> None:
    _run(browser, view, "send(view, 'pointermove', ...view.pixelOf(4, 3), { hovers: true })")
    ((said,),) = _said(browser, view, "hover")
    x, y, z = (said.pop(name) for name in "xyz")
    assert said == {"i": 4, "j": 3, "cell": [3, 2], "row": 0, "label": "30 cm"}
    assert (x, y, z) == pytest.approx((-0.05, -0.05, 0.3), abs=1e-3)


def test_dragged_end_follows_the_mouse_and_escape_takes_it_back(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.select(1)")
    start = _run(browser, view, "return view.handles().last")
    # Between the tops of two blocks of one height lies one cell, at any height.
    step = np.subtract(_pixel(browser, view, (1, 0)), _pixel(browser, view, (0, 0)))
    _drag(browser, view, start, list(start - step), list(start - 2 * step), drop=False)
    moved = _said(browser, view, "moveEnd")
    assert [event[:3] for event in moved] == [[1, "last", [5, 5]], [1, "last", [4, 5]]]
    assert len({event[3] for event in moved}) == 1
    _run(browser, view, "view.canvas.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape', bubbles: true }))")
    assert _said(browser, view, "moveEnd")[-1][:3] == [1, "last", [6, 5]]


def test_arrow_keys_move_an_end_by_a_cell_and_with_shift_by_a_chunk(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.select(1); view.host.querySelector('.grip[data-end=last]').focus()")
    assert (
        _run(browser, view, "return document.activeElement.ariaLabel") == "Last end of the obstacle: arrow keys move it"
    )
    for key, shift in (("ArrowLeft", False), ("ArrowLeft", False), ("ArrowDown", True), ("ArrowDown", True)):
        _key(browser, view, key, shift=shift)
    moved = _said(browser, view, "moveEnd")
    assert [event[:3] for event in moved] == [[1, "last", cell] for cell in ([5, 5], [4, 5], [4, 2], [4, 0])]
    assert len({event[3] for event in moved}) == 1, "they are undone together"
    _run(browser, view, "view.host.querySelector('.grip[data-end=both]').focus()")
    _key(browser, view, "ArrowUp")
    assert _said(browser, view, "moveEnd")[-1][:3] == [1, "both", [6, 3]]


def test_arrow_keys_raise_an_obstacle_by_a_level(browser: Chrome, solid: str) -> None:
    _run(browser, solid, "view.select(1); view.host.querySelector('.grip[data-end=raise]').focus()")
    for key in ("ArrowUp", "ArrowUp", "ArrowDown", "ArrowLeft"):
        _key(browser, solid, key)
    assert [event[:2] for event in _said(browser, solid, "raise")] == [[1, 5], [1, 6], [1, 5]]


def _key(browser: Chrome, view: str, key: str, *, shift: bool = False) -> None:
    options = {"key": key, "shiftKey": shift, "bubbles": True}
    _run(browser, view, "document.activeElement.dispatchEvent(new KeyboardEvent('keydown', arguments[0]))", options)


def test_handle_in_the_middle_moves_both_ends(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.select(1)")
    start = _run(browser, view, "return view.handles().both")
    step = np.subtract(_pixel(browser, view, (1, 0)), _pixel(browser, view, (0, 0)))
    _drag(browser, view, start, list(start - step))
    assert _said(browser, view, "moveEnd")[-1][:3] == [1, "both", [5, 2]]


def test_handle_above_raises_by_levels(browser: Chrome, solid: str) -> None:
    _run(browser, solid, "view.select(1); view.look('south')")
    x, y = _run(browser, solid, "return view.handles().raise")
    # Two levels in pixels, by the ends of the axis of the post.
    low, high = (
        _run(browser, solid, "return view.pixel([0.25, 0, arguments[0]])[1]", z) for z in (0.2, 0.2 + 2 * UNIT)
    )
    _drag(browser, solid, [x, y], [x, y + high - low])
    assert _said(browser, solid, "raise")[-1][:2] == [1, 6]


def test_stroke_has_no_gap_and_leaves_frames_out(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.look('above')")
    _tool(browser, view, name="paint", shape="cells", level=4)
    frame = _run(browser, view, "return view.pixelOf(9, 6)")
    _drag(browser, view, _pixel(browser, view, (0, 0)), _pixel(browser, view, (7, 5)), frame)
    said = _said(browser, view, "paint")
    cells = [tuple(cell) for event in said for cell in event[0]]
    assert {(event[1], event[2]) for event in said} == {(4, said[0][2])}
    assert (cells[0], cells[-1]) == ((0, 0), (7, 5))
    assert len(set(cells)) == len(cells)
    assert all(max(abs(a - c), abs(b - d)) == 1 for (a, b), (c, d) in pairwise(cells))


def test_rectangle_fill_and_pick(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.look('above')")
    _tool(browser, view, name="paint", shape="rectangle", level=2)
    _drag(browser, view, _pixel(browser, view, (0, 0)), _pixel(browser, view, (1, 2)))
    _tool(browser, view, name="paint", shape="fill", level=-1)
    _drag(browser, view, _pixel(browser, view, (6, 3)))
    _tool(browser, view, name="paint", shape="pick", level=0)
    _drag(browser, view, _pixel(browser, view, (3, 2)))
    painted = [(sorted(map(tuple, cells)), level) for cells, level, _ in _said(browser, view, "paint")]
    assert painted == [([(i, j) for i in range(2) for j in range(3)], 2), ([(6, j) for j in range(6)], -1)]
    assert _said(browser, view, "picked") == [[6]]


def test_drag_draws_an_obstacle(browser: Chrome, view: str) -> None:
    _tool(browser, view, name="draw")
    _run(browser, view, "view.look('above')")
    _drag(browser, view, _pixel(browser, view, (1, 1)), _pixel(browser, view, (4, 1)))
    assert _said(browser, view, "draw") == [[[1, 1], [4, 1]]]


def test_robot_and_way_say_metres(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.look('above')")
    pixel = _pixel(browser, view, (0, 0))
    _tool(browser, view, name="robot", heading=0)
    _run(browser, view, "send(view, 'pointermove', ...arguments[0], { hovers: true })", pixel)
    _drag(browser, view, pixel)
    _run(
        browser,
        view,
        "const shift = { deltaY: 100, shiftKey: true, bubbles: true };"
        "view.canvas.dispatchEvent(new WheelEvent('wheel', shift));",
    )
    _tool(browser, view, name="way")
    _drag(browser, view, pixel)
    for name in ("robotAt", "robotPut", "wayPoint"):
        assert _said(browser, view, name)[-1] == pytest.approx([-0.35, -0.25], abs=2e-3)
    assert _said(browser, view, "turn") == [[pytest.approx(np.pi / 36)]]


def test_keys_paint_at_a_cursor(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.look('above')")
    _tool(browser, view, name="paint", shape="cells", level=5)
    keys = ["ArrowRight", "ArrowRight", "ArrowUp", " "]
    _run(
        browser,
        view,
        "const press = (key) => view.canvas.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));"
        "arguments[0].forEach(press);",
        keys,
    )
    assert [event[:2] for event in _said(browser, view, "paint")] == [[[[5, 4]], 5]]


def test_keys_do_what_clicks_and_drags_do(browser: Chrome, view: str) -> None:
    """From the north-west cell of blocks, (0, 5), two cells to the east."""

    def press(*keys: str, shift: bool = False) -> None:
        script = """arguments[0].forEach((key) => view.canvas.dispatchEvent(
            new KeyboardEvent('keydown', { key, bubbles: true, shiftKey: arguments[1] })));"""
        _run(browser, view, script, keys, shift)

    _run(browser, view, "view.look('above')")
    _tool(browser, view, name="draw")
    press("Home", "Enter", "Escape", "ArrowRight", "Enter", "ArrowRight", "Enter")
    assert _said(browser, view, "draw") == [[[1, 5], [2, 5]]]
    _tool(browser, view, name="paint", shape="rectangle", level=5)
    press("Home", "Enter", "ArrowRight", "ArrowDown", "Enter")
    ((cells, level, _),) = _said(browser, view, "paint")
    assert (sorted(cells), level) == ([[0, 4], [0, 5], [1, 4], [1, 5]], 5)
    _tool(browser, view, name="way")
    press("Home", "Enter", "ArrowRight", " ")
    assert np.allclose(_said(browser, view, "wayPoint"), [[-0.35, 0.25], [-0.25, 0.25]])
    _tool(browser, view, name="robot", heading=0)
    press("Home", "ArrowRight")
    assert np.allclose(_said(browser, view, "robotPut"), [[-0.35, 0.25], [-0.25, 0.25]])
    press("ArrowLeft", shift=True)
    assert _said(browser, view, "turn") == [[pytest.approx(np.pi / 36)]]
    assert "arrow keys move the robot" in _run(browser, view, "return view.canvas.ariaLabel")


def test_camera_turns_beside_the_map_and_rests_on_it_while_it_is_painted(browser: Chrome, solid: str) -> None:
    _tool(browser, solid, name="paint", shape="cells", level=1)
    place = "return view.stage.camera.position.toArray()"
    before = _run(browser, solid, place)
    _drag(browser, solid, _pixel(browser, solid, (2, 1)), _pixel(browser, solid, (4, 1)))
    assert _run(browser, solid, place) == before
    _drag(browser, solid, [4, 4], [60, 4])
    assert _run(browser, solid, place) != before


def test_other_map_of_the_same_size_keeps_the_camera(browser: Chrome, solid: str) -> None:
    place = "return view.stage.camera.position.toArray()"
    _run(browser, solid, "view.turn(3, 1)")
    before = _run(browser, solid, place)
    _run(browser, solid, "view.show(arguments[0])", _scene())
    assert _run(browser, solid, place) == before


def test_nothing_is_drawn_while_nothing_changes(browser: Chrome, solid: str) -> None:
    browser.set_script_timeout(30)
    frames = browser.execute_async_script(
        """const done = arguments[0], { info } = window.rsegen.solid.renderer;
        setTimeout(() => {
          const before = info.render.frame;
          setTimeout(() => done(info.render.frame - before), 400);
        }, 900);"""
    )
    assert frames == 0


@pytest.mark.usefixtures("solid")
def test_post_has_a_shadow_in_the_east(browser: Chrome) -> None:
    _run(browser, "solid", "view.look('above'); view.set({ look: 'heights', grid: false })")
    picture = _picture(browser, "solid", 620, 600)

    def light(cell: tuple[int, int]) -> float:
        x, y = np.rint(_pixel(browser, "solid", cell)).astype(int)
        return float(picture[y - 2 : y + 3, x - 2 : x + 3].mean())

    assert light((4, 2)) < 0.75 * light((1, 2))
    assert light((1, 2)) == pytest.approx(light((1, 4)), rel=0.02)


@pytest.mark.usefixtures("solid")
def test_colours_of_heights_are_those_of_the_plan(browser: Chrome) -> None:
    _run(browser, "solid", "view.look('above'); view.set({ look: 'heights', grid: false })")
    solid, plan = _picture(browser, "solid", 620, 600), _picture(browser, "plan", 380, 600)
    for cell in ((1, 4), (6, 5), (3, 2)):
        x, y = np.rint(_pixel(browser, "solid", cell)).astype(int)
        a, b = np.rint(np.subtract(_pixel(browser, "plan", cell), 12)).astype(int)  # beside the number
        # Within what the eye forgives: the sun is a little warm.
        assert np.abs(solid[y, x] - plan[b, a]).max() < 30, cell


@pytest.mark.usefixtures("solid")
def test_pictures_have_the_size_that_is_asked_for(browser: Chrome) -> None:
    for view in ("solid", "plan"):
        assert _picture(browser, view, 320, 200).shape == (200, 320, 3)
    size = browser.execute_async_script(
        """const [scene, done] = arguments;
        const bitmap = window.rsegen.thumbnail(scene, 96, 64).then(createImageBitmap);
        bitmap.then(({ width, height }) => done([width, height]));""",
        _scene(),
    )
    assert size == [96, 64]


def _robot() -> dict[str, Any]:
    box = {
        "shape": "box",
        "size": [0.3, 0.2, 0.1],
        "pose": np.eye(4).ravel().tolist(),
        "colour": "#4060c0",
        "wheel": False,
    }
    return {"name": "box", "title": "Box", "size": [0.3, 0.2, 0.1], "lift": 0, "parts": [box]}


@pytest.mark.parametrize(("stands", "redder"), [(True, False), (False, True)])
def test_robot_is_red_if_it_does_not_stand(browser: Chrome, solid: str, stands: bool, redder: bool) -> None:
    pose: dict[str, Any] = dict.fromkeys(("x", "y", "roll", "pitch", "yaw", "tilt", "margin"), 0.0)
    pose |= {"stands": stands, "holds": True, "pushes": True, "reason": "", "z": 0.45, "clearance": None}
    pose |= {"contacts": [], "polygon": [], "centre": [0, 0, 0.45]}
    _run(browser, solid, "view.look('above'); view.robot(arguments[0], arguments[1])", _robot(), pose)
    x, y = np.rint(_run(browser, solid, "return view.pixel([0.1, 0.05, 0.5])")).astype(int)
    red, _, blue = _picture(browser, solid, 620, 600)[y, x]
    _run(browser, solid, "view.robot(null, null)")
    assert (red > blue) == redder


def test_robot_has_a_shadow_in_the_east(browser: Chrome, solid: str) -> None:
    pose: dict[str, Any] = dict.fromkeys(("roll", "pitch", "yaw", "tilt", "margin"), 0.0)
    pose |= {"stands": True, "holds": True, "pushes": True, "reason": "", "x": -0.25, "y": 0.15, "z": 0.25}
    pose |= {"contacts": [], "polygon": [], "centre": [-0.25, 0.15, 0.25], "clearance": None}
    _run(browser, solid, "view.look('above'); view.set({ look: 'heights', grid: false })")
    x, y = np.rint(_pixel(browser, solid, (3, 5))).astype(int)  # beside it, 8 cm east for each 10 cm that it is higher
    before = _picture(browser, solid, 620, 600)[y, x].mean()
    _run(browser, solid, "view.robot(arguments[0], arguments[1])", _robot(), pose)
    after = _picture(browser, solid, 620, 600)[y, x].mean()
    _run(browser, solid, "view.robot(null, null)")
    assert after < 0.8 * before
    assert _picture(browser, solid, 620, 600)[y, x].mean() == before


@pytest.mark.usefixtures("solid")
def test_footprint_is_where_the_parts_are(browser: Chrome) -> None:
    _run(browser, "plan", "view.set({ grid: false })")
    before = _picture(browser, "plan", 380, 600)
    robot = _robot()
    robot["parts"][0]["pose"][3] = 0.1  # its middle is ahead of the robot's origin
    pose: dict[str, Any] = dict.fromkeys(("x", "y", "z", "roll", "pitch", "tilt", "margin"), 0.0)
    pose |= {"stands": True, "holds": True, "pushes": True, "reason": "", "yaw": np.pi / 2, "clearance": None}
    _run(browser, "plan", "view.robot(arguments[0], arguments[1])", robot, pose | {"contacts": [], "polygon": []})
    x, y = np.nonzero(np.abs(_picture(browser, "plan", 380, 600) - before).max(axis=2).T > 20)
    corners = _run(browser, "plan", "return [view.pixel([-0.1, 0.25]), view.pixel([0.1, -0.05])]")
    _run(browser, "plan", "view.robot(null, null)")
    assert [[x.min(), y.min()], [x.max(), y.max()]] == pytest.approx(np.array(corners), abs=4)


def test_played_robot_is_between_the_samples(browser: Chrome, solid: str) -> None:
    poses = [[0, 0, 0.4, 0, 0, 0], [0.2, 0.1, 0.5, 0, 0, np.pi / 2]]
    track = {
        "name": "one",
        "robot": "box",
        "seconds": [0, 2],
        "poses": poses,
        "events": [{"second": 1, "text": "slip", "kind": "trouble"}],
    }
    playback = {"title": "", "simulator": "", "robots": [track], "duration": 2}
    _run(browser, solid, "view.play(arguments[0], new Map([['box', arguments[1]]])); view.at(1)", playback, _robot())
    where = "const [robot] = view.player.robots; return [...robot.position.toArray(), robot.rotation.z]"
    assert _run(browser, solid, where) == pytest.approx([0.1, 0.05, 0.45, np.pi / 4])
    _run(browser, solid, "view.play(null, new Map())")


def test_drive_is_seen_from_its_start_to_its_end_with_the_map(browser: Chrome, solid: str) -> None:
    ends = [[-1.1, -0.3, 0.1, 0, 0, 0], [0.9, 0.6, 0.1, 0, 0, 0], [0.9, 0.6, -99, 0, 0, 0]]  # then it falls off
    track = {"name": "one", "robot": "box", "seconds": [0, 1, 2], "poses": ends, "events": []}
    playback = {"title": "", "simulator": "", "robots": [track], "duration": 2}
    pixels = "return arguments[0].map((point) => view.pixel(point))"
    points = [pose[:3] for pose in ends[:2]] + [[x, y, 0] for x in (-0.5, 0.5) for y in (-0.4, 0.4)]
    assert not _are_seen(_run(browser, solid, pixels, points)), "without a drive the camera is nearer to the map"
    _run(browser, solid, "view.play(arguments[0], new Map([['box', arguments[1]]]))", playback, _robot())
    assert _are_seen(_run(browser, solid, pixels, points))
    _run(browser, solid, "view.play(null, new Map()); view.look('oblique')")
    assert not _are_seen(_run(browser, solid, pixels, points))


def test_ground_is_seen_from_afar_and_not_the_floor_through_it(browser: Chrome, solid: str) -> None:
    levels, frame = np.zeros((9, 9), dtype=np.int16), np.zeros((9, 9), dtype=bool)
    flat = StepField(levels=levels, frame=frame, unit=UNIT, block_width=WIDTH, frame_height=0.08)
    away = """view.show(arguments[0]); view.set({ look: 'heights', grid: false, axes: false, dark: true });
    view.look('oblique');
    view.stage.camera.position.sub(view.stage.target).multiplyScalar(4).add(view.stage.target);
    view.controls.update();
    return [[-0.4, 0], [0.4, 0]].map(([x, y]) => view.pixel([x, y, 0]))"""
    (left, y0), (right, y1) = _run(browser, solid, away, shown_content(ShownMap.of_field(flat)))
    picture = _picture(browser, solid, 620, 600).mean(axis=2)
    along = np.linspace(0, 1, 100)
    line = picture[np.rint(y0 + along * (y1 - y0)).astype(int), np.rint(left + along * (right - left)).astype(int)]
    assert line.min() > 0.9 * line.max()
    assert line.min() > 2 * picture[-1].max(), "the floor is darker"
    _run(browser, solid, "view.set({ axes: true })")


def _are_seen(pixels: list[list[float]]) -> bool:
    return bool(np.all((np.array(pixels) > 0) & (np.array(pixels) < (620, 600))))


@pytest.mark.parametrize("shown", ["tilt", "margin", "reason"])
def test_map_of_poses_colours_tops(browser: Chrome, view: str, shown: str) -> None:
    _run(browser, view, "view.look('above'); view.set({ look: 'heights', grid: false })")
    before = _picture(browser, view, 380, 380)
    tilt: Callable[[Array], str] = lambda values: b64encode(values.astype("<f4").tobytes()).decode()  # noqa: E731
    values = np.linspace(0, 0.5, 80).reshape(10, 8)
    values[0] = np.nan
    poses = {"shape": [10, 8], "low": [-0.45, -0.35], "step": WIDTH, "tilt": tilt(values), "margin": tilt(values)}
    poses |= {"reason": b64encode(bytes([1] * 8 + [0] * 72)).decode(), "reasons": ["", "tips over"]}
    _run(browser, view, "view.poseMap(arguments[0], arguments[1])", poses, shown)
    after = _picture(browser, view, 380, 380)
    _run(browser, view, "view.poseMap(null, 'tilt')")
    assert (np.abs(after - before).max(axis=2) > 8).mean() > 0.1
    assert np.abs(_picture(browser, view, 380, 380) - before).max() <= 1


def test_scene_without_owners_is_shown(browser: Chrome, view: str) -> None:
    scene = {name: value for name, value in _scene().items() if name not in ("owners", "handles", "step", "look")}
    _run(browser, view, "view.show(arguments[0])", json.loads(json.dumps(scene)))
    _drag(browser, view, _pixel(browser, view, (3, 2)))
    assert _said(browser, view, "pick") == [[-1, [3, 2]]]


@pytest.mark.parametrize("view", ["Solid", "Plan"])
def test_view_that_goes_leaves_its_place_as_it_was(browser: Chrome, view: str) -> None:
    left = browser.execute_script(
        """const host = document.createElement("div");
        host.innerHTML = "<p>other</p>";
        const view = new window.rsegen[arguments[0]](host, {});
        view.show(arguments[1]);
        view.select(1);
        const some = host.children.length;
        view.dispose();
        return [some > 4, host.innerHTML];""",
        view,
        _scene(),
    )
    assert left == [True, "<p>other</p>"]


def test_browser_without_3d_graphics_is_an_error(browser: Chrome) -> None:
    said = browser.execute_script(
        """const { getContext } = HTMLCanvasElement.prototype;
        const [host, complain] = [document.createElement("div"), console.error];
        HTMLCanvasElement.prototype.getContext = () => null;
        console.error = () => {};
        try { new window.rsegen.Solid(host, {}); } catch (error) { return [error.message, host.outerHTML]; }
        finally { [HTMLCanvasElement.prototype.getContext, console.error] = [getContext, complain]; }"""
    )
    assert said == ["THREE.WebGLRenderer: Error creating WebGL context.", "<div></div>"]


def test_second_finger_ends_a_stroke(browser: Chrome, solid: str) -> None:
    _tool(browser, solid, name="paint", shape="cells", level=2)
    _run(
        browser,
        solid,
        """view.look("above");
        const [a, b, c] = [[2, 2], [3, 2], [7, 5]].map((cell) => view.pixelOf(...cell));
        const [one, two] = [1, 2].map((pointerId) => ({ pointerId, pointerType: "touch" }));
        send(view, "pointerdown", ...a, one);
        send(view, "pointermove", ...b, one);
        send(view, "pointerdown", ...c, two);
        send(view, "pointermove", ...c, one);
        send(view, "pointerup", ...c, two);
        send(view, "pointerup", ...c, one);""",
    )
    assert [event[0] for event in _said(browser, solid, "paint")] == [[[1, 1]], [[2, 1]]]


def test_cells_below_the_brush_look_as_they_will(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.look('above')")
    before = _picture(browser, view, 380, 380)
    _tool(browser, view, name="paint", shape="cells", level=6)
    _drag(browser, view, _pixel(browser, view, (0, 0)), _pixel(browser, view, (2, 0)))
    after = _picture(browser, view, 380, 380)
    _run(browser, view, "view.show(arguments[0])", _scene())
    assert (np.abs(after - before).max(axis=2) > 40).mean() > 0.015
    assert np.abs(_picture(browser, view, 380, 380) - before).max() <= 1


def test_robot_does_not_reach_what_is_pale(browser: Chrome, view: str) -> None:
    _run(browser, view, "view.look('above'); view.set({ grid: false })")
    before = _picture(browser, view, 380, 380)
    region = np.ones((10, 8), dtype=np.uint8)
    region[:5] = 0
    reach = {"text": "", "region": b64encode(region.tobytes()).decode(), "ways": [], "spots": []}
    _run(browser, view, "view.reach(arguments[0])", reach)
    changed = (_picture(browser, view, 380, 380) - before).max(axis=2) > 20
    _run(browser, view, "view.reach(null)")
    assert changed[:, :185].mean() > 0.2
    assert changed[:, 195:].mean() < 0.01
