"""Inches: said of every length, on build sheets and back."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from rsegen import Random, Recipe, StepLimits, build, load
from rsegen.cli.edge import main
from rsegen.pictures.preview import preview_figure
from rsegen.scene.scene import compose
from tests.support.complaints import the_line

POSTS = ["--unit-cm", "3.5in", "--block-width-cm", "3.5in", "--frame-height-cm", "3.5in"]
INCHES = ["red-diagonal-pallet", "--units", "in", *POSTS]


def test_a_sheet_in_inches_is_cut_from_8_feet(tmp_path: Path) -> None:
    assert main(["sheet", *INCHES, "-o", str(tmp_path / "sheet.csv")]) == 0
    lines = (tmp_path / "sheet.csv").read_text("utf-8").splitlines()
    assert "# cut: 27 blocks of 3 1/2 in" in lines
    assert "# cut: 10 blocks of 14 in" in lines
    assert "# stock for the blocks: 8 pieces of 8 ft less 1/8 in per cut + 1/32 in per part and 1 in of ends" in lines
    assert "# frames: 2 boards of 42 in" in lines
    assert "pallet,order,x,y,height_in" in lines
    assert "A1,8,9,9,14" in lines


def test_a_sheet_in_inches_makes_the_map_again(tmp_path: Path) -> None:
    assert main(["sheet", *INCHES, "-o", str(tmp_path / "sheet.csv")]) == 0
    assert main(["import", str(tmp_path / "sheet.csv"), "-o", str(tmp_path)]) == 0
    again = load(tmp_path / "sheet_0000" / "recipe.json")
    assert (again.units, again.unit_cm, again.block_width_cm, again.frame_height_cm) == ("in", 8.89, 8.89, 8.89)
    assert main(["generate", *INCHES, "-o", str(tmp_path)]) == 0
    assert build(again) == build(load(tmp_path / "red-diagonal-pallet_0000" / "recipe.json"))


def test_stock_and_kerf_may_be_of_any_unit(tmp_path: Path) -> None:
    flags = ["--stock-cm", "10ft", "--kerf-mm", "0.1in", "--tolerance-mm", "0mm", "-o", str(tmp_path / "sheet.csv")]
    assert main(["sheet", *INCHES, *flags]) == 0
    assert "pieces of 10 ft less 0.1 in per cut + 0 in per part and 1 in of ends" in (tmp_path / "sheet.csv").read_text(
        "utf-8"
    )


def test_pages_in_inches_have_no_centimetres(tmp_path: Path) -> None:
    from rsegen import CutSettings, compose
    from rsegen.build_sheets.document import pages

    assert main(["generate", *INCHES, "-o", str(tmp_path)]) == 0
    scene = compose(load(tmp_path / "red-diagonal-pallet_0000" / "recipe.json"))
    for page in pages(scene, CutSettings.default("in")):
        texts = [text.get_text() for axes in page.axes for text in axes.texts]
        assert texts
        assert not [text for text in texts if re.search(r"\d (cm|mm|m)\b|in cm|\d kg$", text)]


@pytest.mark.slow
def test_a_sheet_in_inches_is_on_letter_with_fractions_and_names_of_lumber(tmp_path: Path) -> None:
    pypdf = pytest.importorskip("pypdf")
    words = ["--kerf-mm", "1/8in", "--price", "12.50", "-o", str(tmp_path / "sheet.pdf")]
    assert main(["sheet", *INCHES, *words]) == 0
    first, pallet, materials, form = pypdf.PdfReader(tmp_path / "sheet.pdf").pages
    for page in (first, pallet, materials, form):
        assert [float(side) for side in page.mediabox[2:]] == pytest.approx([8.5 * 72, 11 * 72], abs=0.02)
    texts = [" ".join(page.extract_text().split()) for page in (first, pallet, materials)]
    for said in (
        "8 ft of 3 1/2 x 3 1/2 in",
        "sold as 4x4",
        "lost: 1/8 in per cut + 1/32 in per part",
        "6 x 14 + 1 x 7 2 29/32 left",
    ):
        assert said in texts[0]
    assert texts[1].count("10 1/2") == 21 + 1  # blocks, and the line of their level
    for said in ("of 31 lb/ft3", "blocks: 8 x 12.50 100.00", "frames: 2 x 12.50 25.00", "base boards 125.00"):
        assert said in texts[2]


def test_heights_in_inches_are_imported(tmp_path: Path) -> None:
    (tmp_path / "heights.csv").write_text("0,3.5\n14,7\n", "utf-8")
    words = ["import", str(tmp_path / "heights.csv"), "-o", str(tmp_path), "--units", "in", "--unit-cm", "3.5in"]
    assert main(words) == 0
    recipe = load(tmp_path / "heights_0000" / "recipe.json")
    assert build(recipe).levels.tolist() == [[4, 0], [2, 1]]
    assert (recipe.units, recipe.unit_cm) == ("in", 8.89)


def test_an_inventory_in_inches(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "blocks.csv").write_text("height_in,count\n3.5,2\n14,1\n", "utf-8")
    words = ["--obstacle", "random levels=5", "--seed", "1", "--units", "in", "--unit-cm", "3.5in"]
    words += ["--inventory", str(tmp_path / "blocks.csv"), "-o", str(tmp_path)]
    assert main(["generate", *words]) == 0
    assert load(tmp_path / "rse_0000" / "recipe.json").inventory == (2, 0, 0, 1)
    assert " of 10.5 in" in capsys.readouterr().out


def test_a_number_without_a_unit_is_refused_with_inches(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["generate", "peak", "--units", "in", "--unit-cm", "3.5", "-o", str(tmp_path / "out")]
    assert main(words) == 2
    assert "--unit-cm: '3.5' has no unit; with units in write 3.5in or 3.5cm" in the_line(capsys.readouterr().err)
    assert not (tmp_path / "out").exists()


def test_info_is_in_the_units_of_the_recipe(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", *INCHES]) == 0
    said = capsys.readouterr().out
    assert "blocks   100 in levels of 3.5 in" in said
    assert "  level   4       14 in         10   10.0%" in said


def words(figure: Figure) -> str:
    """Return all texts of a figure, one per line."""
    return "\n".join(text.get_text() for text in figure.findobj(Text))


def test_pictures_are_in_the_units_of_the_recipe() -> None:
    posts = Recipe(seed=1, units="in", unit_cm=8.89, block_width_cm=8.89, obstacles=[Random(levels=4)])
    inches, metric = (words(preview_figure(compose(recipe), "")) for recipe in (posts, replace(posts, units="cm")))
    assert "plan, heights in inches" in inches
    assert "10.5 in" in inches
    assert "cm" not in inches
    assert "plan, heights in cm" in metric
    assert "26.67 cm" in metric
    assert StepLimits(climb_cm=8.89).in_words("in") == "a path of steps of up to 3.5 in up and 3.5 in down"
    assert StepLimits(climb_cm=7).in_words("cm") == "a path of steps of up to 7 cm up and 7 cm down"
