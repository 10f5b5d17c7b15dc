"""`rsegen.spawn`, `respawn` and `remove` in Python, in a world of Gazebo Sim's transport."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast
from xml.etree import ElementTree

import pytest

import rsegen
from rsegen.errors import NothingRuns, ParameterError, UnknownName
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.live_world import Clock, LiveWorld
from rsegen.simulators.poses import Pose
from rsegen.spawning.map_models import map_of
from rsegen.spawning.placement import SpawnedMap
from rsegen.spawning.spawning import _given_or_next, spawn_map
from tests.simulators.transport import connected_to

COURSE = rsegen.Recipe(name="course", seed=1, chunk_size=4, maps=3)


def models(address: Mapping[str, str]) -> set[str]:
    with connected_to(address) as live:
        return set(live.poses())


def test_a_recipe_and_a_robot_are_spawned_respawned_and_removed(sim_address: Mapping[str, str]) -> None:
    spawned = rsegen.spawn(COURSE, simulator="sim")
    assert (spawned.name, spawned.simulator, spawned.at) == ("course_0000", "sim", Pose(x=0, y=0, z=0))
    assert Path("worlds", "course_0000", "model.sdf").is_file()
    placed = rsegen.spawn(robot_of_kind("burger"), at=(0, 0), name="scout", simulator="sim")
    assert (placed.name, placed.put_on_top) == ("scout", ())
    assert placed.at.z > 0
    replaced = rsegen.respawn(COURSE, simulator="sim")
    assert (replaced.name, replaced.instead_of, replaced.put_on_top) == ("course_0001", "course_0000", ("scout",))
    assert models(sim_address) == {"ground_plane", "scout", "course_0001"}
    removed = rsegen.remove("scout", "course_0001", "scout", simulator="sim")
    assert removed.removed == ("scout", "course_0001")
    assert models(sim_address) == {"ground_plane"}


def test_a_scene_is_spawned_with_its_own_blocks(sim_address: Mapping[str, str], tmp_path: Path) -> None:
    scene = rsegen.compose(COURSE, 2)
    assert rsegen.spawn(scene, output=tmp_path / "own", simulator="sim").name == "course_0002"
    assert (tmp_path / "own" / "course_0002" / "recipe.json").is_file()


def test_a_folder_of_any_name_is_in_the_model_that_is_sent(tmp_path: Path) -> None:
    output = tmp_path / "R&D <1>"
    output.mkdir()
    model = map_of(replace(COURSE, obstacles=[rsegen.Random(levels=3)]), None, output)
    uris = {uri.text for uri in ElementTree.fromstring(model.sdf("track")).iter("uri")}
    assert uris
    assert all(Path(uri or "").is_relative_to(output / "course_0000") and Path(uri or "").is_file() for uri in uris)


def test_the_map_of_another_recipe_is_replaced(sim_address: Mapping[str, str]) -> None:
    rsegen.spawn(COURSE, simulator="sim", at=(1, 2))
    other = rsegen.respawn(replace(COURSE, name="other"), simulator="sim")
    assert (other.name, other.instead_of, other.at) == ("other_0000", "course_0000", Pose(x=1, y=2, z=0))
    assert models(sim_address) == {"ground_plane", "other_0000"}


def test_the_only_map_of_a_folder_has_no_next_one(sim_address: Mapping[str, str]) -> None:
    (made,) = rsegen.generate(replace(COURSE, maps=1), "maps").maps
    rsegen.spawn(made.folder, simulator="sim")
    with pytest.raises(ParameterError, match=r"'course_0000' is in the simulation, and .* has no other map"):
        rsegen.respawn(made.folder, simulator="sim")


def test_an_index_that_several_maps_have_is_refused(sim_address: Mapping[str, str]) -> None:
    for name in ("course", "other"):
        rsegen.generate(replace(COURSE, name=name), "maps")
    with pytest.raises(ParameterError, match=r"^map: '0' may be course_0000 or other_0000; use the full name"):
        rsegen.spawn("maps", map=0, simulator="sim")
    assert rsegen.spawn("maps", map="other_0000", simulator="sim").name == "other_0000"


def test_a_robot_next_to_a_map_of_unknown_heights_has_a_note(sim_address: Mapping[str, str]) -> None:
    rsegen.spawn(COURSE, output="elsewhere", simulator="sim")
    (note,) = rsegen.spawn("burger", simulator="sim").notes
    assert note.startswith("the heights of the blocks of course_0000 are unknown")
    assert rsegen.spawn("burger", name="second", output="elsewhere", simulator="sim").notes == ()


@pytest.mark.parametrize("which", [1, "1", "course_0001"])
def test_a_map_of_a_folder_is_chosen_by_index_or_name(which: int | str, sim_address: Mapping[str, str]) -> None:
    rsegen.generate(COURSE, "maps")
    assert rsegen.spawn("maps", map=which, at=[3, 4, 0, 0.5], simulator="sim").at == Pose(x=3, y=4, z=0, yaw=0.5)
    assert models(sim_address) == {"ground_plane", "course_0001"}
    assert rsegen.respawn(Path("maps"), simulator="sim").name == "course_0002"
    assert rsegen.respawn("maps", simulator="sim").name == "course_0000"


@pytest.mark.parametrize(
    ("target", "given", "message"),
    [
        ("burger", {"map": 1}, "map: burger is a robot and has no maps"),
        ("burger", {"at": [1]}, r"at: \[1\] is not X,Y or"),
        ("burger", {"at": [1, "here"]}, r"at\[1\]: 'here' is not a number"),
        ("burger", {"name": "../b"}, "name: .*'../b'"),
        ("burger", {"simulator": "clasic"}, "simulator: unknown simulator 'clasic'"),
        ("burger", {"name": "ground_plane", "simulator": "sim"}, "name: 'ground_plane' exists already"),
        (COURSE, {"map": 9}, "map: there is no map 9"),
        (COURSE, {"pose": (0, 0, 0)}, "pose: is the place of a robot on a map; set robot too"),
        ("burger", {"robot": "crawler"}, "robot: burger is a robot already; pass the map"),
        (COURSE, {"robot": "crawlr"}, "robot: unknown robot 'crawlr'; did you mean 'crawler'"),
        (COURSE, {"robot": "burger", "pose": (9, 0, 0), "simulator": "sim"}, r"pose\[0\]: 9 m is outside the field"),
        ("burgr", {}, "unknown folder, recipe, example or robot 'burgr'; did you mean 'burger'"),
    ],
)
def test_wrong_values_name_the_parameter(
    target: Any, given: dict[str, Any], message: str, sim_address: Mapping[str, str]
) -> None:
    with pytest.raises(ParameterError, match=f"^{message}"):
        rsegen.spawn(target, **given)


def test_a_model_that_does_not_exist_is_not_removed_nor_any_other(sim_address: Mapping[str, str]) -> None:
    rsegen.spawn("burger", simulator="sim")
    with pytest.raises(UnknownName, match="unknown model 'burgr'; did you mean 'burger'"):
        rsegen.remove("burger", "burgr", simulator="sim")
    assert models(sim_address) == {"ground_plane", "burger"}
    with pytest.raises(ParameterError, match="names: no name"):
        rsegen.remove()


def test_nothing_running_is_an_error(programs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GAZEBO_MASTER_URI", "http://127.0.0.1:1")
    with pytest.raises(NothingRuns, match="no simulation runs"):
        rsegen.respawn(COURSE)


def test_the_next_map_of_an_example_is_the_one_after_the_current_one(tmp_path: Path) -> None:
    assert _given_or_next("mixed-course", None, tmp_path, "mixed-course_0001").name == "mixed-course_0002"
    assert _given_or_next("mixed-course", 0, tmp_path, "mixed-course_0001").name == "mixed-course_0000"


def test_a_robot_for_which_a_map_has_no_spot_stands_beside_it_and_that_is_said(sim_address: Mapping[str, str]) -> None:
    posts = rsegen.Matrix(rows=("8 0 8 0", "0 8 0 8", "8 0 8 0", "0 8 0 8"))
    put = rsegen.spawn(replace(COURSE, obstacles=[posts]), robot="jackal", simulator="sim")
    assert put.on is None
    assert (
        "course_0000 has no free spot for jackal, which is put next to it; to put it on the map, set pose="
        in put.notes[1]
    )
    even = rsegen.spawn(replace(COURSE, name="even", chunk_size=10), robot="burger", simulator="sim")
    assert (even.on, len(even.notes)) == ("even_0000", 1)


class Interrupted:
    """A world in which Ctrl-C comes when it has been ordered to pause, before it says that it has."""

    paused = False

    def clock(self) -> Clock:
        return Clock(simulated=0.0, real=0.0, steps=0, paused=self.paused)

    def pause(self) -> None:
        self.paused = True
        raise KeyboardInterrupt

    def unpause(self) -> None:
        self.paused = False


def test_ctrl_c_while_a_map_is_spawned_leaves_the_world_running() -> None:
    field = rsegen.build(rsegen.Recipe(seed=1))
    live = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        spawn_map(cast("LiveWorld", live), "", SpawnedMap(name="map", field=field, at=Pose(x=0, y=0, z=0)))
    assert not live.paused
