"""A series: maps of difficulty that rises evenly, with a table and a picture."""

from __future__ import annotations

import csv
import io
import json
import shutil
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import rsegen
from rsegen import Random, Recipe, StepLimits, build, load, metrics, series
from rsegen.cli.edge import main
from rsegen.datasets.series_rows import SeriesPlan, SeriesRow
from rsegen.errors import OutputError, ParameterError
from rsegen.input_files import JOURNAL
from rsegen.measuring.catalogue import metric_by
from rsegen.recipe.codec import decode
from rsegen.writing import execute as execute_module
from tests.cli.test_cli import contents, printed, read

RANDOM = Recipe(name="rough", seed=7, maps=8, obstacles=(Random(levels=5),))
FLAGS = ["--obstacle", "random levels=5", "--seed", "7", "--maps", "8", "--name", "rough"]


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(path.read_text("utf-8"))))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> rsegen.Series:
    return series(RANDOM, tmp_path_factory.mktemp("series") / "out")


def test_every_map_is_a_world_with_its_own_recipe(made: rsegen.Series) -> None:
    names = [f"rough_{number:04d}" for number in range(8)]
    assert [row.map for row in made.rows] == names
    assert sorted(path.name for path in made.folder.iterdir()) == [JOURNAL, *names, "series.csv", "series.png"]
    for row in made.rows:
        home = made.folder / row.map
        assert (home / f"{row.map}.world").is_file()
        assert load(home / "recipe.json").difficulty == row.recipe_difficulty


def test_a_map_of_a_series_can_be_made_again_alone(made: rsegen.Series, tmp_path: Path) -> None:
    home = made.folder / "rough_0005"
    rsegen.generate(load(home / "recipe.json"), tmp_path)
    assert contents(tmp_path / "rough_0005") == contents(home)


def test_difficulty_rises_in_equal_steps_from_first_to_last(made: rsegen.Series) -> None:
    difficulties = [row.difficulty for row in made.rows]
    assert (difficulties[0], difficulties[-1]) == (0.1, 1)
    np.testing.assert_allclose(np.diff(difficulties), 0.9 / 7, atol=1e-6)


def test_targets_rise_linearly_to_the_mean_of_the_fields(made: rsegen.Series) -> None:
    mean = np.mean([metrics(build(RANDOM, index)).steps.rms for index in range(8)])
    for row in made.rows:
        assert row.rms_asked == pytest.approx(row.difficulty * mean)


def test_maps_reach_the_difficulty_or_are_as_rough_as_their_fields(made: rsegen.Series) -> None:
    for row in made.rows:
        assert row.rms_asked
        assert row.rms_full
        assert row.rms == pytest.approx(min(row.rms_asked, row.rms_full), abs=0.004)


def test_the_table_equals_the_metrics_of_the_worlds_on_disk(
    made: rsegen.Series, capsys: pytest.CaptureFixture[str]
) -> None:
    measured = list(csv.DictReader(io.StringIO(printed(capsys, "metrics", made.folder, "--csv"))))
    table = rows_of(made.table)
    assert list(table[0]) == list(asdict(made.rows[0]))
    for here, there in zip(table, measured, strict=True):
        assert here["map"] == there["map"]
        assert float(here["rms"]) == float(there["steps.rms"])
        assert float(here["highest_step"]) == float(there["steps.highest"])
        assert float(here["opening_west_east"]) == float(there["opening.west_east"])
        assert float(here["opening_south_north"]) == float(there["opening.south_north"])
        assert float(here["mean_height"]) == float(there["spread.mean"])


def test_the_table_is_the_rows(made: rsegen.Series) -> None:
    told = [{name: str(value) for name, value in asdict(row).items()} for row in made.rows]
    assert rows_of(made.table) == told


def test_the_picture_carries_the_recipe(made: rsegen.Series) -> None:
    with Image.open(made.picture) as found:
        assert found.size == (1300, 740)
        assert decode(json.loads(found.info["Description"])) == RANDOM


def test_new_fields_equal_the_recipe_scaled_to_difficulty(made: rsegen.Series) -> None:
    for row in made.rows:
        expected = build(replace(RANDOM, difficulty=row.recipe_difficulty), row.number)
        assert expected == build(load(made.folder / row.map / "recipe.json"), row.number)


def test_one_field_rises_cell_by_cell(tmp_path: Path) -> None:
    found = series(RANDOM, tmp_path, maps=5, from_=0, to=1, same_field=True)
    assert [row.map for row in found.rows] == [f"rough-{number:04d}_0000" for number in range(5)]
    levels = [build(load(tmp_path / row.map / "recipe.json")).levels for row in found.rows]
    assert not levels[0].any()
    assert all((low <= high).all() for low, high in pairwise(levels))
    np.testing.assert_array_equal(levels[-1], build(RANDOM).levels)
    assert [row.recipe_difficulty for row in found.rows] == [0, 0.25, 0.5, 0.75, 1]


