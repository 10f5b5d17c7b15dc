"""Many drives: each is that of `rsegen drive` over its map, wherever it is simulated, and all are counted."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from scipy.stats import binomtest

import rsegen
from rsegen.cli.edge import main
from rsegen.driving import many
from rsegen.driving.many import ManyDrives, wilson
from rsegen.driving.recording import record_embedded
from rsegen.errors import OutputError, ParameterError, SimulatorFailed, Stopped, UserError
from rsegen.simulators.embedded import EMBEDDED
from rsegen.writing.execute import Execution, cores

pytestmark = pytest.mark.skipif(not EMBEDDED, reason="the capability mujoco is not here")
RUBBLE = rsegen.Recipe(name="rubble", seed=3, boundary="none", unit_cm=3, obstacles=[rsegen.Random(levels=3)])


@pytest.mark.slow
def test_each_drive_is_that_over_its_map_and_they_are_counted() -> None:
    told: list[int] = []
    result = rsegen.drive_many(RUBBLE, maps=2, robot="crawler", duration=8, progress=told.append)
    assert [row.map for row in result.drives] == [0, 1]
    assert sum(told) == 2
    for row in result.drives[1:]:
        given: dict[str, Any] = {"robot": "crawler", "duration": 8, "seed": row.seed, "predict": False}
        alone = rsegen.drive(replace(RUBBLE, maps=2), map=row.map, **given)
        (robot,) = alone.robots
        assert row.distance == robot.metrics.distance > 1.0
        assert row.crossed == robot.metrics.crossed
        assert row.climbed == robot.metrics.climbed > 0.0
    assert str(result) == "\n".join(result.report())
    assert result.counted == 2
    assert result.crossed == sum(row.crossed is not None for row in result.drives)


@pytest.mark.slow
def test_workers_drive_the_same() -> None:
    """And those of a cluster, as tests/rating has it."""
    here = rsegen.drive_many(RUBBLE, maps=2, robot="jackal", duration=1)
    there = rsegen.drive_many(RUBBLE, maps=2, robot="jackal", duration=1, workers=2)
    assert here.drives == there.drives
    assert all(row.distance > 0.05 for row in here.drives)


def test_a_drive_that_failed_is_a_row_without_a_result(monkeypatch: pytest.MonkeyPatch) -> None:

    def failing(here: object, scene: rsegen.Scene, *given: object, **named: object) -> object:
        if scene.index == 1:
            raise SimulatorFailed("MuJoCo: the physics failed after 1 s, so this drive has no result")
        return record_embedded(here, scene, *given, **named)  # type: ignore[arg-type]  # passed on

    monkeypatch.setattr(many, "record_embedded", failing)
    result = rsegen.drive_many(RUBBLE, maps=2, robot="crawler", duration=1)
    assert (result.counted, len(result.drives)) == (1, 2)
    assert "map 1 has no result: MuJoCo: the physics failed" in "\n".join(result.report())
    assert result.interval == wilson(result.crossed, 1)
    # In files a missing number is none.
    assert json.loads(json.dumps(result.as_json(), allow_nan=False))["rows"][1]["distance"] is None
    rows = list(csv.DictReader(line.decode() for line in result.csv()))
    assert rows[1]["distance"] == ""
    assert rows[1]["failed"] == result.drives[1].failed
    assert float(rows[0]["distance"]) > 0.1


def test_a_drive_without_any_result_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*_: object, **__: object) -> object:
        raise SimulatorFailed("MuJoCo: the physics failed")

    monkeypatch.setattr(many, "record_embedded", failing)
    with pytest.raises(UserError, match=r"^none of 2 drives has a result; map 0: MuJoCo: the physics failed$"):
        rsegen.drive_many(RUBBLE, maps=2, robot="crawler", duration=1)


@pytest.mark.slow
def test_a_map_without_a_spot_has_no_result_and_the_others_have() -> None:
    result = rsegen.drive_many(replace(RUBBLE, chunk_size=8, seed=3, maps=2), route="random", duration=0.2)
    failed = [drive.failed for drive in result.drives if drive.failed]
    assert (result.counted, len(failed)) == (1, 1)
    assert all("no spot on this map" in why for why in failed)


def test_a_stop_tells_how_many_drives_are_done(tmp_path: Path) -> None:
    def stopping(_: int) -> None:
        raise KeyboardInterrupt

    expected = "1 of 3 drives were done, and are not kept; nothing was changed in "
    with pytest.raises(Stopped, match=expected) as stop:
        rsegen.drive_many(RUBBLE, maps=3, robot="crawler", duration=0.2, progress=stopping, output=tmp_path / "out")
    assert not stop.value.changed
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("count", "of"), [(0, 10), (10, 10), (3, 17), (500, 1000), (1, 1)])
def test_the_interval_is_wilsons(count: int, of: int) -> None:
    expected = binomtest(count, of).proportion_ci(method="wilson")
    assert wilson(count, of) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_without_a_trial_nothing_is_known() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


def test_the_table_is_written_whole_and_kept(tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = rsegen.drive_many(RUBBLE, maps=2, robot="crawler", duration=1, output=out)
    assert sorted(path.name for path in out.iterdir() if not path.name.startswith(".")) == [
        "drives.csv",
        "drives.json",
        "recipe.json",
    ]
    content = json.loads((out / "drives.json").read_text())
    assert content["drives"] == 2
    assert [content[key] for key in ("file", "motors", "speed", "duration", "seed")] == [
        None,
        "reaction",
        0.4,
        1,
        RUBBLE.seed,
    ]
    head, *rows = (out / "drives.csv").read_text().splitlines()
    assert head.startswith("map,seed,crossed,seconds,distance")
    assert [row.split(",")[0] for row in rows] == ["0", "1"]
    assert float(rows[0].split(",")[4]) == pytest.approx(result.drives[0].distance)
    with pytest.raises(OutputError):
        rsegen.drive_many(RUBBLE, maps=2, robot="crawler", duration=1, output=out)


def test_files_of_drives_have_the_path_of_the_robot_s_file(tmp_path: Path) -> None:
    """Two designs of one name, or two kinds of motors, are told apart."""
    file = tmp_path / "mine.sdf"
    file.write_text(rsegen.robot_of("jackal").file("mine", "classic"))
    given: dict[str, Any] = {"robot": file, "speed": 0.3, "motors": "classic", "duration": 0.5}
    many = rsegen.drive_many(RUBBLE, maps=1, **given)
    one = rsegen.drive(RUBBLE, **given, simulator="mujoco", predict=False)
    for content in (many.as_json(), one.as_json()):
        assert [content[key] for key in ("file", "motors", "duration")] == [str(file), "classic", 0.5]
    assert many.as_json()["speed"] == 0.3
    assert "motors as classic" in next(iter(many.report()))


def test_best_is_for_ways() -> None:
    with pytest.raises(ParameterError, match="best: is for route way, not for straight"):
        rsegen.drive_many(RUBBLE, best="tilt")


def test_a_shell_uses_all_cores_unless_it_is_told_how_many(monkeypatch: pytest.MonkeyPatch) -> None:
    used: list[int] = []

    def counted(plan: many.ManyPlan, execution: Execution, progress: object) -> ManyDrives:
        used.append(execution.workers)
        return ManyDrives(recipe=plan.recipe, robot="burger", simulator="MuJoCo", route=plan.route, drives=())

    monkeypatch.setattr(many, "make_drives", counted)
    for flags in ([], ["--workers", "3"]):
        assert main(["drives", "peak", *flags]) == 0
    assert used == [cores(), 3]
