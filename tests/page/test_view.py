"""`rsegen view`: a file, or one line that says why not."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.page import browser
from rsegen.pictures.plan import ramp
from rsegen.recipe.examples import EXAMPLES
from tests.page.browser.pages import maps_of
from tests.support.complaints import OBSTACLE, exit_code, the_line

Capture = pytest.CaptureFixture[str]


def test_all_maps_of_a_recipe_are_on_the_page_or_the_one_that_is_named(tmp_path: Path, capsys: Capture) -> None:
    for flags, names in (
        ((), ["mixed-course_0000", "mixed-course_0001", "mixed-course_0002"]),
        (("--map", "2"), ["mixed-course_0002"]),
    ):
        path = tmp_path / f"{len(names)}.html"
        assert main(["view", "mixed-course", "-o", str(path), *flags]) == 0
        assert [shown["name"] for shown in maps_of(path.read_bytes())] == names
        assert f"{path}: " in capsys.readouterr().out


def test_the_page_is_not_in_what_a_shell_of_python_prints_of_a_view() -> None:
    assert len(repr(rsegen.view(rsegen.load(EXAMPLES["peak"])))) < 100


def test_a_folder_and_flags_are_maps_too(tmp_path: Path, capsys: Capture) -> None:
    rsegen.generate(rsegen.load(EXAMPLES["peak"]), tmp_path)
    for number, target in enumerate(([str(tmp_path / "peak_0000")], OBSTACLE)):
        path = tmp_path / f"{number}.html"
        assert main(["view", *target, "-o", str(path)]) == 0
        assert len(maps_of(path.read_bytes())) == 1
    assert "rse_0000, seed 7" in capsys.readouterr().out


def test_a_file_that_exists_is_replaced_on_request_only(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "map.html"
    path.write_text("mine")
    assert exit_code("view", "peak", "-o", path) == 2
    assert "--force" in the_line(capsys.readouterr().err)
    assert path.read_text() == "mine"
    assert exit_code("view", "peak", "-o", path, "--force") == 0
    assert len(maps_of(path.read_bytes())) == 1
    path.unlink()
    for flags in ([], ["--force"]):
        assert exit_code("view", "peak", "-o", path, *flags) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["peak", "-o", "map.png"], "map.png: a page must be an .html file"),
        ([*OBSTACLE, "--chunk-size", "1000", "--chunks", "2", "-o", "map.html"], "2004 x 2004 cells are too many"),
        (
            [*OBSTACLE, "--maps", "1000000000", "-o", "map.html"],
            "1,000,000,000 maps are too many for a page, which holds up to 1000",
        ),
        ([*OBSTACLE, "--chunk-size", "900", "--maps", "9", "-o", "map.html"], "9 maps have 7,322,436 cells"),
    ],
)
def test_a_page_too_large_for_browsers_is_refused_before_it_is_made(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    assert exit_code("view", *arguments) == 2
    assert said in the_line(capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_largest_map_is_written(tmp_path: Path) -> None:
    path = tmp_path / "map.html"
    flags = ["--chunk-size", "100", "--chunks", "10", "--boundary", "outer", "-o", str(path)]
    assert main(["view", *OBSTACLE, *flags]) == 0
    assert maps_of(path.read_bytes())[0]["cells"] == [1002, 1002]


def test_tilt_has_the_colours_of_pictures() -> None:
    source = (Path(browser.__file__).parent / "app" / "overlay.ts").read_text()
    (colours,) = re.findall(r"RAMP = (\[\[.*?\]\])", source)
    stops = np.array(re.findall(r"\d+", colours), dtype=float).reshape(-1, 3) / 255
    assert ramp()(np.linspace(0, 1, len(stops)))[:, :3] == pytest.approx(stops, abs=0.01)
