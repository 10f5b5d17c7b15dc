"""rsegen drive and rsegen experiment in real servers."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from PIL import Image

import rsegen
from rsegen import Matrix, Recipe, generate
from rsegen.cli.edge import main
from rsegen.experiments import trial
from rsegen.experiments.plan import ExperimentPlan, TableRow
from rsegen.experiments.trial import run_trial
from rsegen.experiments.trial_server import Measurement, total
from rsegen.robots.base import ROBOTS
from rsegen.simulators.base import Installation
from tests.robots.two_wheels import two_wheels
from tests.support.missing import missing

HILL = Matrix.of(np.array([[1, 2, 2, 1]] * 12).T)
"""Four cells deep from west to east, and as wide as the map: steps of one unit up and down."""


def course(folder: Path, unit_cm: float) -> Path:
    """A map that rises by two steps and falls again, twelve cells wide and four deep."""
    recipe = Recipe(
        chunk_size=4,
        chunks=(1, 3),
        boundary="none",
        unit_cm=unit_cm,
        seed=1,
        obstacles=(HILL,),
    )
    return generate(recipe, folder).maps[0].folder


def told(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(capsys.readouterr().out)["robots"]
    return found


@pytest.mark.long(reason="two drives, for a rounding")
def test_a_drive_twelve_metres_from_the_origin_is_as_long_as_one_near_it_in_classic(
    gazebo_classic: Installation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Classic's record has three digits, which told 1.14 m for 1.09 in five seconds."""
    lengths = []
    for chunks in (1, 24):
        level = Recipe(name=f"level-{chunks}", chunks=(chunks, 1), boundary="none", seed=1)
        folder = generate(level, tmp_path).maps[0].folder
        words = ["drive", str(folder), "--duration", "2", "--no-contacts", "--no-predict"]
        assert main([*words, "--json", "-o", str(tmp_path / level.name), "--simulator", "classic"]) == 0
        (robot,) = told(capsys)
        lengths.append(robot["distance"])
        rows = np.loadtxt(tmp_path / level.name / "burger_0.csv", delimiter=",", skiprows=1)
    assert abs(rows[0, 1]) > 12
    assert lengths[0] > 0.3
    assert lengths[1] == pytest.approx(lengths[0], abs=0.003)


