"""The page of maps: it says what the field is, loads nothing, and obeys no recipe."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import Random, Recipe, StepField
from rsegen.page import browser as page_files
from rsegen.page.shown_map import ShownMap, editor_page, page
from rsegen.pictures.plan import cell_colours
from rsegen.recipe.examples import EXAMPLES
from rsegen.scene.colours import height_colour, oklab
from rsegen.scene.scene import fingerprint
from tests.page.browser.pages import Tags, addresses, cells_of, heights_of, maps_of
from tests.support.strategies import fields, recipes

HOSTILE = "</script><script>window.hurt = 1</script><img src=x onerror='hurt=1'><!--&amp;{{data}}\u2028 $&"
ROUGH = Recipe(seed=3, obstacles=[Random(levels=5)])


@given(fields())
def test_cells_of_the_page_have_the_heights_of_the_field(field: StepField) -> None:
    (shown,) = maps_of(rsegen.view(field).html)
    assert np.array_equal(heights_of(shown), field.heights)
    frames = np.array([entry["level"] is None for entry in shown["palette"]])
    assert np.array_equal(frames[cells_of(shown)], field.frame)


@given(recipes(), st.integers(0, 5))
def test_the_same_map_gives_the_same_bytes_and_a_recipe_that_makes_it_again(recipe: Recipe, index: int) -> None:
    html = rsegen.view(recipe, index).html
    assert html == rsegen.view(recipe, index).html == rsegen.view(rsegen.compose(recipe, index)).html
    (shown,) = maps_of(html)
    assert shown["name"] == recipe.map_name(index)


@pytest.mark.parametrize("path", EXAMPLES.values(), ids=lambda path: path.stem)
def test_the_recipe_of_the_page_makes_its_map(path: Path, tmp_path: Path) -> None:
    recipe = rsegen.load(path)
    shown = maps_of(rsegen.view(recipe).html)
    assert [each["name"] for each in shown] == [recipe.map_name(index) for index in recipe.indices]
    for index, each in zip(recipe.indices, shown, strict=True):
        (tmp_path / each["file"]).write_text(each["recipe"], "utf-8")
        again = rsegen.load(tmp_path / each["file"])
        field = rsegen.compose(again, again.first_map).field
        assert field == rsegen.build(recipe, index)
        assert dict(each["facts"])["fingerprint"] == fingerprint(field.blocks)


def test_large_fields_have_two_bytes_for_each_cell() -> None:
    levels = np.arange(600, dtype=np.int16).reshape(20, 30)
    frame = np.zeros((20, 30), dtype=bool)
    field = StepField(levels=levels, frame=frame, block_width=0.1, unit=0.01, frame_height=0.1)
    (shown,) = maps_of(rsegen.view(field).html)
    assert shown["bytes"] == 2
    assert np.array_equal(heights_of(shown), field.heights)
    (few,) = maps_of(rsegen.view(replace(field, levels=levels % 256)).html)
    assert few["bytes"] == 1


def test_a_recipe_obeys_nobody() -> None:
    """Names cannot have such letters, descriptions can; and fields may be called anything."""
    recipe = replace(ROUGH, description=HOSTILE)
    html = rsegen.view(recipe).html
    plain = rsegen.view(replace(recipe, description="x")).html
    assert [tag for tag, _ in Tags(html.decode()).tags] == [tag for tag, _ in Tags(plain.decode()).tags]
    (shown,) = maps_of(html)
    assert shown["description"] == HOSTILE
    named = page([ShownMap.of_field(rsegen.build(ROUGH), HOSTILE)])
    assert Tags(named.decode()).title == HOSTILE
    assert len(Tags(named.decode()).tags) == len(Tags(plain.decode()).tags)


def test_the_page_loads_nothing_and_says_that_it_may_not() -> None:
    html = rsegen.view(ROUGH).html
    assert addresses(html) == {"data:,"}
    assert b"default-src 'none'" in html
    assert b"connect-src 'none'" in html


def test_the_page_runs_its_own_script_and_no_other() -> None:
    html = rsegen.view(ROUGH).html.decode()
    policy = next(attrs["content"] for _, attrs in Tags(html).tags if attrs.get("http-equiv"))
    assert policy
    for tag, source in (("script", "script-src"), ("style", "style-src")):
        (text,) = re.findall(f"<{tag}>(.*?)</{tag}>", html, re.DOTALL)
        digest = b64encode(sha256(text.encode()).digest()).decode()
        assert f"{source} 'sha256-{digest}';" in policy
    assert "unsafe" not in policy


def test_the_page_that_edits_is_the_page_without_maps() -> None:
    frozen = rsegen.view(ROUGH).html.decode()
    editor = editor_page()
    assert re.sub(r"<script type=.*?</script>\n", "", frozen).replace(
        "connect-src 'none'", "connect-src 'self'"
    ) == editor.replace("<title>rsegen</title>", f"<title>{ROUGH.map_name(0)}</title>")


def test_the_page_of_100_x_100_blocks_is_below_2_mb() -> None:
    assert len(rsegen.view(replace(ROUGH, chunk_size=100)).html) < 2_000_000


def test_the_script_is_in_the_page_with_the_licences_of_its_libraries() -> None:
    html = rsegen.view(ROUGH).html.decode()
    licence = html.index("Copyright © 2010-2026 three.js authors")
    assert html.index("The above copyright notice", licence) > licence
    script = html.partition("<script>")[2]
    assert "<!--" not in script
    assert script.count("</script") == 1


def test_heights_are_in_the_units_of_the_recipe() -> None:
    (shown,) = maps_of(rsegen.view(replace(ROUGH, unit_cm=8.89, units="in")).html)
    assert [entry["label"] for entry in shown["palette"] if entry["level"]] == ["3.5", "7", "10.5", "14"]
    assert shown["unit"] == "in"


@pytest.mark.parametrize("look", ["plain", "levels", "wood", "friction"])
def test_the_surface_has_the_colours_of_the_look_and_heights_have_their_own(look: str) -> None:
    scene = rsegen.compose(replace(ROUGH, look=look))
    (shown,) = maps_of(rsegen.view(scene).html)
    for entry in shown["palette"]:
        if entry["level"] == 0:
            continue
        colour = height_colour(entry["height"]) if entry["level"] else scene.colour(0)
        is_material = look in ("wood", "friction")
        surface = scene.surface_colour(entry["level"] or 0) if is_material else colour
        for name, wanted in (("colour", colour), ("surface", surface)):
            parts = [int(entry[name][at : at + 2], 16) for at in (1, 3, 5)]
            assert parts == [round(255 * part) for part in wanted]


@given(recipes())
def test_cells_have_the_colours_of_plans(recipe: Recipe) -> None:
    scene = rsegen.compose(recipe, 0)
    (shown,) = maps_of(rsegen.view(scene).html)
    palette = [[int(entry["colour"][at : at + 2], 16) for at in (1, 3, 5)] for entry in shown["palette"]]
    planned = cell_colours(scene.plan_colour, scene.field)
    assert np.array_equal(np.array(palette)[cells_of(shown)], np.rint(255 * planned))


def test_a_field_that_is_all_frame_is_shown() -> None:
    field = replace(rsegen.build(ROUGH), frame=np.ones((12, 12), dtype=bool), levels=np.zeros((12, 12), dtype=np.int16))
    (shown,) = maps_of(rsegen.view(field).html)
    assert shown["metrics"] == []
    assert [entry["level"] for entry in shown["palette"]] == [None]


def test_a_notebook_shows_the_page_in_a_frame() -> None:
    view = rsegen.view(ROUGH)
    html = view._repr_html_()
    ((tag, attrs),) = Tags(html).tags
    assert tag == "iframe"
    assert attrs["srcdoc"] == view.html.decode()
    assert "allow-same-origin" not in (attrs["sandbox"] or "")


def test_metrics_equal_the_output_of_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    (shown,) = maps_of(rsegen.view(ROUGH).html)
    found = rsegen.metrics(rsegen.build(ROUGH))
    values = {name: value for name, value, _ in shown["metrics"]}
    assert found.steps.rms is not None
    assert values["rms step"] == f"{found.steps.rms * 100:.2f}".rstrip("0").rstrip(".") + " cm"
    assert values["entropy"] == f"{found.spread.entropy:.2f} bits"
    assert re.fullmatch(r"[\d.]+ cm", values["smallest step, west to east"])


def test_no_colour_of_tilt_is_that_of_a_height() -> None:
    text = (Path(page_files.__file__).parent / "app" / "overlay.ts").read_text("utf-8")
    ramp = json.loads(re.findall(r"RAMP = (\[\[.*?\]\]);", text)[0])
    assert len(ramp) == 5
    places = np.linspace(0, 1, 21)
    corners = np.array([oklab((r / 255, g / 255, b / 255)) for r, g, b in ramp])
    tilts = np.stack([np.interp(places * 4, range(5), corners[:, axis]) for axis in range(3)], axis=1)
    heights = np.array([oklab(height_colour(height)) for height in np.geomspace(0.01, 2, 100)])
    apart = np.linalg.norm(tilts[:, None] - heights[None], axis=2)
    assert apart.min() > 0.08  # four times what one sees side by side
    assert (np.diff(tilts[:, 0]) < 0).all(), "it reads in grey too"
