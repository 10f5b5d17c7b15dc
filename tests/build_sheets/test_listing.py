"""The sheet as CSV: a row for every cell, of which rsegen import makes the same map again."""

from __future__ import annotations

import csv
import re
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from rsegen import CutSettings, Matrix, Random, Recipe, build, compose, imported, load, sheet
from rsegen.build_sheets.timber import building_order
from rsegen.cli.edge import main
from rsegen.errors import FileError, ParameterError
from rsegen.heights.table import Table
from rsegen.recipe.examples import EXAMPLES
from rsegen.scene.scene import fingerprint
from tests.support.strategies import recipes

BLOCKS = (Random(levels=5),)
RECIPE = Recipe(seed=7, chunk_size=2, chunks=(2, 1), obstacles=BLOCKS)


def text_of(recipe: Recipe) -> str:
    return sheet(compose(recipe, recipe.first_map), format="csv").decode()


def written(folder: Path, text: str) -> Path:
    path = folder / "sheet.csv"
    path.write_text(text, "utf-8")
    return path


def rows_of(recipe: Recipe) -> list[dict[str, str]]:
    return list(csv.DictReader(line for line in text_of(recipe).splitlines() if not line.startswith("#")))


@pytest.mark.slow
@given(recipe=recipes())
def test_a_map_rebuilt_from_its_sheet_is_the_map(recipe: Recipe, tmp_path_factory: pytest.TempPathFactory) -> None:
    again = imported(written(tmp_path_factory.mktemp("again"), text_of(recipe)), Table())
    assert build(again) == build(recipe, recipe.first_map)


@pytest.mark.parametrize("boundary", ["none", "divided", "outer"])
@pytest.mark.parametrize("unit_cm", [10, 7.5, 0.125])
def test_import_makes_the_world_of_a_sheet(tmp_path: Path, boundary: str, unit_cm: float) -> None:
    recipe = Recipe(
        seed=3,
        chunk_size=4,
        chunks=(3, 2),
        unit_cm=unit_cm,
        block_width_cm=8.5,
        frame_height_cm=12.5,
        boundary=boundary,
        obstacles=BLOCKS,
    )
    path = written(tmp_path, text_of(recipe))
    assert main(["import", str(path), "-o", str(tmp_path / "worlds")]) == 0
    again = load(tmp_path / "worlds" / "sheet_0000" / "recipe.json")
    assert build(again) == build(recipe)
    assert (again.chunks, again.chunk_size) == (recipe.chunks, recipe.chunk_size)


@pytest.mark.parametrize("path", EXAMPLES.values(), ids=lambda path: path.stem)
def test_every_cell_has_one_row_with_its_height(path: Path) -> None:
    recipe = load(path)
    if recipe.chunk_size > 60:
        pytest.skip("too large for a sheet, which is tested elsewhere")
    field, rows = compose(recipe).field, rows_of(recipe)
    cells = {(int(row["x"]), int(row["y"])): float(row["height_cm"]) for row in rows}
    assert len(cells) == len(rows) == field.blocks.size
    assert all(cells[at] == pytest.approx(level * recipe.unit_cm) for at, level in np.ndenumerate(field.blocks))
    assert all(bool(row["order"]) == (row["height_cm"] != "0") for row in rows)


def test_rows_stand_in_the_order_of_placing() -> None:
    rows = rows_of(Recipe(seed=1, chunks=(2, 2), obstacles=BLOCKS))
    assert list(dict.fromkeys(row["pallet"] for row in rows)) == ["A2", "B2", "A1", "B1"]
    for pallet in ("A2", "B2", "A1", "B1"):
        order = [int(row["order"]) for row in rows if row["pallet"] == pallet and row["order"]]
        assert order == list(range(1, len(order) + 1))


def test_its_head_is_the_cut_list_of_its_rows() -> None:
    recipe = Recipe(seed=1, chunks=(2, 2), unit_cm=7.5, obstacles=BLOCKS)
    counts = Counter(row["height_cm"] for row in rows_of(recipe) if row["order"])
    said = [line for line in text_of(recipe).splitlines() if line.startswith("# cut: ")]
    assert said == [f"# cut: {counts[height]} blocks of {height} cm" for height in ("7.5", "15", "22.5", "30")]