def test_first_map_counts(tmp_path: Path) -> None:
    later = replace(RANDOM, first_map=40, maps=2)
    assert [row.map for row in series(later, tmp_path / "new").rows] == ["rough_0040", "rough_0041"]
    same = series(later, tmp_path / "same", same_field=True)
    assert [row.map for row in same.rows] == ["rough-0000_0040", "rough-0001_0040"]


def test_maps_that_keep_to_constraints_follow_the_line_too(tmp_path: Path) -> None:
    found = series(replace(RANDOM, max_step=2, crossable_by=(20, 20, 10)), tmp_path)
    for row in found.rows:
        assert row.rms_asked
        assert row.rms_full
        assert row.rms == pytest.approx(min(row.rms_asked, row.rms_full), abs=0.01)
        assert row.highest_step
        assert row.highest_step <= 0.2


@pytest.mark.long(reason="tests/writing/test_execute.py has workers once for all commands")
@pytest.mark.slow
def test_workers_make_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    series(RANDOM, tmp_path / "1")
    monkeypatch.setattr(execute_module, "WORTHWHILE", 0.0)  # so few maps are shared out too
    series(RANDOM, tmp_path / "2", workers=2)
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


@pytest.mark.slow
@pytest.mark.parametrize(("same_field", "fields"), [(False, range(8)), (True, range(1))])
def test_workers_measure_the_fields_and_make_the_maps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, same_field: bool, fields: range
) -> None:
    shared = []

    @contextmanager
    def here(workers: int) -> Iterator[tuple[Callable[..., Future[object]], int, Callable[[], None]]]:
        shared.append(workers)
        with ThreadPoolExecutor(1) as executor:
            yield executor.submit, workers, lambda: None

    series(RANDOM, tmp_path / "1", same_field=same_field)
    monkeypatch.setattr(execute_module, "WORTHWHILE", 0.0)
    monkeypatch.setattr(execute_module, "_processes", here)
    series(RANDOM, tmp_path / "2", same_field=same_field, workers=2)
    assert len(shared) == sum(len(each) > 1 for each in (fields, range(8)))
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


@pytest.mark.slow
def test_a_series_that_was_stopped_goes_on(tmp_path: Path) -> None:
    def stop(row: SeriesRow) -> None:
        if row.number == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        series(RANDOM, tmp_path / "stopped", progress=stop)
    made = len(list((tmp_path / "stopped").iterdir()))
    assert made >= 4
    resumed = series(RANDOM, tmp_path / "stopped", resume=True)
    assert [one.index for one in resumed.maps] == list(range(made, 8))
    series(RANDOM, tmp_path / "whole")
    assert contents(tmp_path / "stopped") == contents(tmp_path / "whole")


def test_a_series_of_obstacles_at_random_places_goes_on(tmp_path: Path) -> None:
    wandering = Recipe(name="rough", seed=7, maps=3, obstacles=(Random(levels=3), rsegen.Peak(levels=5)))
    series(wandering, tmp_path / "stopped")
    shutil.rmtree(tmp_path / "stopped/rough_0001")
    assert [one.index for one in series(wandering, tmp_path / "stopped", resume=True).maps] == [1]
    series(wandering, tmp_path / "whole")
    assert contents(tmp_path / "stopped") == contents(tmp_path / "whole")


def test_resume_refuses_another_series_before_anything_is_written(made: rsegen.Series) -> None:
    before = contents(made.folder)
    with pytest.raises(OutputError, match="rough_0000: exists already and is not this map"):
        series(RANDOM, made.folder, from_=0.2, resume=True)
    assert contents(made.folder) == before


def test_fields_without_steps_have_none_in_the_table(tmp_path: Path) -> None:
    single = Recipe(seed=1, chunk_size=1, maps=3, obstacles=RANDOM.obstacles)
    found = series(single, tmp_path)
    assert [row.rms for row in found.rows] == [None] * 3
    assert [row["rms"] for row in rows_of(found.table)] == [""] * 3
    assert [row.recipe_difficulty for row in found.rows] == [0.1, 0.55, 1]


def test_level_ground_is_a_series_too(tmp_path: Path) -> None:
    found = series(Recipe(seed=1, maps=2), tmp_path)
    assert [row.rms for row in found.rows] == [0, 0]


FINE = replace(RANDOM, boundary="none", unit_cm=2, maps=4, obstacles=(Random(levels=20),))