@pytest.mark.parametrize(
    ("unit_cm", "crosses"), [(1, True), pytest.param(4, False, marks=pytest.mark.long(reason="a second drive"))]
)
def test_a_burger_crosses_steps_of_a_centimetre_and_no_higher_ones_in_classic(
    unit_cm: float, crosses: bool, gazebo_classic: Installation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["drive", str(course(tmp_path, unit_cm)), "--no-predict", "--duration", "15" if crosses else "6", "--json"]
    assert main([*words, "-o", str(tmp_path / "out"), "--simulator", "classic"]) == 0
    (robot,) = told(capsys)
    assert (robot["crossed"] is not None) == crosses
    assert (robot["stuck"] > 2) != crosses
    assert robot["tipped"] == 0
    assert robot["touched"]["base::caster"] > 0.5
    assert any(part.startswith("base::hull") for part in robot["touched"]) != crosses
    rows = np.loadtxt(tmp_path / "out" / "burger_0.csv", delimiter=",", skiprows=1)
    assert rows[:, 3].max() == pytest.approx(2 * unit_cm / 100 if crosses else 0, abs=0.015)
    with Image.open(tmp_path / "out" / "drive.png") as picture:
        assert picture.width == 1050  # a column of a paper, 300 pixels per inch


@pytest.mark.parametrize(
    ("kind", "unit_cm", "crosses"),
    [("jackal", 1, True), ("jackal", 4, True), ("burger", 0.4, True), ("burger", 1, False)],
)
def test_wheels_cross_steps_and_a_small_caster_only_low_ones(
    kind: str, unit_cm: float, crosses: bool, gazebo_sim: Installation, tmp_path: Path
) -> None:
    """A caster of 5 mm radius, a capsule in Sim, is lifted over a step of a centimetre in Gazebo Classic alone."""
    result = rsegen.drive(course(tmp_path, unit_cm), robot=kind, duration=15, simulator="sim")
    (robot,) = result.robots
    assert (robot.metrics.crossed is not None) == crosses
    assert result.notes == ()
    assert np.diff(robot.trajectory.rows[:, 0]) == pytest.approx(0.05)


@pytest.mark.long(reason="a drive of 12 s")
def test_no_command_tilts_a_burger_on_level_ground(gazebo: Installation) -> None:
    """It wanders, backs away and turns back; in Gazebo Sim it would nod if its wheels changed speed at once."""
    ground = Recipe(seed=7, boundary="none")
    drive = rsegen.drive(
        ground,
        route="random",
        duration=12,
        seed=2,
        simulator=gazebo.simulator.name,
        predict=False,
        contacts=False,
    )
    (robot,) = drive.robots
    assert robot.metrics.tilt < 0.01
    assert robot.metrics.distance > 1


@pytest.mark.long(reason="drives in MuJoCo are the same in make test")
def test_python_and_the_command_line_drive_the_same_and_another_seed_drives_otherwise(
    gazebo: Installation, tmp_path: Path
) -> None:
    done: list[float] = []
    folder, name = course(tmp_path, 1), gazebo.simulator.name
    chosen: dict[str, Any] = {"route": "random", "robots": 2, "duration": 2, "simulator": name}
    result = rsegen.drive(folder, **chosen, predict=False, seed=5, output=tmp_path / "python", progress=done.append)
    words = ["drive", str(folder), *(word for key, value in chosen.items() for word in (f"--{key}", str(value)))]
    words.append("--no-predict")
    for seed in ("5", "6"):
        assert main([*words, "--seed", seed, "-o", str(tmp_path / seed)]) == 0
    for file in ("burger_0.csv", "burger_1.csv", "contacts.csv", "drive.json"):
        python, same, other = (_without_attempts(tmp_path / home / file) for home in ("python", "5", "6"))
        assert python == same
        assert python != other
    assert json.loads((tmp_path / "python" / "drive.json").read_text()) == result.as_json()
    for robot in result.robots:
        assert robot.metrics.distance == pytest.approx(0.25, abs=0.2)
        assert robot.trajectory.rows[0, 1] == pytest.approx(robot.start.x, abs=0.01)
    assert done[-1] == 2


def _without_attempts(file: Path) -> str:
    """The text of a file, without what a note says of a Gazebo that failed by itself, and was started again."""
    return re.sub(r"\s*\"[^\"]* failed and was started again; this is attempt \d+\",?\s*", "", file.read_text("utf-8"))


def names(folder: Path) -> set[str]:
    return {str(path) for path in folder.rglob("*") if path.is_file()}


@pytest.mark.long(reason="dry runs of other commands in make test")
def test_a_dry_run_of_a_drive_names_its_files(
    gazebo: Installation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["drive", str(course(tmp_path, 1)), "--duration", "1", "--simulator", gazebo.simulator.name]
    words += ["--route", "way", "--robots", "2", "--no-predict", "-o", str(tmp_path / "out")]
    assert main([*words, "--dry-run", "--json"]) == 0
    fates = json.loads(capsys.readouterr().out)
    assert not (tmp_path / "out").exists()
    assert main(words) == 0
    assert set(fates["write"]) == names(tmp_path / "out")


@pytest.mark.long(reason="one length of a drive")
def test_a_rest_that_is_less_than_a_step_is_left_out(
    gazebo_classic: Installation, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["drive", "turtlebot", "--no-predict", "--duration", "1.0004", "--simulator", "classic", "--json"]) == 0
    (robot,) = told(capsys)
    assert robot["seconds"] == 1
    assert robot["touched"]["base::caster"] == 0.5


def test_wheels_touch_the_map_at_the_heights_of_its_blocks(gazebo: Installation, tmp_path: Path) -> None:
    words = ["drive", str(course(tmp_path, 1)), "--robot", "jackal", "--simulator", gazebo.simulator.name]
    assert main([*words, "--no-predict", "--duration", "5", "-o", str(tmp_path / "out")]) == 0
    with (tmp_path / "out" / "contacts.csv").open() as stream:
        touched = [row for row in csv.DictReader(stream) if row["part"].endswith("tread")]
    levels = {round(100 * float(row["z"])) for row in touched if row["other"] == "rse_0000"}
    assert {1, 2} <= levels
    assert {float(row["z"]) for row in touched if row["other"] == "ground_plane"} == {0}


@pytest.mark.long(reason="two drives of two robots")
def test_sampling_contacts_does_not_change_a_drive(gazebo: Installation, tmp_path: Path) -> None:
    folder, name = course(tmp_path, 4), gazebo.simulator.name
    with_contacts, without = (
        rsegen.drive(folder, robots=2, duration=1, seed=5, simulator=name, contacts=contacts, predict=False)
        for contacts in (True, False)
    )
    for one, other in zip(with_contacts.robots, without.robots, strict=True):
        assert np.array_equal(one.trajectory.rows, other.trajectory.rows)
        assert one.metrics.touched
        assert other.metrics.touched == {}
    assert len(with_contacts.contact_samples) == 2
    assert without.contact_samples == []
    # On a busy machine a server may fail and be started again: the drive has to be the same all the more.
    assert [note for note in (*with_contacts.notes, *without.notes) if "was started again" not in note] == []


def test_errors_of_the_simulator_are_warned_of(
    gazebo: Installation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = course(tmp_path, 1)
    for mesh in folder.glob("meshes/*.obj"):
        mesh.unlink()
    words = ["drive", str(folder), "--no-predict", "--duration", "1", "--simulator", gazebo.simulator.name]
    is_over = main(words) == 0
    out, err = capsys.readouterr()
    if is_over:
        assert "warning: [Err]" in out
    else:  # Harmonic does not load such a world
        assert "the world was not loaded; its last errors are: " in err


def test_a_robot_of_a_file_is_driven(gazebo: Installation, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine.sdf").write_text(ROBOTS["jackal"].file("mine", gazebo.backend))
    words = ["drive", str(course(tmp_path, 1)), "--robot", str(tmp_path / "mine.sdf"), "--size", "0.5,0.43,0.25"]
    words += ["--simulator", gazebo.simulator.name, "--no-predict"]
    assert main([*words, "--speed", "0.4", "--duration", "7", "--json"]) == 0
    (robot,) = told(capsys)
    assert robot["crossed"] is not None


def test_a_robot_whose_file_begins_with_a_wheel_drives_like_any_other(
    gazebo: Installation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A Gazebo takes the first link for the place of a model, which was that of a wheel, and tipped with its turns."""
    text = two_wheels()
    wheel = text[text.index('<link name="left_wheel">') : text.index('<joint name="left_hub"')]
    base = text.index('<link name="base">')
    (tmp_path / "mine.sdf").write_text(text[:base] + wheel + text[base:].replace(wheel, ""))
    words = ["drive", str(course(tmp_path, 0.1)), "--robot", str(tmp_path / "mine.sdf"), "--no-predict", "--json"]
    assert main([*words, "--simulator", gazebo.simulator.name, "--speed", "0.3", "--duration", "3"]) == 0
    (robot,) = told(capsys)
    assert robot["tipped"] == 0
    assert robot["distance"] == pytest.approx(0.9, abs=0.1)


def test_an_experiment_goes_on_where_it_was_stopped(
    gazebo: Installation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = tmp_path / "tiny.yaml"
    plan.write_text("seconds: 1\nrepeats: 1\nrows:\n  - {robot: burger, robots: 1, sizes: [10]}\n")
    words = ["experiment", str(plan), "--simulator", gazebo.simulator.name, "-o", str(tmp_path / "out")]
    assert main([*words, "--dry-run", "--json"]) == 0
    fates = json.loads(capsys.readouterr().out)
    assert not (tmp_path / "out").exists()
    assert main(words) == 0
    table, errors = capsys.readouterr()
    assert set(fates["write"]) == names(tmp_path / "out")
    rows = (line.split("|")[1] for line in table.splitlines() if line.startswith("| 10"))
    assert [row.strip(" †‡") for row in rows] == ["10 x 10"]  # ‡: the machine was too busy
    assert errors.splitlines()[-1].startswith("2 of 2: row 1")
    log = tmp_path / "out" / ".rsegen.jsonl"
    lines = log.read_text().splitlines(keepends=True)
    log.write_text("".join(lines[:-1]) + lines[-1][:20])
    assert main(words) == 0
    again = log.read_text().splitlines(keepends=True)
    results = [[line for line in one if '"result"' in line] for one in (lines, again)]
    assert len(results[1]) == len(results[0]) == 2
    assert results[1][:-1] == results[0][:-1]
    outcome = json.loads(again[-1])["result"]["outcome"]
    assert outcome["speed"] > 0
    assert 50 < outcome["memory"] < 1000
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        ".rsegen.jsonl",
        "table.md",
        "trials.csv",
        "summary.json",
        "plot.png",
        "tracks",
    }
    tracks = tmp_path / "out" / "tracks"
    assert {path.name for path in tracks.glob("*.csv")} == {f"row1-10-{pace}-0.csv" for pace in ("real", "free")}
    assert len(list(tracks.glob("*.png"))) == 2
    assert "experiment " + str(plan) in table


def processes(name: str) -> list[psutil.Process]:
    """Those of a name that this one has started."""
    found = []
    for each in psutil.Process().children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            found += [each] if each.name().startswith(name) else []
    return found


@pytest.mark.long(reason="three servers")
def test_a_server_that_is_killed_in_a_trial_is_counted(gazebo_classic: Installation) -> None:
    killed: list[int] = []

    def watch() -> None:
        for server in processes("gzserver"):
            if len(killed) < 2 and server.pid not in killed and server.create_time() < time.time() - 3:
                killed.append(server.pid)
                server.kill()

    plan = ExperimentPlan(name="killed", rows=(TableRow(robots=1, sizes=(10,)),), paces=("real",), seconds=4)
    outcome = run_trial(plan, plan.cells[0], 0, gazebo_classic, watch).outcome
    assert len(killed) == 2
    assert outcome.attempts == 3
    assert outcome.starved is not None


@pytest.mark.long(reason="a server that stands most of the time")
def test_a_server_without_the_processor_is_starved(gazebo_classic: Installation) -> None:
    """It is stopped for most of the time, as by a scheduler that has others to serve."""

    def watch() -> None:
        for server in processes("gzserver"):
            if server.create_time() < time.time() - 2:
                server.suspend()
                time.sleep(1.5)  # between two looks it runs for about half a second
                server.resume()

    plan = ExperimentPlan(name="starved", rows=(TableRow(robots=1, sizes=(10,)),), paces=("free", "real"), seconds=2)
    free, real = (run_trial(plan, cell, 0, gazebo_classic, watch).outcome for cell in plan.cells)
    assert free.starved
    assert free.cpu is not None
    assert free.cpu < 0.5
    assert real.starved


@pytest.mark.long(reason="a trial of each Gazebo")
def test_a_robot_of_a_file_is_in_a_plan(gazebo: Installation, tmp_path: Path) -> None:
    file = tmp_path / "mine.sdf"
    file.write_text(ROBOTS["jackal"].file("mine", gazebo.backend))
    row = TableRow(robot=str(file), robots=1, sizes=(10,), speed=0.3)
    plan = ExperimentPlan(name="mine", rows=(row,), paces=("free",), seconds=2)
    trial = run_trial(plan, plan.cells[0], 0, gazebo)
    assert list(trial.trajectories) == ["mine_0"]
    assert trial.outcome.driven is not None
    assert trial.outcome.driven > 0.2
    assert trial.outcome.impossible == 0


@pytest.mark.long(reason="tests/simulation/driving has incidents")
def test_links_of_a_gram_that_fly_away_are_told(gazebo_classic: Installation, tmp_path: Path) -> None:
    text = re.sub(r"<mass>[^<]*<", "<mass>0.001<", ROBOTS["burger"].file("light", "classic"))
    text = re.sub(r"<(i[xyz])([xyz])>[^<]*<", lambda at: f"<{at[1]}{at[2]}>{1e-9 * (at[1][1] == at[2])}<", text)
    (tmp_path / "light.sdf").write_text(text)
    result = rsegen.drive(
        course(tmp_path, 1),
        robot=tmp_path / "light.sdf",
        duration=3,
        seed=1,
        simulator="classic",
        contacts=False,
        predict=False,
    )
    (robot,) = result.robots
    (incident,) = robot.metrics.incidents
    assert incident.kind == "impossible"
    assert robot.metrics.distance < 1
    assert robot.metrics.crossed is None
    assert str(incident) in "".join(result.report())


@pytest.mark.long(reason="a drive of a model with a mistake")
def test_wheels_that_turn_nothing_are_noted(gazebo_classic: Installation, tmp_path: Path) -> None:
    """Its wheels hang in the air, as it stands on feet."""
    text = ROBOTS["jackal"].file("mine", "classic")
    foot = '<collision name="foot"><pose>0 0 {z} 0 0 0</pose><geometry><box><size>0.4 0.3 0.1</size></box></geometry>'
    link = text.index("<collision")
    text = text[:link] + foot.format(z=-0.1) + "</collision>" + text[link:]
    (tmp_path / "mine.sdf").write_text(text)
    mine = tmp_path / "mine.sdf"
    result = rsegen.drive(course(tmp_path, 1), robot=mine, duration=4, simulator="classic", predict=False)
    assert "on the level ground before the map: perhaps front_left_axle" in result.notes[-1]


@pytest.mark.long(reason="two servers in turns")
def test_an_empty_world_in_turns_with_another_gives_the_share_of_its_speed(
    gazebo: Installation, monkeypatch: pytest.MonkeyPatch
) -> None:
    sums: list[Measurement] = []

    def kept(spans: Sequence[Measurement]) -> Measurement:
        sums.append(total(spans))
        return sums[-1]

    monkeypatch.setattr(trial, "total", kept)
    plan = ExperimentPlan(name="null", rows=(TableRow(robots=1, sizes=(0,)),), paces=("beside",), seconds=1)
    outcome = run_trial(plan, plan.cells[0], 0, gazebo).outcome
    ours, empty = sums[-2:]  # of the last server that was tried
    assert min(ours.simulated, empty.simulated, ours.cpu, empty.cpu) > 0
    assert outcome.share == pytest.approx(ours.speed / empty.speed, abs=1e-4)  # that it is 1 is for benchmarks
    assert outcome.speed == pytest.approx(ours.speed, abs=1e-3)
    assert outcome.rtf is None


@pytest.mark.long(reason="a camera without a graphics card")
def test_gazebo_s_own_camera_shows_the_map_in_its_colours(gazebo_classic: Installation, tmp_path: Path) -> None:
    screen = shutil.which("xvfb-run") or missing("no virtual screen: run scripts/screen")
    words = [
        "drive",
        "diagonal-barrier",
        "--simulator",
        "classic",
        "--duration",
        "1",
        "--no-predict",
        "--no-contacts",
        "--picture",
        "-o",
        str(tmp_path / "out"),
    ]
    large = "-screen 0 1280x1024x24 +extension GLX"
    variables = {**os.environ, "LIBGL_ALWAYS_SOFTWARE": "1"}
    subprocess.run([screen, "-a", "-s", large, sys.executable, "-m", "rsegen", *words], check=True, env=variables)
    with Image.open(tmp_path / "out" / "picture.jpg") as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(int)
    red, green, blue = pixels[..., 0], pixels[..., 1], pixels[..., 2]
    assert ((red > 150) & (green < 60) & (blue < 60)).mean() > 0.01
    assert ((red > 150) & (green > 150) & (blue < 120)).mean() > 0.003


def test_a_picture_is_refused_without_a_screen_or_a_folder(
    gazebo_classic: Installation, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert main(["drive", "peak", "--picture"]) == 2
    assert "--picture: needs a folder" in capsys.readouterr().err
    assert main(["drive", "peak", "--simulator", "classic", "--picture", "-o", "out"]) == 2
    assert "there is none" in capsys.readouterr().err
