"""The sheet as PDF, read back by another library."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from pypdf import PageObject, PdfReader

from rsegen import CutSettings, Random, Recipe, Scene, __version__, compose, load, sheet
from rsegen.build_sheets.document import pages
from rsegen.build_sheets.timber import building_order, placing_order
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Ints
from rsegen.recipe.codec import decode
from rsegen.recipe.examples import EXAMPLES
from rsegen.scene.scene import fingerprint
from tests.support.long import long_unless

BLOCKS = (Random(levels=5),)
POINTS_A_MM = 72 / 25.4


@cache
def read(recipe: Recipe, saw: CutSettings | None = None) -> PdfReader:
    """The sheet of the first map, made once per recipe."""
    return PdfReader(io.BytesIO(sheet(compose(recipe, recipe.first_map), saw)))


def words(page: PageObject) -> str:
    return " ".join(page.extract_text().split())


def placed(page: PageObject) -> Iterator[tuple[str, float, float, float]]:
    """Every text with where it begins, millimetres from the upper left corner, and its size in points."""
    found: list[tuple[str, float, float, float]] = []

    def visit(text: str, cm: Any, tm: Any, font: Any, size: float) -> None:
        x = cm[0] * tm[4] + cm[2] * tm[5] + cm[4]
        y = cm[1] * tm[4] + cm[3] * tm[5] + cm[5]
        found.extend((one, x / POINTS_A_MM, 297 - y / POINTS_A_MM, size) for one in text.split())

    page.extract_text(visitor_text=visit)
    yield from found


def cells(page: PageObject, shape: tuple[int, int], top: float = 40, side: float = 172) -> dict[str, list[list[str]]]:
    """The texts that begin in each cell of the plan, frames counted, by `large` and `small`; the top row first."""
    cell = side / max(shape)
    left = (210 - shape[0] * cell) / 2
    grids = {name: [["" for _ in range(shape[0])] for _ in range(shape[1])] for name in ("large", "small")}
    written = [
        (text, int((x - left) // cell), int((y - top) // cell), size)
        for text, x, y, size in placed(page)
        if left <= x < left + shape[0] * cell and top <= y < top + shape[1] * cell
    ]
    largest = max(size for *_, size in written)
    for text, column, row, size in written:
        grid = grids["large" if size > 0.9 * largest else "small"]
        assert grid[row][column] == ""
        grid[row][column] = text
    return grids


def inside(grid: list[list[str]], scene: Scene, number: int) -> list[list[str]]:
    """Texts in the cells that are no frame."""
    field = building_order(scene)[number].chunk.field
    rows = [row for row, kept in zip(grid, field.inside(1)[::-1], strict=True) if kept]
    return [[text for text, kept in zip(row, field.inside(0), strict=True) if kept] for row in rows]


def as_read(values: Ints) -> list[list[int]]:
    return [[int(value) for value in row] for row in values.T[::-1]]


RECIPES = {
    "framed": Recipe(seed=2, chunks=(2, 2), obstacles=BLOCKS),
    "bare": Recipe(seed=2, chunks=(3, 1), chunk_size=6, boundary="none", unit_cm=7.5, obstacles=BLOCKS),
    "outer": Recipe(seed=2, chunks=(2, 3), chunk_size=5, boundary="outer", unit_cm=12.5, obstacles=BLOCKS),
    "twenty": Recipe(seed=2, chunk_size=20, obstacles=BLOCKS),
    "real": load(EXAMPLES["red-diagonal-pallet"]),
}
EVERY = pytest.mark.parametrize(
    "name", long_unless({"framed", "twenty"}.__contains__, RECIPES, reason="a second per sheet")
)


@pytest.mark.slow
@EVERY
def test_it_is_a_page_of_a4_for_the_map_each_pallet_the_materials_and_a_form(name: str) -> None:
    recipe = RECIPES[name]
    pages = read(recipe).pages
    assert len(pages) == 3 + recipe.chunks[0] * recipe.chunks[1]
    for page in pages:
        assert [float(side) / POINTS_A_MM for side in page.mediabox[2:]] == pytest.approx([210, 297], abs=0.01)


@pytest.mark.slow
def test_a_sheet_in_inches_is_on_letter_and_all_its_texts_are_within_the_margins() -> None:
    recipe = Recipe(seed=2, units="in", unit_cm=3.81, block_width_cm=8.89, chunk_size=3, obstacles=BLOCKS)
    assert "sold as 4x4, dry and planed" in words(read(recipe).pages[0])
    for page, figure in zip(read(recipe).pages, pages(compose(recipe), CutSettings.default("in")), strict=True):
        assert [float(side) / 72 for side in page.mediabox[2:]] == pytest.approx([8.5, 11], abs=1e-3)
        figure.draw_without_rendering()
        paper = figure.axes[0].transData.inverted()
        drawn = [text.get_window_extent() for text in figure.axes[0].texts if text.get_text().strip()]
        corners = paper.transform([corner for box in drawn for corner in (box.p0, box.p1)])
        assert len(drawn) > 5
        assert (corners.min(axis=0) >= 10).all()  # millimetres
        assert (corners.max(axis=0) <= np.array([8.5, 11]) * 25.4 - 10).all()


@pytest.mark.slow
@pytest.mark.parametrize("units", ["cm", "in"])
def test_all_that_is_drawn_can_be_printed_and_no_texts_overlap(units: str) -> None:
    """Printers leave some 6 mm; texts that touch, by up to 0.3 mm, are still legible."""
    own: dict[str, Any] = {} if units == "cm" else {"units": "in", "unit_cm": 3.81, "block_width_cm": 8.89}
    recipe = Recipe(seed=2, chunks=(3, 2), chunk_size=6, obstacles=BLOCKS, **own)
    for figure in pages(compose(recipe), CutSettings.default(units)):
        figure.draw_without_rendering()
        axes = figure.axes[0]
        paper, size = axes.transData.inverted(), figure.get_size_inches() * 25.4
        texts = [text for text in axes.texts if text.get_text().strip()]
        drawn = [each.get_window_extent() for each in (*texts, *axes.lines, *axes.patches)]
        ends = np.sort([paper.transform(box.get_points()) for box in drawn], axis=1)
        assert (ends[:, 0] >= 6).all()
        assert (ends[:, 1] <= size - 6).all()
        low, high = ends[: len(texts)].swapaxes(0, 1)
        common = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
        overlaps = np.argwhere(np.triu((common > 0.3).all(axis=2), 1))
        assert [(texts[a].get_text(), texts[b].get_text()) for a, b in overlaps] == []


@EVERY
def test_every_cell_of_a_pallet_has_its_height_on_its_page(name: str) -> None:
    recipe = RECIPES[name]
    scene, pages = compose(recipe), read(recipe).pages
    for number, each in enumerate(building_order(scene)):
        grid = inside(cells(pages[number + 1], each.chunk.field.shape)["large"], scene, number)
        heights = [[float(text) for text in row] for row in grid]
        assert heights == [[level * recipe.unit_cm for level in row] for row in as_read(each.levels)]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["framed", "bare", "outer", "real"])
def test_blocks_of_small_pallets_have_their_order(name: str) -> None:
    scene, pages = compose(RECIPES[name]), read(RECIPES[name]).pages
    for number, each in enumerate(building_order(scene)):
        grid = inside(cells(pages[number + 1], each.chunk.field.shape)["small"], scene, number)
        assert [[int(text or 0) for text in row] for row in grid] == as_read(placing_order(each.levels))
        assert "Small numbers are the order of placing" in words(pages[number + 1])


@pytest.mark.long(reason="a sheet of a large map")
def test_cells_too_small_for_heights_have_levels_with_a_note() -> None:
    recipe = Recipe(seed=2, chunk_size=48, unit_cm=12.5, boundary="none", obstacles=BLOCKS)
    page = read(recipe).pages[1]
    grid, said = cells(page, (48, 48))["large"], words(page)
    assert [[int(text) for text in row] for row in grid] == as_read(compose(recipe).field.levels)
    assert "Numbers are levels, for want of room: a block of level n is n x 12.5 cm long." in said
    assert "The sheet as CSV has the order of placing." in said


def test_rulers_on_all_sides_of_a_pallet_count_the_cells_of_the_map_and_an_arrow_shows_north() -> None:
    page, top, left, side = read(RECIPES["framed"]).pages[2], 40.0, 19.0, 172.0
    found: dict[str, dict[int, str]] = {name: {} for name in ("north", "south", "west", "east")}
    for text, x, y, _ in placed(page):
        column, row = (int((at - start) // (side / 12)) for at, start in ((x, left), (y, top)))
        if text.isdecimal() and 0 <= column < 12 and min(abs(y - top + 2), abs(y - top - side - 4)) < 3:
            found["north" if y < top else "south"][column] = text
        if text.isdecimal() and 0 <= row < 12 and not 0 <= x - left < side:
            found["west" if x < left else "east"][row] = text
    columns = {at: str(9 + at) for at in range(1, 11)}  # the frame is the first one
    rows = {at: str(20 - at) for at in range(1, 11)}
    assert found == {"north": columns, "south": columns, "west": rows, "east": rows}
    assert [(x > left + side - 10, y < 20) for text, x, y, _ in placed(page) if text == "N"] == [(True, True)]


@EVERY
def test_cut_lists_are_the_blocks_of_the_map_and_of_each_pallet(name: str) -> None:
    recipe = RECIPES[name]
    scene, pages = compose(recipe), read(recipe).pages
    fields = [scene.field, *(each.chunk.field for each in building_order(scene))]
    for field, page in zip(fields, pages[:-2], strict=True):
        counts, said = {level: count for level, count in field.level_counts().items() if level}, words(page)
        for level, count in counts.items():
            length = level * recipe.unit_cm
            assert f"{level} {length:g} {count:,} {length * count / 100 + 1e-9:,.2f} m" in said
        total = sum(level * count for level, count in counts.items()) * recipe.unit_cm / 100
        assert f"together {sum(counts.values()):,} {total + 1e-9:,.2f} m" in said
        assert f"no block: {field.level_counts().get(0, 0):,} cell" in said


def test_the_first_page_lists_the_timber_to_buy() -> None:
    page = words(read(RECIPES["real"]).pages[0])
    for said in ("Build sheet: red-diagonal-pallet_0000", "1.2 x 1.2 m, 12 x 12 cells with frames, 1 pallet, seed 1"):
        assert said in page
    for said in (
        "blocks: 240 cm of 10 x 10 cm 9 pieces",
        "blocks together 19.60 m",
        "lost: 3 mm per cut + 0.5 mm per part 0.32 m",
    ):
        assert said in page
    for said in ("2 boards of 120 cm 2.40 m", "2 boards of 100 cm 2.00 m", "frames: 240 cm of 10 x 10 cm 2 pieces"):
        assert said in page
    for said in ("ends, 1 cm each 0.18 m", "left over 1.50 m", "2 x 5 x 40 + 1 x 30 5.9 left", "seen from above"):
        assert said in page
    assert f"fingerprint {fingerprint(compose(RECIPES['real']).field.blocks)}; rsegen {__version__}" in page


@pytest.mark.slow
def test_a_page_has_the_frame_cuts_the_weight_and_the_costs() -> None:
    """Blocks of 19.6 m and boards of 4.4 m, all 10 x 10 cm and of 500 kg/m3."""
    page = words(read(RECIPES["real"], CutSettings(price=4.5, frame_price=3)).pages[-2])
    for said in ("boards, 10 x 10 cm high 4.40 m", "stock of 240 cm 2 pieces", "2 x 1 x 120 + 1 x 100 17.3 left"):
        assert said in page
    for said in ("1 of 120 x 120 cm", "of 500 kg/m3 98 kg", "frames 22 kg", "blocks: 9 x 4.50 40.50"):
        assert said in page
    assert "together, without base boards 46.50" in page
    assert "no price given" in words(read(RECIPES["real"]).pages[-2])
    equal_sections = words(read(RECIPES["real"], CutSettings(price=4.5)).pages[-2])
    assert "frames: 2 x 4.50 9.00 together, without base boards 49.50" in equal_sections
    lower = replace(RECIPES["real"], frame_height_cm=5)
    other_sections = words(read(lower, CutSettings(price=4.5)).pages[-2])
    assert "frames: no price given (--frame-price)" in other_sections
    assert "together" not in other_sections
    assert "Frames none Base boards 6 of" in words(read(replace(RECIPES["outer"], boundary="none")).pages[-2])
    short = words(read(RECIPES["real"], CutSettings(stock_cm=100)).pages[-2])
    assert "100 cm of stock is too short for them: give 122.05 cm or more (--stock-cm)" in short


def test_the_last_page_is_a_form_for_repetitions() -> None:
    page = words(read(RECIPES["real"]).pages[-1])
    assert f"fingerprint {fingerprint(compose(RECIPES['real']).field.blocks)}; from start (west) to goal (east)" in page
    assert all(each in page for each in ("attempts", "successes", "mean time", "Robot", "Operator", " 30 "))


def test_a_fingerprint_is_of_the_levels_alone() -> None:
    scene = compose(RECIPES["real"])
    found = fingerprint(scene.field.blocks)
    assert found == "BNTP-5D5T"
    other = compose(replace(RECIPES["real"], unit_cm=5, boundary="none", name="other"))
    assert fingerprint(other.field.blocks) == found
    assert fingerprint(scene.field.blocks.T.copy()) != found
    assert fingerprint(np.zeros((2, 3), dtype=np.int16)) != fingerprint(np.zeros((3, 2), dtype=np.int16))


def test_every_pallet_has_its_fingerprint_on_its_page() -> None:
    scene, pages = compose(RECIPES["framed"]), read(RECIPES["framed"]).pages
    names = [fingerprint(each.levels) for each in building_order(scene)]
    assert len(set(names)) == len(names) > 1
    assert all(f"fingerprint {name}" in words(page) for name, page in zip(names, pages[1:], strict=False))


@pytest.mark.slow
def test_a_long_name_and_a_long_way_to_cut_stay_on_the_page() -> None:
    recipe = Recipe(seed=3, name="n" * 64, unit_cm=0.125, obstacles=(Random(levels=12),))
    first = read(recipe).pages[0]
    counts = {level: count for level, count in compose(recipe).field.level_counts().items() if level}
    parts = " + ".join(f"{count} x {level / 8:g}" for level, count in reversed(counts.items()))
    assert parts in words(first)
    assert all(size < 13 for text, *_, size in placed(first) if "nnn" in text)


def test_another_saw_and_stock_are_counted_with() -> None:
    page = words(read(RECIPES["real"], CutSettings(kerf_mm=0, tolerance_mm=0, trim_cm=0, stock_cm=100)).pages[0])
    assert "blocks: 100 cm of 10 x 10 cm 20 pieces" in page
    assert "lost: 0 mm per cut + 0 mm per part 0.00 m" in page
    assert "frames: 100 cm of 10 x 10 cm too short" in page


def test_pallets_are_numbered_and_named_on_the_first_page() -> None:
    recipe = RECIPES["framed"]
    pages = read(recipe).pages
    first = words(pages[0])
    for said in ("1: A2", "2: B2", "3: A1", "4: B1"):
        assert said in first
    assert words(pages[2]).startswith(
        "Pallet B2 rse_0000, 2 of 4 in the order of building; cells 10..19 along x, 10..19"
    )


@pytest.mark.slow
def test_the_first_page_lists_the_blocks_of_each_pallet_if_they_fit() -> None:
    recipe = load(EXAMPLES["five-pallet-dash"])
    first = words(read(recipe).pages[0])
    for each in building_order(compose(recipe)):
        counts = each.chunk.field.level_counts()
        assert f"{each.number} {each.name} {' '.join(str(counts.get(level, 0)) for level in range(1, 5))}" in first


@pytest.mark.slow
def test_many_lengths_are_in_narrow_columns_and_omitted_ones_are_counted() -> None:
    recipe = Recipe(seed=2, chunk_size=20, unit_cm=1, obstacles=(Random(levels=31),))
    counts = compose(recipe).field.level_counts()
    first, second, *_ = map(words, read(recipe).pages)
    for level in range(1, 31):
        assert f"{counts[level]} x {level} " in first
    listed = sum(f"{counts[level]} x {level} " in second for level in range(1, 31))
    assert f"and {30 - listed} more lengths, which the sheet as CSV has" in second


@pytest.mark.slow
@pytest.mark.parametrize("format_", ["pdf", "csv"])
def test_same_map_same_bytes(format_: str) -> None:
    scene = compose(RECIPES["real"])
    assert sheet(scene, format=format_) == sheet(scene, format=format_)


def test_another_format_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ParameterError, match=r"format: unknown format 'png' \(known: csv, pdf\)"):
        sheet(compose(RECIPES["bare"]), format="png")


def test_it_carries_its_recipe_and_no_date() -> None:
    metadata = read(RECIPES["framed"]).metadata
    assert metadata
    assert decode(json.loads(metadata.subject or "")) == RECIPES["framed"]
    assert not {"/CreationDate", "/ModDate"} & metadata.keys()


@pytest.mark.slow
@pytest.mark.parametrize(
    "recipe",
    [
        Recipe(seed=1),
        Recipe(seed=1, chunk_size=1, boundary="none", obstacles=BLOCKS),
        Recipe(seed=1, frame_height_cm=0),
        Recipe(seed=1, description="$x^2$ <&> {0} 地图 \u202e"),
    ],
    ids=["flat", "one", "frames of no height", "odd description"],
)
def test_the_oddest_maps_have_a_sheet(recipe: Recipe) -> None:
    assert len(read(recipe).pages) == 4


@pytest.mark.slow
def test_pallets_of_other_shapes_read_north_up() -> None:
    """One block in the north-east corner of a map, whatever its frames."""
    for boundary, size in (("none", (1, 2)), ("divided", (2, 1)), ("outer", (1, 2))):
        recipe = Recipe(seed=1, chunks=size, chunk_size=3, boundary=boundary, obstacles=BLOCKS)
        scene = compose(recipe)
        levels = np.zeros_like(scene.field.levels)
        i, j = (scene.field.inside(axis).nonzero()[0][-1] for axis in (0, 1))
        levels[i, j] = 4
        scene = replace(scene, field=replace(scene.field, levels=levels))
        last = building_order(scene)[0] if size == (1, 2) else building_order(scene)[1]
        page = PdfReader(io.BytesIO(sheet(scene))).pages[last.number]
        grid = inside(cells(page, last.chunk.field.shape)["large"], scene, last.number - 1)
        assert grid == [["0", "0", "40"], ["0"] * 3, ["0"] * 3]


@pytest.mark.parametrize(
    ("recipe", "said"),
    [
        (
            Recipe(seed=1, chunk_size=61),
            "chunk_size: 61 blocks per side do not fit on a page of a build sheet; use up to 60",
        ),
        (Recipe(seed=1, chunks=(401, 1), chunk_size=1), "chunks: 401 pallets with 401 blocks are too many"),
        (Recipe(seed=1, chunks=(3, 4), chunk_size=60), "chunks: 12 pallets with 43,200 blocks are too many"),
        (
            Recipe(seed=1, unit_cm=61, obstacles=BLOCKS),
            "stock_cm: 240 cm is too short for blocks of the highest level, 244 cm",
        ),
    ],
    ids=["large pallets", "many pallets", "many blocks", "long blocks"],
)
@pytest.mark.parametrize("format_", ["pdf", "csv"])
def test_a_map_too_large_for_a_sheet_is_refused(recipe: Recipe, said: str, format_: str) -> None:
    with pytest.raises(ParameterError) as refused:
        sheet(compose(recipe), format=format_)
    assert said in str(refused.value)
