"""`rsegen metrics`, as people and programs use it; what they do wrong is in tests/bad_input."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import rsegen
from rsegen import Matrix, Recipe, StepLimits
from rsegen.cli.edge import main
from rsegen.field.traversability import traversability
from rsegen.measuring import plots
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots.base import ROBOTS

PALLET = EXAMPLES["red-diagonal-pallet"]
TEN = ["--climb-cm", "10"]


@pytest.fixture
def maps(tmp_path: Path) -> Path:
    """A folder of three maps."""
    flags = ["--maps", "3", "--seed", "7", "--obstacle", "random levels=3"]
    assert main(["generate", *flags, "-o", str(tmp_path / "maps")]) == 0
    return tmp_path / "maps"


def printed(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """Output of a command that succeeds; it says nothing on stderr."""
    capsys.readouterr()
    assert main(["metrics", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def test_a_page_tells_of_the_pallet_in_centimetres(capsys: pytest.CaptureFixture[str]) -> None:
    page = printed(capsys, PALLET, *TEN)
    for words in ("mean 19.6 cm", "0.568 of the mean", "rms 13.02 cm", "Hurst exponent 0.17; weak, of 5 lags"):
        assert words in page
    for words in ("TRI 13.08 cm (root mean square)", "3.03 times the plan", "96.0%"):
        assert words in page
    assert "climb    needed to cross for its width: 10 cm west to east" in page
    assert max(map(len, page.splitlines())) <= 120


def test_a_page_stays_short_for_any_steps(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "many.yaml"
    path.write_text("unit_cm: 0.1\nseed: 1\nobstacles:\n  - {kind: random, levels: 500}\n")
    page = printed(capsys, path)
    assert "sizes, which --json lists" in page
    assert len(page.splitlines()) < 18


def test_a_single_block_has_no_neighbour(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "post.yaml"
    path.write_text("{chunk_size: 1, boundary: none, seed: 1, obstacles: [{kind: matrix, rows: ['2']}]}")
    blocks, rough, climb, *_ = printed(capsys, path).splitlines()
    assert blocks == "rse_0000, seed 1: 1 block of 10 x 10 cm; frames are not blocks"
    assert rough == "Blocks are 20 to 20 cm high; none has a neighbour."
    assert climb == "To cross it, a robot must climb steps of 20 cm west to east and 20 cm south to north."


LOW = ("--obstacle", "random levels=2", "--unit-cm", "1", "--boundary", "none", "--seed", "1")


def test_a_page_begins_with_what_a_person_came_for(capsys: pytest.CaptureFixture[str]) -> None:
    """First the roughness of the map, or whether the robot gets across; then an empty line, and all figures."""
    _, rough, climb, empty, *_ = printed(capsys, "peak").splitlines()
    assert rough == "Blocks are 0 to 40 cm high; neighbours differ by 5.33 cm on average, by 40 cm at most."
    assert climb == "To cross it, a robot must climb steps of 10 cm west to east and 10 cm south to north."
    assert empty == ""
    _, across, surely, empty, *_ = printed(capsys, *LOW, "--robot", "crawler").splitlines()
    assert across == "Predicted: the crawler can cross west to east and south to north."
    assert surely == "To see how surely, drive it: add --verify, or use rsegen predict."
    assert empty == ""
    _, west, south, *_ = printed(capsys, "peak", "--robot", "burger").splitlines()
    assert west.startswith("Predicted: the burger cannot cross west to east: it ")
    assert south.startswith("Predicted: the burger cannot cross south to north: it ")


def test_a_page_tells_how_many_steps_can_be_climbed(capsys: pytest.CaptureFixture[str]) -> None:
    field = rsegen.build(rsegen.load(PALLET))
    steps = np.abs(np.concatenate([np.diff(field.blocks, axis=axis).ravel() for axis in (0, 1)])) * field.unit
    climbed, descended = ((steps < limit + 1e-9).mean() for limit in (0.1, 0.2))
    page = printed(capsys, PALLET, "--climb-cm", "10", "--drop-cm", "20")
    assert 0 < climbed < descended
    assert f"\nsteps    {climbed:.1%} can be climbed, {descended:.1%} can be descended\n" in page


def test_names_of_nist_are_used_for_analogues_only(capsys: pytest.CaptureFixture[str]) -> None:
    page = printed(capsys, PALLET, *TEN)
    for name in ("coverability", "crossability"):
        assert page.count(name) == page.count(f"analogue of {name}") == 1


def test_a_folder_of_maps_is_a_table_with_a_line_for_each(capsys: pytest.CaptureFixture[str], maps: Path) -> None:
    lines = printed(capsys, maps).splitlines()
    assert [line.split()[0] for line in lines[2:5]] == ["rse_0000", "rse_0001", "rse_0002"]
    assert len({len(line) for line in lines[:5]}) == 1 > len(lines[0]) // 120
    assert lines[1].split() == [*["cm"] * 7, "x"]
    heads, units, *_ = printed(capsys, maps, *TEN).splitlines()
    assert heads.split()[-5:] == ["region", "way", "w-e", "way", "s-n"]
    assert units.split()[-3:] == ["%", "x", "x"]


@pytest.mark.long(reason="the table itself in make test")
def test_below_a_table_its_heads_are_explained(capsys: pytest.CaptureFixture[str], maps: Path) -> None:
    table, _, legend = printed(capsys, maps, *TEN).partition("\n\n")
    explained = legend.replace(",", "").replace(":", "").split()
    assert [word for word in table.splitlines()[0].split()[1:] if word not in explained] == []
    assert "terrain ruggedness index" in legend


def test_below_a_table_is_how_many_maps_can_be_crossed(
    capsys: pytest.CaptureFixture[str], maps: Path, tmp_path: Path
) -> None:
    """For a robot and for limits of steps; without either there is no such line, and no head that is not there."""
    small = tmp_path / "small.yaml"
    small.write_text("{maps: 3, seed: 7, chunk_size: 5, obstacles: [{kind: random, levels: 3}]}")
    _, below, legend = printed(capsys, small, "--robot", "burger").split("\n\n")
    assert below.splitlines() == [
        "Predicted: of 3 maps, the burger can cross 0 west to east and 0 south to north.",
        "To see how surely, drive it: add --verify, or use rsegen predict.",
    ]
    assert "way w-e" in legend
    assert "p w-e" not in legend
    _, below, _ = printed(capsys, maps, "--climb-cm", "40").split("\n\n")
    path = "a path of steps of up to 40 cm up and 40 cm down"
    assert below == f"Predicted: of 3 maps, {path} leads across 3 west to east and 3 south to north."
    level = tmp_path / "level.yaml"
    level.write_text(
        "{maps: 2, seed: 7, chunk_size: 6, boundary: none, unit_cm: 1, obstacles: [{kind: random, levels: 2}]}"
    )
    _, below, _ = printed(capsys, level, "--robot", "crawler").split("\n\n")
    assert below.startswith("Predicted: of 2 maps, the crawler can cross 2 west to east and 2 south to north.\n")
    assert "Predicted" not in printed(capsys, maps)


def test_in_a_table_a_map_without_a_way_has_empty_cells(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "walls.yaml"
    path.write_text("{maps: 2, seed: 7, obstacles: [{kind: random, levels: 9}]}")
    heads, _, row, *_ = printed(capsys, path, "--climb-cm", "1").splitlines()
    assert row[heads.index("way w-e") :].strip() == ""
    assert "none" not in row


def test_a_later_map_that_cannot_be_read_ends_the_command_with_quiet_too(
    capsys: pytest.CaptureFixture[str], maps: Path
) -> None:
    (maps / "rse_0002" / "recipe.json").write_text("{")
    for quiet in ([], ["--quiet"]):
        assert main(["metrics", str(maps), *quiet]) == 2
        out, err = capsys.readouterr()
        assert "rse_0002" in err
        assert bool(out) != bool(quiet)


def test_one_of_many_is_a_page(capsys: pytest.CaptureFixture[str], maps: Path) -> None:
    page = printed(capsys, maps, "--map", "1")
    assert page.startswith("rse_0001, seed 7: ")
    assert page == printed(capsys, maps / "rse_0001")


def test_a_recipe_and_its_maps_have_the_same_metrics(capsys: pytest.CaptureFixture[str], maps: Path) -> None:
    recipe = maps.parent / "three.yaml"
    recipe.write_text("maps: 3\nseed: 7\nobstacles:\n  - {kind: random, levels: 3}\n")
    assert printed(capsys, recipe, "--csv", *TEN) == printed(capsys, maps, "--csv", *TEN)


def test_json_and_csv_equal_the_values_of_python(capsys: pytest.CaptureFixture[str], maps: Path) -> None:
    expected = rsegen.metrics(
        rsegen.compose(rsegen.load(maps / "rse_0002" / "recipe.json"), 2).field, StepLimits(climb_cm=10)
    )
    told = json.loads(printed(capsys, maps, "--json", *TEN))
    rows = list(csv.DictReader(io.StringIO(printed(capsys, maps, "--csv", *TEN))))
    assert [one["map"] for one in told] == [one["map"] for one in rows] == ["rse_0000", "rse_0001", "rse_0002"]
    assert told[2]["steps"]["mean"] == float(rows[2]["steps.mean"]) == pytest.approx(expected.steps.mean)
    assert expected.reach is not None
    assert told[2]["reach"]["coverage"] == float(rows[2]["reach.coverage"]) == pytest.approx(expected.reach.coverage)
    assert {
        int(level): count for level, count in told[2]["spread"]["level_counts"].items()
    } == expected.spread.level_counts


@pytest.mark.parametrize("levels", [(0, 9), (9, 0)], ids=["first", "last"])
def test_maps_with_and_without_a_way_have_the_same_columns(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, levels: tuple[int, int]
) -> None:
    for name, level in zip("ab", levels, strict=True):
        wall = Recipe(
            name=name,
            seed=1,
            chunk_size=4,
            unit_cm=1,
            boundary="none",
            obstacles=[Matrix(rows=(f"{level} 0 0 {level}",) * 4)],
        )
        rsegen.generate(wall, tmp_path)
    rows = list(csv.DictReader(io.StringIO(printed(capsys, tmp_path, "--robot", "burger", "--csv"))))
    crosses = {row["map"]: row["reach.west_east.crosses"] for row in rows}
    assert crosses == {f"{name}_0000": str(level == 0) for name, level in zip("ab", levels, strict=True)}
    assert all(None not in row and None not in row.values() for row in rows)
    lengths = {row["map"]: row["reach.west_east.length"] != "" for row in rows}
    assert lengths == {name: said == "True" for name, said in crosses.items()}


@pytest.mark.slow
def test_a_robot_is_measured_by_its_poses_whether_it_is_a_kind_or_a_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "jackal.sdf"
    file.write_text(ROBOTS["jackal"].file("jackal"))
    path = tmp_path / "small.yaml"
    path.write_text("{chunk_size: 5, boundary: none, unit_cm: 1, seed: 7, obstacles: [{kind: random, levels: 4}]}")
    found = rsegen.metrics(rsegen.build(rsegen.load(path)), ROBOTS["jackal"]).reach
    assert max(map(len, printed(capsys, path, "--robot", "jackal").splitlines())) <= 120
    for robot in ("jackal", file):
        reach = json.loads(printed(capsys, path, "--json", "--robot", robot))[0]["reach"]
        assert reach["coverage"] == pytest.approx(found.coverage, abs=0.05)  # it rocks on two of its four wheels
        assert reach["west_east"]["crosses"] == found.west_east.crosses


@pytest.mark.long(reason="tests/standing/test_pose_plots.py draws poses")
def test_poses_at_a_heading_are_drawn(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "poses.png"
    printed(capsys, PALLET, "--robot", "jackal", "--heading", "45", "-o", path)
    with Image.open(path) as picture:
        assert picture.size[0] > 1000
    for flags, message in (
        (("--climb-cm", "5", "-o", path, "--force"), "--heading: limits of steps have no poses; use --robot"),
        (("--robot", "jackal"), "--heading: is for a picture; use -o too"),
    ):
        assert main(["metrics", str(PALLET), "--heading", "45", *map(str, flags)]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.parametrize("flags", [[], ["--climb-cm", "5"]])
def test_only_robots_are_driven(flags: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["metrics", str(PALLET), "--verify", *flags]) == 2
    assert "--verify: drives a robot; choose one, as in --robot burger" in capsys.readouterr().err


def test_limits_of_steps_are_no_robot(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["metrics", str(PALLET), "--robot", "burger", "--climb-cm", "10"]) == 2
    assert "--climb-cm: excludes --robot" in capsys.readouterr().err


def test_without_a_robot_the_report_names_none(capsys: pytest.CaptureFixture[str]) -> None:
    (told,) = json.loads(printed(capsys, PALLET, "--json"))
    assert set(told) == {"map", "seed", "spread", "steps", "plane", "scale", "spectrum", "ruggedness", "opening"}


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_a_picture_is_written(capsys: pytest.CaptureFixture[str], tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"ways.{suffix}"
    printed(capsys, PALLET, *TEN, "-o", path)
    assert path.stat().st_size > 10_000


@pytest.mark.parametrize("climb_cm", [0, 10, 1000])
def test_a_picture_shows_existing_paths(climb_cm: float) -> None:
    """A robot that gets nowhere has a picture too."""
    scene = rsegen.compose(rsegen.load(PALLET))
    found = traversability(scene.field, StepLimits(climb_cm=climb_cm))
    pixels = Image.open(io.BytesIO(plots.path_plot(scene, found, "a path"))).convert("RGB")
    assert pixels.size == (1400, 700)
    heat = pixels.crop((700, 100, 1300, 600)).getcolors(2**24)
    assert heat is not None
    coloured = sum(count for count, colour in heat if isinstance(colour, tuple) and math.dist(colour, (68, 1, 84)) < 60)
    assert (coloured > 1000) == found.west_east.crosses


def test_a_picture_shows_ways_in_the_cells_that_they_go_through(monkeypatch: pytest.MonkeyPatch) -> None:
    figures: list[Figure] = []
    monkeypatch.setattr(plots, "figure_bytes", lambda figure, *_: figures.append(figure))
    scene = rsegen.compose(rsegen.Recipe(chunks=(2, 1), chunk_size=4, boundary="none", seed=1))
    plots.path_plot(scene, traversability(scene.field, StepLimits(climb_cm=10)), "a path")
    drawn = {str(line.get_label()).partition(":")[0]: np.array(line.get_xydata()) for line in figures[0].axes[0].lines}
    assert drawn["west to east"][[0, -1], 0] == pytest.approx([-0.45, 0.45])  # from the ground next to it
    assert drawn["south to north"][[0, -1], 1] == pytest.approx([-0.25, 0.25])


@pytest.mark.slow
def test_the_search_of_a_robot_has_progress(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "small.yaml"
    path.write_text("{chunk_size: 5, boundary: none, unit_cm: 2, seed: 7, obstacles: [{kind: random, levels: 3}]}")
    assert main(["metrics", str(path), "--robot", "jackal", "--progress", "json"]) == 0
    said = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    done = [each["done"] for each in said]
    assert done == sorted(done)
    assert (done[0], done[-1], said[-1]["total"], said[-1]["unit"]) == (0, 100, 100, "%")
