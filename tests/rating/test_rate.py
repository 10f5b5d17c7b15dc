"""Ratings: real drives that can be driven again, the same wherever they are made, stopped and continued."""

from __future__ import annotations

import csv
import json
import re
import shlex
import signal
import sys
from collections.abc import Callable
from dataclasses import replace
from math import exp, inf, log
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import FileError, OutputError, ParameterError, SimulatorFailed, Stopped, UserError
from rsegen.field.stepfield import StepField
from rsegen.params.streams import generator
from rsegen.rating import judges
from rsegen.rating.axes import AXES
from rsegen.rating.judges import Trial, usual_duration
from rsegen.rating.rate import Rated as RatedRobot
from rsegen.rating.rate import usual_fields
from rsegen.rating.rating import Curve, Rating, plot, shown_places
from rsegen.rating.run import batch_size
from rsegen.robots.base import ROBOTS
from rsegen.simulators.embedded import EMBEDDED
from rsegen.standing.lanes import straight
from tests.rating.conftest import Rated
from tests.support.journals import edited
from tests.support.runs import contents, ended, started, until_it_has

real = pytest.mark.skipif(not EMBEDDED, reason="the capability mujoco is not here")

HALF_M = 0.03
"""Height of a unit at which the robot of `crosses` crosses half of the fields, metres."""


UNLIMITED = dict.fromkeys(("wheels", "tracks", "size", "speed", "turn"))


def crosses(field: StepField, seed: int) -> bool:
    """Cross with a probability that falls with the unit of a field, which is known."""
    share = 1 / (1 + exp((log(field.unit) - log(HALF_M)) / 0.15))
    return bool(generator(seed, 0, "luck").random() < share)


def rated(robot: object = crosses, **values: Any) -> Rating:
    rating = rsegen.rate(robot, **{"seed": 7, **values})  # type: ignore[arg-type]  # any
    assert isinstance(rating, Rating)
    return rating


def test_a_function_is_rated_until_the_interval_is_narrow() -> None:
    told: list[tuple[int, float]] = []
    rating = rated(progress=lambda count, share: told.append((count, share)))
    (curve,) = rating.curves
    assert rating.robot == "crosses"
    assert rating.half.low < 100 * HALF_M < rating.half.high
    assert rating.most.level < rating.half.level
    _, low, high = rating.half
    assert curve.precision == pytest.approx((high / low) ** 0.5 - 1)
    assert curve.precision <= 0.1
    assert 48 <= len(curve.trials) < 300
    assert told[-1][0] == len(curve.trials)
    assert all(0 < share <= 1 for _, share in told)
    assert [trial.map for trial in curve.trials] == list(range(len(curve.trials)))
    wider = rated(precision=30)
    assert len(wider.curves[0].trials) <= len(curve.trials)
    assert wider.curves[0].trials == curve.trials[: len(wider.curves[0].trials)]


def always(field: StepField, seed: int) -> bool:
    """Cross every field."""
    return True


def test_no_difficulty_above_1_is_reported_where_trials_are_few(tmp_path: Path) -> None:
    """The curve goes on beyond the axis, but no field does."""
    rating = rated(always, axis="difficulty", trials=8, output=tmp_path / "out")
    assert (rating.half.level, rating.half.high) == (inf, inf)
    assert 0 < rating.half.low < 1
    (line,) = rating.report()
    assert re.search(r"half of .* at a difficulty of more than 1 \[0\.\d+, more than 1\], and 80 % at", line)
    (curve,) = json.loads((tmp_path / "out" / "rating.json").read_text())["curves"]
    assert curve["half"] == {"level": None, "interval": [pytest.approx(rating.half.low, rel=1e-5), None]}
    with Image.open(tmp_path / "out" / "rating.png") as picture:
        assert picture.width > 800


def test_each_trial_gets_a_field_and_a_seed_of_its_own() -> None:
    seen: list[tuple[bytes, int]] = []

    def watched(field: StepField, seed: int) -> bool:
        seen.append((field.levels.tobytes(), seed))
        return field.unit < HALF_M

    rated(watched, trials=24)
    assert len(seen) == len(set(seen)) == len({seed for _, seed in seen}) == 24


def test_other_seeds_give_other_trials_and_the_same_seed_the_same() -> None:
    assert rated(trials=16).curves == rated(trials=16).curves
    assert rated(trials=16).curves != rated(trials=16, seed=8).curves


