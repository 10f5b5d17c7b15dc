"""A certainty that is asked for: the least room to spare with which a robot crosses so surely."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.driving import certainty
from rsegen.driving.planning import predictions
from rsegen.errors import NoSimulator, ParameterError
from rsegen.field.crossing import CrossingModel
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import decode
from rsegen.recipe.recipe_file import answered
from rsegen.robots.base import ROBOTS
from rsegen.scene.scene import Scene, compose

LOW = rsegen.Recipe(
    name="low", seed=5, chunk_size=5, boundary="none", unit_cm=0.1, obstacles=(rsegen.Random(levels=5),)
)
"""Maps that are made in no time, as the jackal drives them; how surely, is scripted here."""


class Told:
    """Predictions that are scripted: a probability for a room to spare, the other way across always sure."""

    def __init__(self, **by_side: dict[float, float]) -> None:
        self.by_side, self.asked = by_side, list[tuple[float, int]]()

    def __call__(self, robot: CrossingModel, scene: Scene) -> dict[str, SimpleNamespace]:
        assert robot is ROBOTS["jackal"]
        room = scene.recipe.crossable_room
        self.asked.append((room, scene.index))
        sides = ("west_east", "south_north")
        return {side: SimpleNamespace(probability=self.by_side.get(side, {}).get(room, 1.0)) for side in sides}


RISING = {0.0: 0.3, 0.2: 0.5, 0.4: 0.7, 0.6: 0.8, 0.8: 0.85, 1.0: 0.9, 2.0: 0.95}


@pytest.mark.parametrize("side", ["west_east", "south_north"])
@pytest.mark.parametrize(("asked", "room"), [(0.5, 0.2), (0.6, 0.4), (0.7, 0.4), (0.8, 0.6), (0.9, 1.0), (0.95, 2.0)])
def test_the_least_room_that_is_sure_enough_is_found(
    monkeypatch: pytest.MonkeyPatch, side: str, asked: float, room: float
) -> None:
    told = Told(**{side: RISING})
    monkeypatch.setattr(certainty, "predictions", told)
    recipe = replace(LOW, crossable_by="jackal")
    assert rsegen.with_certainty(recipe, asked) == replace(recipe, crossable_room=room)
    assert len(told.asked) <= 3


def test_maps_that_are_sure_enough_as_they_are_get_no_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certainty, "predictions", Told(west_east=dict.fromkeys(certainty.ROOMS, 0.9)))
    recipe = replace(LOW, crossable_by="jackal", crossable_room=0.6)
    assert rsegen.with_certainty(recipe, 0.9).crossable_room == 0


def test_the_mean_over_the_first_maps_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Told(west_east=dict.fromkeys(certainty.ROOMS, 0.8))
    monkeypatch.setattr(certainty, "predictions", told)
    rsegen.with_certainty(replace(LOW, crossable_by="jackal", maps=20, first_map=3), 0.8 - 1e-9)
    assert {index for _, index in told.asked} == set(range(3, 11))


def test_a_certainty_that_no_room_gives_is_refused_with_the_best_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certainty, "predictions", Told(west_east=dict.fromkeys(certainty.ROOMS, 0.62)))
    with pytest.raises(
        ParameterError,
        match=r"^crossable_by: the jackal crosses even level lanes of these maps with 0\.62 at most; ask",
    ):
        rsegen.with_certainty(replace(LOW, crossable_by="jackal"), 0.7)


def test_a_side_without_a_result_is_not_crossed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certainty, "predictions", lambda *_: {"west_east": SimpleNamespace(probability=1.0)})
    with pytest.raises(ParameterError, match=r"with 0\.00 at most"):
        rsegen.with_certainty(replace(LOW, crossable_by="jackal"), 0.5)


def test_only_a_robot_can_be_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    for recipe in (LOW, replace(LOW, crossable_by=(5.0, 5.0, 30.0))):
        with pytest.raises(ParameterError, match="has no robot"):
            rsegen.with_certainty(recipe, 0.9)
    with pytest.raises(ParameterError, match=r"certainty: 1 is outside 0\.5\.\.0\.95"):
        rsegen.with_certainty(replace(LOW, crossable_by="jackal"), 1)
    monkeypatch.setattr("rsegen.driving.planning.embedded_simulator", lambda _: None)
    with pytest.raises(NoSimulator, match="a certainty of crossing needs MuJoCo"):
        rsegen.with_certainty(replace(LOW, crossable_by="jackal"), 0.9)


def test_a_recipe_file_asks_and_the_map_has_the_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certainty, "predictions", Told(west_east=RISING))
    file = tmp_path / "asked.yaml"
    text = "{name: a, seed: 5, chunk_size: 5, boundary: none, unit_cm: 0.1, obstacles: [{kind: random, levels: 5}]"
    file.write_text(f"{text}, crossable_by: 'jackal:0.8'}}", "utf-8")
    assert main(["generate", str(file), "-o", str(tmp_path / "worlds"), "--quiet"]) == 0
    made = rsegen.load(tmp_path / "worlds" / "a_0000" / "recipe.json")
    assert (made.crossable_by, made.crossable_room) == ("jackal", 0.6)
    monkeypatch.setattr(certainty, "predictions", None)  # a map is made again without any drive
    assert main(["generate", str(tmp_path / "worlds" / "a_0000"), "-o", str(tmp_path / "again"), "--quiet"]) == 0
    for path in (tmp_path / "worlds" / "a_0000").rglob("*"):
        if path.is_file():
            assert path.read_bytes() == (tmp_path / "again" / path.relative_to(tmp_path / "worlds")).read_bytes()


def test_a_flag_asks_over_a_recipe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certainty, "predictions", Told(west_east=RISING))
    flags = ["--obstacle", "random levels=5", "--unit-cm", "0.1", "--boundary", "none", "--crossable-by", "jackal:0.9"]
    assert main(["generate", "--seed", "5", *flags, "-o", str(tmp_path), "--quiet"]) == 0
    made = rsegen.load(tmp_path / "rse_0000" / "recipe.json")
    assert (made.crossable_by, made.crossable_room) == ("jackal", 1)


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"crossable_by": "jackal:2"}, r"crossable_by: 2\.0 is outside 0\.5\.\.0\.95"),
        ({"crossable_by": "jackal:sure"}, r"crossable_by: 'sure' is not a number"),
        ({"crossable_by": "jackal:"}, "crossable_by: '' is not a number"),
        ({"crossable_by": "rover.xacro wheels:=4"}, "crossable_by: 'rover.xacro wheels:=4' is a file, and a recipe"),
        ({"crossable_by": "/on:disk/rover.urdf"}, "crossable_by: '/on:disk/rover.urdf' is a file, and a recipe"),
        ({"crossable_by": "rover.xacro wheels:=4:0.9"}, "crossable_by: 'rover.xacro wheels:=4' is a file"),
        ({"crossable_by": "jakal:0.9"}, "crossable_by: unknown robot 'jakal'.*did you mean 'jackal'"),
        ({"crossable_by": "jackal:0.9", "crossable_room": 0.4}, "crossable_room: cannot be set together with"),
    ],
)
def test_what_cannot_be_asked_is_refused(asked: dict[str, object], says: str) -> None:
    with pytest.raises(ParameterError, match=says):
        answered(decode, asked)


def test_a_path_is_taken_in_brackets_as_recipes_have_it() -> None:
    sort = parameters(rsegen.Recipe)["crossable_by"]
    for text in ("10,20,53", "[10, 20, 53]"):
        assert sort.check("", sort.parse(text)) == (10, 20, 53)


def test_a_recipe_itself_has_no_certainty() -> None:
    with pytest.raises(
        ParameterError, match=r"crossable_by: 'jackal:0\.9' asks for a certainty, which files, flags and rsegen\.with_c"
    ):
        replace(LOW, crossable_by="jackal:0.9")


@pytest.mark.slow
def test_maps_are_as_sure_as_asked() -> None:
    """Drives in MuJoCo tell it."""
    usual = replace(LOW, crossable_by="burger", unit_cm=0.4, seed=7)
    asked = rsegen.with_certainty(usual, 0.9)
    assert asked.crossable_room > 0, "as they are the maps are not sure enough"
    scene = compose(asked, 0)
    assert scene.field.levels.max() >= 4, "rough"
    told = predictions(ROBOTS["burger"], scene)
    assert set(told) == {"west_east", "south_north"}
    assert min(one.probability for one in told.values()) >= 0.9