def test_its_head_says_how_every_piece_of_stock_is_sawn() -> None:
    said = [line for line in text_of(load(EXAMPLES["red-diagonal-pallet"])).splitlines() if line.startswith("# s")]
    assert said == [
        "# stock for the blocks: 9 pieces of 240 cm less 3 mm per cut + 0.5 mm per part and 2 cm of ends",
        "# saw: 2 pieces into 5 x 40 cm + 1 x 30 cm",
        "# saw: 2 pieces into 7 x 30 cm + 1 x 20 cm",
        "# saw: 1 piece into 5 x 30 cm + 4 x 20 cm",
        "# saw: 2 pieces into 11 x 20 cm + 1 x 10 cm",
        "# saw: 1 piece into 5 x 20 cm + 13 x 10 cm",
        "# saw: 1 piece into 12 x 10 cm",
        "# stock for the frames: 2 pieces of 240 cm less 3 mm per cut + 0.5 mm per part and 2 cm of ends",
        "# saw for frames: 2 pieces into 1 x 120 cm + 1 x 100 cm",
    ]


def test_the_head_has_the_other_materials_and_the_fingerprint() -> None:
    scene = compose(Recipe(seed=1, chunks=(2, 1), obstacles=BLOCKS))
    said = sheet(scene, CutSettings(price=2, frame_price=1.5), "csv").decode().splitlines()
    pallets = [f"# fingerprint of {each.name}: {fingerprint(each.levels)}" for each in building_order(scene)]
    assert f"# fingerprint of the levels: {fingerprint(scene.field.blocks)}" in said
    assert [line for line in said if line.startswith("# fingerprint of ")][1:] == pallets
    assert "# base boards: 2 of 120 x 120 cm" in said
    kilograms = sum(level * count for level, count in scene.field.level_counts().items()) * 0.1 * 5
    assert f"# weight: {kilograms:.0f} kg blocks + 44 kg frames" in said
    blocks = next(int(line.split()[5]) for line in said if line.startswith("# stock for the blocks"))
    assert f"# cost without base boards: {blocks * 2 + 4 * 1.5:.2f}" in said


@pytest.mark.parametrize(
    ("stock_cm", "chunk_size", "least"), [(100, 10, "122.05"), (240, 30, "322.05"), (121.9, 10, "122.05")]
)
def test_boards_longer_than_the_stock_are_said_as_in_the_pdf(stock_cm: float, chunk_size: int, least: str) -> None:
    scene = compose(Recipe(seed=1, chunk_size=chunk_size, obstacles=BLOCKS))
    settings = CutSettings(stock_cm=stock_cm, price=2)
    said = sheet(scene, settings, "csv").decode().splitlines()
    short = f"{stock_cm:g} cm of stock is too short for them: give {least} cm or more (--stock-cm)"
    assert f"# stock for the frames: {short}" in said
    assert "# cost of the frames: the stock is too short" in said
    blocks = next(int(line.split()[5]) for line in said if line.startswith("# stock for the blocks"))
    assert f"# cost of the blocks: {blocks * 2:.2f}" in said
    assert not [line for line in said if line.startswith(("# saw for frames", "# cost without"))]
    longer = sheet(scene, CutSettings(stock_cm=float(least), price=2), "csv").decode()
    assert "# saw for frames: 2 pieces into 1 x " in longer


@pytest.mark.parametrize("blocks", [1, 2])
def test_one_is_no_plural(blocks: int) -> None:
    row = " ".join(["1"] * blocks)
    recipe = Recipe(
        seed=1, chunk_size=1, chunks=(blocks, 1), boundary="none", obstacles=[Matrix(levels=2, rows=(row,))]
    )
    lines = text_of(recipe).splitlines()
    assert ("# cut: 1 block of 10 cm" if blocks == 1 else "# cut: 2 blocks of 10 cm") in lines
    assert f"# saw: 1 piece into {blocks} x 10 cm" in lines
    assert [line for line in lines if line.startswith("# stock for the blocks: 1 piece of 240 cm")]


def as_a_spreadsheet_saves(text: str) -> str:
    """With semicolons, decimal commas, quotes round texts, and every line as long as the longest."""
    lines = []
    for line in text.splitlines():
        first, *others = [line] if line.startswith("#") else line.split(",")
        blank = [""] * (4 - len(others))
        lines.append(";".join([f'"{first}"', *(cell.replace(".", ",") for cell in others), *blank]))
    return "\ufeff" + "\r\n".join([*lines, ";;;;", ""])


def test_a_sheet_is_read_as_a_spreadsheet_saves_it(tmp_path: Path) -> None:
    recipe = Recipe(seed=3, chunk_size=3, unit_cm=2.5, boundary="outer", obstacles=BLOCKS)
    path = tmp_path / "sheet.csv"
    path.write_bytes(as_a_spreadsheet_saves(text_of(recipe)).encode())
    assert build(imported(path, Table())) == build(recipe)