@pytest.mark.slow
@real
def test_workers_of_a_cluster_rate_alike() -> None:
    """And where there is no cluster, as the same processes make the trials."""
    here = rated("jackal", trials=8, duration=1)
    there = rated("jackal", trials=8, duration=1, workers=2, scheduler="local")
    assert here.curves == there.curves


@pytest.mark.slow
@real
def test_trials_are_drives_that_rsegen_drive_repeats(
    of_jackal: Rated, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(of_jackal.folder)
    _, curve = json.loads(Path("rating.json").read_text())["curves"]
    crossing = next(trial for trial in curve["trials"] if trial["crossed"])
    failing = next(trial for trial in curve["trials"] if not trial["crossed"])
    for trial in (crossing, failing):
        assert main([*shlex.split(trial["drive"])[1:], "--no-predict", "--json"]) == 0
        (robot,) = json.loads(capsys.readouterr().out)["robots"]
        metrics = robot.get("metrics", robot)
        assert metrics["crossed"] == trial["seconds"]
        assert metrics["distance"] > 0.1
    assert crossing["x"] > 0.5 > failing["x"]
    # A field of its own at its own level, as the recipe in the folder has it.
    recipe = rsegen.load("recipe.json")
    assert recipe.maps == 8
    assert AXES["unit"].recipe_at(recipe, crossing["level"]).unit_cm == crossing["parameters"]["unit_cm"]
    low, high = curve["half"]["interval"]
    assert 0 < low < curve["half"]["level"] < high < 10


@pytest.mark.parametrize(
    ("by", "robot"),
    [
        ("mujoco", ["--robot", "jackal", "--motors", "classic", "--turn", "0.4", "--duration", "7"]),
        ("prediction", ["--robot", "jackal", "--motors", "classic", "--turn", "0.4", "--duration", "7"]),
        ("classic", ["--robot", "jackal", "--turn", "0.4", "--duration", "7", "--simulator", "classic"]),
        ("sim", ["--robot", "jackal", "--turn", "0.4", "--duration", "7", "--simulator", "sim"]),
    ],
)
def test_a_trial_is_driven_again_where_it_was_made(by: str, robot: list[str]) -> None:
    trials = tuple(Trial(map=k, level=2.5, crossed=bool(k), duration=7) for k in range(3))
    curve = Curve(by=by, title=by, axis=AXES["unit"], trials=trials)
    replay = ("--robot", "jackal", "--motors", "classic", "--turn", "0.4")
    rating = Rating(recipe=usual_fields(), robot="jackal", axis=AXES["unit"], curves=(curve,), replay=replay)
    (of_curve,) = json.loads(b"".join(rating.files()["rating.json"]))["curves"]
    words = [shlex.split(trial["drive"]) for trial in of_curve["trials"]]
    field = ["rsegen", "drive", "recipe.json", "--map"]
    assert words == [[*field, str(k), "--unit-cm", "2.5", *robot] for k in range(3)]
    (recipe,) = rating.files()["recipe.json"]
    assert json.loads(recipe)["maps"] == 3


@pytest.mark.parametrize(
    ("robot", "named"), [("jackal", "jackal"), ("mine.xacro lidar:=true", "../mine.xacro lidar:=true")]
)
def test_a_robot_of_a_file_is_named_from_the_folder_of_its_rating(robot: str, named: str) -> None:
    subject = RatedRobot(robot=robot, limits=UNLIMITED, motors=None, duration=None)
    assert subject.replay(Path("out")) == ("--robot", named)
    assert subject.replay() == ("--robot", robot)


def test_a_robot_of_python_can_be_driven_again_if_it_is_a_known_kind() -> None:
    own = replace(ROBOTS["jackal"], links=ROBOTS["jackal"].links)
    for robot, words in ((ROBOTS["jackal"], ("--robot", "jackal")), (own, ())):
        assert RatedRobot(robot=robot, limits=UNLIMITED, motors=None, duration=None).replay() == words


@pytest.mark.slow
@real
@pytest.mark.long(reason="a kind is rated in make test")
def test_a_robot_of_a_file_is_rated_and_driven_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.sdf").write_text(rsegen.robot_of("jackal").file("mine", "classic"))
    given = {"robot": "mine.sdf", "speed": 0.3, "motors": "classic", "duration": 7}
    rating = rated(**given, trials=8, output="out")
    trial = next(trial for trial in rating.curves[0].trials if trial.crossed)
    command = json.loads(Path("out", "rating.json").read_text())["curves"][0]["trials"][trial.map]["drive"]
    assert "--robot ../mine.sdf --speed 0.3 --motors classic --duration 7" in command
    monkeypatch.chdir("out")
    assert main([*shlex.split(command)[1:], "--no-predict", "--json"]) == 0
    (robot,) = json.loads(capsys.readouterr().out)["robots"]
    assert robot.get("metrics", robot)["crossed"] == trial.seconds
    # Another file of that name is another robot.
    monkeypatch.chdir(tmp_path)
    Path("mine.sdf").write_text(rsegen.robot_of("jackal").file("other", "classic"))
    with pytest.raises(OutputError, match="out: has another rating"):
        rated(**given, trials=9, output="out")


@real
def test_a_robot_has_three_times_the_time_on_level_ground() -> None:
    robot, field = rsegen.robot_of("burger"), rsegen.build(usual_fields())
    flat = rsegen.Recipe(seed=1, boundary="none")
    (level,) = rsegen.drive(flat, robot="burger", duration=20).robots
    assert level.metrics.crossed is not None
    assert usual_duration(robot, field) == pytest.approx(3 * level.metrics.crossed, abs=2)


def test_the_prediction_judges_by_the_lane_in_the_middle() -> None:
    rating = rated("jackal", by="prediction", trials=12)
    (curve,) = rating.curves
    body = rsegen.robot_of("jackal").body
    for trial in curve.trials:
        field = rsegen.build(AXES["unit"].recipe_at(replace(usual_fields(), seed=7), trial.level), trial.map)
        assert trial.crossed == bool(straight(field, body, 0, np.zeros(1)).passed[0])
    assert 0 < curve.crossed < 12
    assert "12 fields by the prediction" in "\n".join(rating.report())


@pytest.mark.slow
@real
def test_several_judges_share_a_plot_and_a_folder(tmp_path: Path) -> None:
    out = tmp_path / "out"
    first = rated("jackal", by="prediction", trials=8, duration=1, output=out)
    both = rated("jackal", by=["prediction", "mujoco"], trials=8, duration=1, output=out)
    assert [curve.by for curve in both.curves] == ["prediction", "mujoco"]
    assert both.curves[0] == first.curves[0]
    assert [row["by"] for row in csv.DictReader((out / "trials.csv").read_text().splitlines())] == (
        ["prediction"] * 8 + ["mujoco"] * 8
    )
    assert len(list(both.report())) == 2


def stopping_after(count: int) -> Callable[[int, float], None]:
    def progress(done: int, _: float) -> None:
        if done == count:
            raise KeyboardInterrupt

    return progress


@pytest.mark.parametrize("count", [1, 13])
def test_a_stopped_rating_goes_on_as_if_it_had_not_been_stopped(tmp_path: Path, count: int) -> None:
    whole = rated(precision=12, output=tmp_path / "whole")
    with pytest.raises(Stopped, match=rf"^{count} trials? complete in .*part$") as stop:
        rated(precision=12, output=tmp_path / "part", progress=stopping_after(count))
    assert stop.value.changed
    assert not (tmp_path / "part" / "rating.json").exists()
    assert rated(precision=12, output=tmp_path / "part").curves == whole.curves
    for name in ("rating.json", "trials.csv", "recipe.json", ".rsegen.jsonl"):
        assert (tmp_path / "part" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_rating_that_is_killed_again_and_again_ends_with_the_bytes_of_one_that_is_not(tmp_path: Path) -> None:
    command: list[str | Path] = ["rate", "crawler", "--by", "prediction", "--trials", "120", "--seed", "3"]
    command += ["--workers", "2", "--progress", "none", "-o"]
    assert main([*map(str, command), str(tmp_path / "whole")]) == 0
    journal = tmp_path / "part" / ".rsegen.jsonl"

    def trials() -> int:
        return journal.read_bytes().count(b'{"result"') if journal.exists() else 0

    for stop in (signal.SIGKILL, signal.SIGTERM, signal.SIGKILL, signal.SIGINT):
        before = trials()
        process = started(*command, tmp_path / "part")
        until_it_has(process, lambda before=before: trials() >= before + 5)  # type: ignore[misc]  # of this turn
        process.send_signal(stop)
        ended(process)
        assert process.returncode == (-9 if stop is signal.SIGKILL else 128 + stop)
        assert not (tmp_path / "part" / "rating.json").exists()
    assert ended(started(*command, tmp_path / "part")) == (0, "")
    assert contents(tmp_path / "part") == contents(tmp_path / "whole")


def test_a_folder_goes_on_to_more_trials(tmp_path: Path) -> None:
    few = rated(trials=11, output=tmp_path)
    more = rated(trials=30, output=tmp_path)
    assert more.curves[0].trials[:11] == few.curves[0].trials
    assert more.curves == rated(trials=30).curves
    assert len((tmp_path / "trials.csv").read_text().splitlines()) == 31


def test_a_folder_of_another_rating_is_refused_and_replaced_by_force(tmp_path: Path) -> None:
    rated(trials=8, output=tmp_path / "out")
    with pytest.raises(OutputError, match="out: has another rating; use another folder, or force=True"):
        rated(trials=8, output=tmp_path / "out", seed=8)
    rated(trials=9, output=tmp_path / "out", seed=8, force=True)
    assert json.loads((tmp_path / "out" / "rating.json").read_text())["seed"] == 8


def test_a_stop_without_a_folder_keeps_nothing() -> None:
    with pytest.raises(Stopped, match="3 trials made, and not kept") as stop:
        rated(progress=stopping_after(3))
    assert not stop.value.changed


def test_a_journal_that_was_changed_is_refused(tmp_path: Path) -> None:
    rated(trials=8, output=tmp_path)
    edited(tmp_path / ".rsegen.jsonl", '"map": 3', '"map": 5')
    with pytest.raises(FileError, match=r"jsonl: result 4: map: 5 is not 3, the next one; use another folder"):
        rated(trials=9, output=tmp_path)


def test_fields_that_are_no_recipe_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"^recipe: 'peak' is not a recipe, which rsegen.load reads"):
        rsegen.rate(crosses, "peak", seed=7)  # type: ignore[arg-type]


def test_a_plot_shows_both_intervals_as_a_whole() -> None:
    rating = rated(trials=30)
    low, high = shown_places(rating.curves)
    assert all(low <= rating.axis.place(level) <= high for level in (*rating.half, *rating.most))


@pytest.mark.parametrize(("answer", "words"), [(True, "more"), (False, "less")])
def test_what_crosses_all_fields_or_none_is_said(answer: bool, words: str) -> None:
    rating = rated(lambda field, seed: answer)
    assert len(rating.curves[0].trials) < 100
    (line,) = rating.report()
    assert f"crosses {words} than half of normal-random fields (10 x 10 blocks of 10 cm) at every level from" in line
    assert rating.as_json()["curves"][0]["half"] is None  # type: ignore[index]  # a list
    assert plot(rating).startswith(b"\x89PNG")


@pytest.mark.slow
@real
def test_longer_fields_of_wider_blocks_get_more_time() -> None:
    recipe = replace(usual_fields(), unit_cm=0.5)
    rating = rated("jackal", recipe=recipe, axis="block_width", trials=8)
    (curve,) = rating.curves
    times = {trial.level: trial.duration for trial in curve.trials}
    assert len(times) > 4
    length, speed, gap = rsegen.robot_of("jackal").size[0], 0.4, 0.1  # m, m/s, m
    for level, duration in times.items():
        assert duration is not None
        assert duration == pytest.approx(3 * (10 * level / 100 + gap + length) / speed, abs=1.5)
    assert all(trial.crossed for trial in curve.trials if trial.level > 10)


@real
def test_frames_that_hold_a_robot_at_every_level_are_named() -> None:
    recipe = replace(usual_fields(), boundary="outer", seed=1)
    rating = rsegen.rate("burger", recipe, trials=8, duration=1)
    assert isinstance(rating, Rating)
    assert list(rating.report())[-1].startswith("note: the frames are equally high at every level")


def test_fields_that_are_all_alike_are_named() -> None:
    rating = rated(recipe=rsegen.Recipe(obstacles=[rsegen.Peak(levels=5, first=(2, 2), last=(7, 7))]), trials=8)
    assert "all fields of this recipe are equal" in list(rating.report())[-1]


def test_trials_without_a_result_count_neither_way(monkeypatch: pytest.MonkeyPatch) -> None:
    def half_failing(self: judges.ByFunction, recipe: rsegen.Recipe, asked: judges.Asked) -> Trial:
        if asked.map % 2:
            return Trial(map=asked.map, level=asked.level, crossed=None, failed="the physics failed")
        return Trial(map=asked.map, level=asked.level, crossed=recipe.unit_cm < 3)

    monkeypatch.setattr(judges.ByFunction, "trial", half_failing)
    rating = rated(trials=24)
    (curve,) = rating.curves
    counted = Curve(by="", title="", axis=curve.axis, trials=curve.trials[::2])
    assert curve.half == counted.half
    assert "12 trials have no result; the first: the physics failed" in "\n".join(rating.report())


@real
def test_a_rating_without_any_result_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*_: object, **__: object) -> object:
        raise SimulatorFailed("MuJoCo: the physics failed")

    monkeypatch.setattr("rsegen.driving.many.record_embedded", failing)
    with pytest.raises(UserError, match=r"^none of 8 trials has a result; the first: MuJoCo: the physics failed$"):
        rated("jackal")