@pytest.mark.slow
@pytest.mark.parametrize("same_field", [False, True])
@pytest.mark.parametrize("by", ["opening.west_east", "reach.west_east.cost"])
def test_a_series_rises_by_another_metric(tmp_path: Path, by: str, same_field: bool) -> None:
    robot = StepLimits(climb_cm=7)
    found = series(FINE, tmp_path, by=by, robot=robot, same_field=same_field)
    line = [row.asked or 0 for row in found.rows]
    np.testing.assert_allclose(np.diff(line), np.diff(line)[0], rtol=1e-5)
    metric = metric_by(by, robot)
    for row in found.rows:
        home = load(tmp_path / row.map / "recipe.json")
        assert row.measured == pytest.approx(metric(build(home, home.first_map)))
        assert row.asked
        assert row.full
        assert row.measured == pytest.approx(min(row.asked, row.full), abs=0.021 if by.startswith("open") else 0.3)
        assert (row.rms_asked, row.rms_full) == (None, None)
        assert row.rms == pytest.approx(metrics(build(home, home.first_map)).steps.rms)
    assert [row["rms_asked"] for row in rows_of(found.table)] == [""] * 4


def test_by_the_rms_step_both_columns_say_the_same(made: rsegen.Series) -> None:
    for row in made.rows:
        assert (row.asked, row.measured, row.full) == (row.rms_asked, row.rms, row.rms_full)