def test_rows_may_stand_in_any_order(tmp_path: Path) -> None:
    head, _, rows = text_of(RECIPE).partition("height_cm\n")
    mixed = head + "height_cm\n" + "".join(sorted(rows.splitlines(keepends=True), reverse=True))
    assert build(imported(written(tmp_path, mixed), Table())) == build(RECIPE)


def test_a_list_without_comments_is_a_map_without_frames(tmp_path: Path) -> None:
    recipe = imported(written(tmp_path, "pallet,order,x,y,height_cm\nA1,1,0,0,20\nA1,,1,0,0\n"), Table())
    assert (recipe.boundary, recipe.unit_cm, build(recipe).levels.tolist()) == ("none", 10, [[2], [0]])


HEAD = "pallet,order,x,y,height_cm\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD, "no cell below the header"),
        (HEAD + "A1,1,0,0,20\nA1,1,0,0,10\n", "line 3: duplicate cell x 0, y 0"),
        (HEAD + "A1,1,1,1,20\n", "the cell x 0, y 0 of 2 x 2 is missing"),
        (HEAD + "A1,1,9999999,9999999,20\n", "the cell x 0, y 0 of 10000000 x 10000000 is missing"),
        (HEAD + "A1,1,-1,0,20\n", "line 2: x '-1' is not the number of a cell"),
        (HEAD + "A1,1,0,,20\n", "line 2: y '' is not the number of a cell"),
        (HEAD + "A1,1,0,0,tall\n", "line 2: height_cm 'tall' is not a number"),
        (HEAD + "A1,1,0,0\n", "line 2: 4 cells, 5 in the header"),
        (HEAD + "A1,1,0,0,12\n", "12 cm is not 0..32766 whole units of 10 cm"),
        (HEAD + "A1,1,0,0,nan\n", "nan cm is a hole"),
        ("# unit_cm: 0\n" + HEAD + "A1,1,0,0,10\n", r"unit_cm: 0\.0 is outside 0\.001\.\.100000 cm"),
        ("# boundary: round\n" + HEAD + "A1,1,0,0,10\n", "boundary: 'round' is not one of none, divided, outer"),
        (HEAD + "A1,1,0,0,10\n" * 1_000_001, r"1,000,001 rows; up to 1,000,000"),
    ],
    ids=lambda text: text[:60].replace("\n", " "),
)
def test_an_invalid_sheet_is_refused_with_its_place(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(FileError, match=said) as refused:
        imported(written(tmp_path, text), Table())
    assert "\n" not in str(refused.value)


def test_a_sheet_explains_its_numbers(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="is a build sheet, whose heights are in cm"):
        imported(written(tmp_path, text_of(RECIPE)), Table(values="m"))


def test_another_unit_and_chunk_size_may_be_asked_for(tmp_path: Path) -> None:
    again = imported(written(tmp_path, text_of(RECIPE)), Table(), unit_cm=5, chunk_size=1)
    assert (again.unit_cm, again.chunks) == (5, (4, 2))
    assert np.array_equal(build(again).blocks, 2 * build(RECIPE).blocks)


@pytest.mark.parametrize(("chunk_size", "block_width_cm"), [(10, 10.0), (7, 4.5), (30, 10.0), (23, 3.3)])
def test_the_stock_that_boards_are_said_to_need_in_inches_is_long_enough(
    chunk_size: int, block_width_cm: float
) -> None:
    recipe = Recipe(
        seed=1, units="in", chunk_size=chunk_size, block_width_cm=block_width_cm, unit_cm=1, obstacles=BLOCKS
    )
    saw, advice = CutSettings(stock_cm=20, kerf_mm=3.175, trim_cm=1.27, tolerance_mm=0.79375), r"give (.*) or more"
    said = sheet(compose(recipe), saw, "csv").decode()
    (least,) = re.findall(advice, said)
    inches = sum(Fraction(part) for part in least.removesuffix(" in").split())
    longer = replace(saw, stock_cm=float(inches) * 2.54)
    assert "# saw for frames: " in sheet(compose(recipe), longer, "csv").decode()
    mark = replace(saw, stock_cm=float(inches - Fraction(1, 32)) * 2.54)
    assert re.search(advice, sheet(compose(recipe), mark, "csv").decode())


def test_the_stock_that_blocks_are_said_to_need_in_inches_is_long_enough(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["sheet", "peak", "--units", "in", "-o", str(tmp_path / "peak.csv"), "--stock-cm"]
    assert main([*command, "16in"]) == 2
    said = capsys.readouterr().err
    assert "--stock-cm: 16 in is too short for blocks of the highest level, 15 3/4 in; use 16 25/32 in or more" in said
    assert main([*command, "16 25/32 in"]) == 0
    assert (tmp_path / "peak.csv").is_file()