def test_the_plot_shows_curves_and_points(tmp_path: Path) -> None:
    rated(trials=40, output=tmp_path)
    with Image.open(tmp_path / "rating.png") as picture:
        red, green, blue = np.asarray(picture.convert("RGB"), int).transpose(2, 0, 1)
    drawn = (blue > red + 60) & (blue > green)  # curve, points and intervals
    assert drawn.sum() > 3000
    assert drawn.any(axis=0).mean() > 0.7


def test_the_plot_says_what_is_on_its_axes_and_how_many_trials_a_point_has(monkeypatch: pytest.MonkeyPatch) -> None:
    figures: list[Figure] = []
    monkeypatch.setattr("rsegen.rating.rating.encoded", lambda figure, *_: figures.append(figure))
    rating = rated(trials=40)
    plot(rating)
    (axes,) = figures[0].axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "unit [cm], harder to the right",
        "share of fields that are crossed",
    )
    assert sum(int(text.get_text()) for text in axes.texts) == len(rating.curves[0].trials)
    legend = axes.get_legend()
    assert legend
    assert [text.get_text().partition(":")[0] for text in legend.get_texts()] == ["crosses"]


def test_batches_depend_on_the_number_of_trials_alone() -> None:
    assert [batch_size(done) for done in (0, 8, 63, 80, 400, 10**6)] == [8, 8, 8, 10, 50, 64]