def test_a_function_is_called_here_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execute_module, "WORTHWHILE", 0.0)
    monkeypatch.setattr(execute_module, "_processes", lambda _: pytest.fail("workers were started"))
    found = series(FINE, tmp_path, by=lambda field: float(field.levels.max()), workers=8)
    assert [row.measured for row in found.rows] == pytest.approx([row.asked for row in found.rows], abs=0.51)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"by": "steps.rsm"}, "by: unknown metric 'steps.rsm'"),
        ({"by": "reach.coverage"}, "by: reach.coverage needs a robot; set robot too"),
        ({"by": "spread.lowest"}, "by: spread.lowest is 0 at difficulty 0 and at 1; choose a metric that changes"),
    ],
)
def test_a_metric_that_cannot_rise_is_refused(tmp_path: Path, given: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        series(FINE, tmp_path / "out", **given)
    assert not list(tmp_path.iterdir())


# The command.


@pytest.mark.slow
def test_the_command_takes_a_metric_and_limits_of_steps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flags = ["--obstacle", "random levels=20", "--unit-cm", "2", "--boundary", "none", "--seed", "7", "--name", "rough"]
    by = ["--maps", "4", "--by", "reach.west_east.cost"]
    told = printed(capsys, "series", *flags, *by, "--robot", "7,7,53", "-o", tmp_path / "shell")
    series(FINE, tmp_path / "python", by=by[-1], robot=StepLimits(climb_cm=7, width_cm=53))
    assert (tmp_path / "python" / "series.csv").read_bytes() == (tmp_path / "shell" / "series.csv").read_bytes()
    assert "difficulty       asked    measured     highest" in told


@pytest.mark.long(reason="poses of a robot on map after map")
def test_a_series_rises_by_the_tilt_of_a_robot(tmp_path: Path) -> None:
    small = replace(FINE, chunk_size=6, maps=2, obstacles=(Random(levels=5),))
    rows = series(small, tmp_path, by="reach.west_east.tilt", robot="jackal", from_=0.5, same_field=True).rows
    assert (rows[0].measured or 0) < (rows[1].measured or 0) < 0.4
    for row in rows:
        assert row.measured == pytest.approx(min(row.asked or 0, row.full or 0), abs=0.08)


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (("--by", "reach.coverage"), "by: reach.coverage needs a robot; set robot too"),
        (("--by", "cost"), "by: unknown metric 'cost'"),
        (("--robot", "crawler"), "robot: steps.rms does not depend on a robot; use --by reach.west_east.cost"),
        (("--robot", "burgr"), "--robot: unknown robot 'burgr'; did you mean 'burger'"),
        (
            ("--robot", "1,2,3,4"),
            "is not a kind of robot or a file of one, or steps up, down and a width in cm, as in 7,7,30",
        ),
        (("--robot", "7,x"), "--robot: 'x' is not a number"),
    ],
    ids=" ".join,
)
def test_an_unknown_metric_or_robot_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], flags: tuple[str, ...], message: str
) -> None:
    assert main(["series", *FLAGS, *flags, "-o", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_the_command_makes_the_same_bytes_as_python(tmp_path: Path, made: rsegen.Series) -> None:
    assert main(["series", *FLAGS, "-o", str(tmp_path)]) == 0
    assert contents(tmp_path) == contents(made.folder)


@pytest.mark.slow
def test_the_command_tells_how_it_rises(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flags = [*FLAGS, "--maps", "2", "--from", "0.5", "--same-field", "--preview"]
    out = printed(capsys, "series", *flags, "-o", tmp_path)
    assert f"2 maps in {tmp_path}, seed 7" in out
    for row in rows_of(tmp_path / "series.csv"):  # metres, and centimetres on the screen
        figures = [f"{100 * float(row[name]):.2f}" for name in ("rms_asked", "rms", "highest_step")]
        assert [row["map"], f"{float(row['difficulty']):g}", *figures] in [line.split() for line in out.splitlines()]
    assert str(tmp_path / "series.csv") in out
    assert (tmp_path / "rough-0000_0000" / "preview.png").is_file()


def test_a_long_series_has_some_rows_on_the_screen_and_counts_the_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = printed(capsys, "series", *FLAGS, "--maps", "30", "--chunk-size", "3", "-o", tmp_path)
    names = [line.split()[0] for line in out.splitlines() if line.lstrip().startswith("rough_")]
    assert names[0] < names[-1] == "rough_0029"
    assert 10 <= len(names) <= 13
    assert f"({30 - len(names)} rows between them are left out)" in out


def test_json_has_every_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = read(capsys, "series", *FLAGS, "-o", tmp_path)
    table: list[Any] = rows_of(tmp_path / "series.csv")
    assert [(one["map"], one["rms"]) for one in told["maps"]] == [(row["map"], float(row["rms"])) for row in table]
    assert Path(told["picture"]).is_file()


def test_stopping_a_series_prints_how_to_resume(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sys.modules["rsegen.datasets.series"], "world_output", stopped)
    assert main(["series", *FLAGS, "-o", str(tmp_path / "out")]) == 130
    assert f"stopped; nothing was changed in {tmp_path / 'out'}" in capsys.readouterr().err
    monkeypatch.undo()
    assert main(["series", *FLAGS, "--resume", "-o", str(tmp_path / "out")]) == 0


def test_a_resumed_series_keeps_the_formats_of_an_earlier_run(tmp_path: Path) -> None:
    assert main(["series", *FLAGS, "--formats", "heightmap", "-o", str(tmp_path / "a")]) == 0
    assert main(["series", *FLAGS, "--formats", "occupancy", "--resume", "-o", str(tmp_path / "a")]) == 0
    assert main(["series", *FLAGS, "--formats", "heightmap,occupancy", "-o", str(tmp_path / "b")]) == 0
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_force_replaces_a_series_and_spares_the_rest(tmp_path: Path) -> None:
    assert main(["series", *FLAGS, "-o", str(tmp_path)]) == 0
    (tmp_path / "notes.txt").write_text("mine")
    before = contents(tmp_path)
    assert main(["series", *FLAGS, "--to", "0.5", "--force", "-o", str(tmp_path)]) == 0
    after = contents(tmp_path)
    assert after.keys() == before.keys()
    assert after["notes.txt"] == b"mine"
    assert after["series.csv"] != before["series.csv"]


@pytest.mark.parametrize(
    ("given", "where"),
    [
        ({"from_": 0.5, "to": 0.2}, "from"),
        ({"from_": -0.1}, "from"),
        ({"to": float("nan")}, "to"),
        ({"same_field": 1}, "same_field"),
        ({"maps": 1}, "maps"),
        ({"maps": 0}, "maps"),
        ({"workers": 0}, "workers"),
        ({"force": True, "resume": True}, "resume"),
    ],
    ids=str,
)
def test_invalid_arguments_of_a_series_are_refused(tmp_path: Path, given: dict[str, Any], where: str) -> None:
    with pytest.raises(ParameterError) as refused:
        series(RANDOM, tmp_path / "out", **given)
    assert refused.value.where == where
    assert not list(tmp_path.iterdir())


def test_a_recipe_of_one_difficulty_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"difficulty: 0\.5 is for maps of one difficulty"):
        series(replace(RANDOM, difficulty=0.5), tmp_path)


def test_a_plan_says_its_names_without_building() -> None:
    for same_field in (False, True):
        plan = SeriesPlan(recipe=RANDOM, same_field=same_field)
        for number in range(8):
            recipe = plan.whole(number)
            assert plan.map_name(number) == recipe.map_name(recipe.first_map)


@pytest.mark.slow
@pytest.mark.long(reason="next to maps of generate in make test")
def test_sheets_and_formats_are_next_to_the_worlds_of_a_series(tmp_path: Path) -> None:
    words = ["series", "peak", "--maps", "2", "--sheet", "--formats", "heightmap", "--preview", "-o", str(tmp_path)]
    assert main(words) == 0
    for number in range(2):
        folder = tmp_path / f"peak_{number:04d}"
        names = {path.name for path in folder.iterdir()}
        assert {"sheet.pdf", "sheet.csv", "preview.png", "heightmap", "formats.json"} <= names