@pytest.mark.parametrize(
    ("robot", "values", "words"),
    [
        ("unicorn", {}, "robot: unknown robot 'unicorn'"),
        (3, {}, "robot: 3 is no robot"),
        (crosses, {"by": "prediction"}, "by: is for a robot; a function judges by itself"),
        (crosses, {"motors": "classic"}, "motors: is for a robot, not for a function"),
        (crosses, {"duration": 3}, "duration: is for a robot, not for a function"),
        (crosses, {"reliability": 0.8}, "reliability: is for a robot"),
        (lambda field, seed: 1, {}, "robot: <lambda> returned 1; a function returns a bool"),
        ("burger", {"speed": 1}, "speed: is for the robot of a file"),
        ("burger", {"recipe": rsegen.Recipe()}, "recipe: has no obstacle"),
    ],
)
def test_what_cannot_be_rated_is_refused(robot: object, values: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        rated(robot, **values)


@pytest.mark.slow
@real
def test_the_command_prints_a_sentence_and_writes_the_folder(of_jackal: Rated) -> None:
    assert "rating.png" in of_jackal.planned
    line = of_jackal.printed.splitlines()[1]
    assert line.startswith("jackal crosses half of normal-random fields (10 x 10 blocks of 10 cm) at a unit of ")
    assert "; 8 drives in MuJoCo " in line
    assert line.endswith("seed 7")
    assert sorted(path.name for path in of_jackal.folder.iterdir() if path.name[0] != ".") == sorted(
        ["rating.json", "trials.csv", "rating.png", "recipe.json"]
    )


def test_a_shell_names_its_flags(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rate", "burger", "--trials", "2"]) == 2
    assert capsys.readouterr().err == "rsegen: --trials: 2 is outside 8..100000\n"
    assert main(["rate", "burger", "--obstacle", "random levels=3", "--confidence", "0.9"]) == 2
    assert capsys.readouterr().err == "rsegen: --confidence: is for a test of reliability; set reliability too\n"
