"""`rsegen.spawn`, `respawn` and `remove` in Python, in a world in memory, and in one of Gazebo Sim's transport."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import combinations
from math import cos, dist, hypot, sin
from pathlib import Path
from secrets import token_hex
from typing import Any, cast
from xml.etree import ElementTree

import pytest

import rsegen
from rsegen.errors import NothingRuns, OutputError, ParameterError, UnknownName
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.live_world import Clock, LiveWorld
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from rsegen.spawning.map_models import map_of
from rsegen.spawning.placement import SpawnedMap
from rsegen.spawning.spawning import _given_or_next, spawn_map
from tests.simulators.transport import NEEDS_ENGINE, connected_to
from tests.spawning.memory import MemoryWorld, changes

COURSE = rsegen.Recipe(name="course", seed=1, chunk_size=4, maps=3)


Poses = Callable[[], Mapping[str, Pose]]


@pytest.fixture(params=["memory", pytest.param("transport", marks=NEEDS_ENGINE)])
def poses(request: pytest.FixtureRequest) -> Poses:
    """Poses of the models in a running world: one in memory, or the transport of Gazebo Sim."""
    if request.param == "transport":
        address = request.getfixturevalue("sim_address")

        def asked() -> Mapping[str, Pose]:
            with connected_to(address) as live:
                return live.poses()

        return asked
    world: MemoryWorld = request.getfixturevalue("memory_world")
    return world.poses


@pytest.fixture
def memory_world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MemoryWorld:
    """A world in memory that `simulator="sim"` finds; the working folder is the test's own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GZ_PARTITION", f"test-{token_hex(4)}")  # an address of its own, as connections are kept
    world = MemoryWorld()
    monkeypatch.setattr(type(SIMULATORS["sim"]), "connect", lambda _, *where: world.connect(*where))
    return world


def test_a_recipe_and_a_robot_are_spawned_respawned_and_removed(poses: Poses) -> None:
    spawned = rsegen.spawn(COURSE, simulator="sim")
    assert (spawned.name, spawned.simulator, spawned.at) == ("course_0000", "sim", Pose(x=0, y=0, z=0))
    assert Path("worlds", "course_0000", "model.sdf").is_file()
    placed = rsegen.spawn(robot_of_kind("burger"), at=(0, 0), name="scout", simulator="sim")
    assert (placed.name, placed.put_on_top) == ("scout", ())
    assert placed.at.z > 0
    replaced = rsegen.respawn(COURSE, simulator="sim")
    assert (replaced.name, replaced.instead_of, replaced.put_on_top) == ("course_0001", "course_0000", ("scout",))
    assert set(poses()) == {"ground_plane", "scout", "course_0001"}
    removed = rsegen.remove("scout", "course_0001", "scout", simulator="sim")
    assert removed.removed == ("scout", "course_0001")
    assert set(poses()) == {"ground_plane"}


def test_a_scene_is_spawned_with_its_own_blocks(poses: Poses, tmp_path: Path) -> None:
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


def test_the_map_of_another_recipe_is_replaced(poses: Poses) -> None:
    rsegen.spawn(COURSE, simulator="sim", at=(1, 2))
    other = rsegen.respawn(replace(COURSE, name="other"), simulator="sim")
    assert (other.name, other.instead_of, other.at) == ("other_0000", "course_0000", Pose(x=1, y=2, z=0))
    assert set(poses()) == {"ground_plane", "other_0000"}


def test_the_only_map_of_a_folder_has_no_next_one(poses: Poses) -> None:
    (made,) = rsegen.generate(replace(COURSE, maps=1), "maps").maps
    rsegen.spawn(made.folder, simulator="sim")
    with pytest.raises(ParameterError, match=r"'course_0000' is in the simulation, and .* has no other map"):
        rsegen.respawn(made.folder, simulator="sim")


def test_an_index_that_several_maps_have_is_refused(poses: Poses) -> None:
    for name in ("course", "other"):
        rsegen.generate(replace(COURSE, name=name), "maps")
    with pytest.raises(ParameterError, match=r"^map: '0' may be course_0000 or other_0000; use the full name"):
        rsegen.spawn("maps", map=0, simulator="sim")
    assert rsegen.spawn("maps", map="other_0000", simulator="sim").name == "other_0000"


def test_a_robot_next_to_a_map_of_unknown_heights_has_a_note(poses: Poses) -> None:
    rsegen.spawn(COURSE, output="elsewhere", simulator="sim")
    Path("elsewhere").rename("moved")
    (note,) = rsegen.spawn("burger", simulator="sim").notes
    assert note.startswith("the heights of the blocks of course_0000 are unknown")
    assert rsegen.spawn("burger", name="second", output="moved", simulator="sim").notes == ()


@pytest.mark.parametrize("which", [1, "1", "course_0001"])
def test_a_map_of_a_folder_is_chosen_by_index_or_name(which: int | str, poses: Poses) -> None:
    rsegen.generate(COURSE, "maps")
    assert rsegen.spawn("maps", map=which, at=[3, 4, 0, 0.5], simulator="sim").at == Pose(x=3, y=4, z=0, yaw=0.5)
    assert set(poses()) == {"ground_plane", "course_0001"}
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
def test_wrong_values_name_the_parameter(target: Any, given: dict[str, Any], message: str, poses: Poses) -> None:
    with pytest.raises(ParameterError, match=f"^{message}"):
        rsegen.spawn(target, **given)


def test_a_model_that_does_not_exist_is_not_removed_nor_any_other(poses: Poses) -> None:
    rsegen.spawn("burger", simulator="sim")
    with pytest.raises(UnknownName, match="unknown model 'burgr'; did you mean 'burger'"):
        rsegen.remove("burger", "burgr", simulator="sim")
    assert set(poses()) == {"ground_plane", "burger"}
    with pytest.raises(ParameterError, match="names: no name"):
        rsegen.remove()


def test_nothing_running_is_an_error(programs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GAZEBO_MASTER_URI", "http://127.0.0.1:1")
    with pytest.raises(NothingRuns, match="no simulation runs"):
        rsegen.respawn(COURSE)


def test_the_next_map_of_an_example_is_the_one_after_the_current_one(tmp_path: Path) -> None:
    assert _given_or_next("mixed-course", None, tmp_path, "mixed-course_0001").name == "mixed-course_0002"
    assert _given_or_next("mixed-course", 0, tmp_path, "mixed-course_0001").name == "mixed-course_0000"


def test_a_robot_for_which_a_map_has_no_spot_stands_beside_it_and_that_is_said(poses: Poses) -> None:
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


def map_of_levels(name: str, *rows: str) -> rsegen.Recipe:
    """A recipe of a map with these blocks of 10 cm x 10 cm, in units of 5 cm; the last row is in the south."""
    return replace(
        COURSE, name=name, chunk_size=len(rows), unit_cm=5, boundary="none", obstacles=[rsegen.Matrix(rows=rows)]
    )


EVEN = map_of_levels("even", *["1 1 1 1 1 1"] * 6)
POST = map_of_levels("post", *["0 0 0 0 0 0"] * 2, "0 0 0 0 3 0", *["0 0 0 0 0 0"] * 3)
"""A post on x 10..20 cm, y 0..10 cm."""


@pytest.mark.parametrize("paused", [False, True])
def test_a_model_on_a_replaced_map_is_as_high_above_the_blocks_as_before(
    memory_world: MemoryWorld, paused: bool
) -> None:
    """The post is under a wheel of the Burger, whose middle is 6 cm away from it."""
    memory_world.paused = paused
    rsegen.spawn(EVEN, at=(1, 2), simulator="sim")
    rsegen.spawn("burger", at=(1.04, 2.05, 0.25, 0.7), simulator="sim")
    rsegen.spawn("burger", name="far", at=(5, 5, 0.01), simulator="sim")
    changes(memory_world)
    replaced = rsegen.respawn(POST, simulator="sim")
    assert replaced.put_on_top == ("burger",)
    ends = ([], []) if paused else (["pause"], ["unpause"])
    assert changes(memory_world) == [*ends[0], "spawn post_0000", "move burger", "delete even_0000", *ends[1]]
    at = memory_world.places["burger"]
    assert (at.x, at.y, at.yaw) == (1.04, 2.05, 0.7)
    assert at.z == pytest.approx(0.15 + 0.25 - 0.05 + DROP_HEIGHT)
    assert memory_world.places["far"] == Pose(x=5, y=5, z=0.01)
    assert memory_world.paused == paused


def test_a_map_spawned_around_a_robot_raises_it(memory_world: MemoryWorld) -> None:
    rsegen.spawn("burger", at=(1.04, 2.05, 0.01), simulator="sim")
    assert rsegen.spawn(POST, at=(1, 2), simulator="sim").put_on_top == ("burger",)
    assert memory_world.places["burger"].z == pytest.approx(0.15 + 0.01 + DROP_HEIGHT)


def test_a_robot_spawned_at_a_place_is_on_the_highest_block_under_it(poses: Poses) -> None:
    rsegen.spawn(POST, at=(1, 2), simulator="sim")
    assert rsegen.spawn("burger", at=(1.04, 2.05), simulator="sim").at.z == pytest.approx(0.15 + DROP_HEIGHT)
    assert rsegen.spawn("burger", at=(0.9, 1.9), name="low", simulator="sim").at.z == pytest.approx(DROP_HEIGHT)
    assert rsegen.spawn("burger", at=(1, 2, 3), name="high", simulator="sim").at == Pose(x=1, y=2, z=3)


@pytest.mark.slow
def test_robots_without_a_place_keep_apart(poses: Poses) -> None:
    """More of them than a map of 0.8 m has room for."""
    level = replace(COURSE, chunk_size=6)
    first = rsegen.spawn("burger", name="a", simulator="sim").at
    assert (first.x, first.y) == (0, 0)
    rsegen.spawn("burger", name="b", simulator="sim")
    rsegen.spawn(level, at=(5, 5), simulator="sim")
    on = [rsegen.spawn(level, robot="burger", name=name, simulator="sim").on for name in "cdef"]
    assert on[0] == "course_0000"
    assert None in on
    places = [poses()[name] for name in "abcdef"]
    radius = hypot(0.138, 0.178) / 2
    assert all(dist((a.x, a.y), (b.x, b.y)) > 2 * radius for a, b in combinations(places, 2))
    is_on = [abs(at.x - 5) < 0.4 and abs(at.y - 5) < 0.4 for at in places[2:]]
    assert is_on == [name is not None for name in on]


def test_a_robot_at_a_pose_of_a_turned_map_is_turned_with_it(poses: Poses) -> None:
    put = rsegen.spawn(EVEN, robot="burger", pose=(0.05, -0.02, 0.3), at=(2, 1, 0.4, 0.5), simulator="sim")
    assert (put.name, put.on) == ("burger", "even_0000")
    x, y = 2 + 0.05 * cos(0.5) + 0.02 * sin(0.5), 1 + 0.05 * sin(0.5) - 0.02 * cos(0.5)
    assert (put.at.x, put.at.y, put.at.yaw) == pytest.approx((x, y, 0.8))
    assert put.at.z == pytest.approx(0.4 + 0.05 + DROP_HEIGHT, abs=1e-4)
    assert poses()["burger"].x == pytest.approx(x)


def test_a_chosen_place_where_something_is_already_has_a_note(poses: Poses) -> None:
    rsegen.spawn(EVEN, simulator="sim")
    assert rsegen.spawn(EVEN, robot="burger", pose=(0, 0, 0), simulator="sim").notes == ()
    for notes in (
        rsegen.spawn(EVEN, robot="burger", pose=(0.05, 0, 0), name="b", simulator="sim").notes,
        rsegen.spawn("burger", at=(0, 0.05, poses()["burger"].z), name="c", simulator="sim").notes,
    ):
        assert "the origin of burger is 0.05 m away" in [note.split(";")[0] for note in notes]
    assert rsegen.spawn("burger", at=(0, 0, 3), name="high", simulator="sim").notes == ()
    over = rsegen.spawn(POST, at=(0.1, 0), simulator="sim")
    assert over.notes == ("post_0000 is over the ground of even_0000, so their blocks may be inside each other",)
    assert rsegen.spawn(POST, name="beside", at=(9, 0), simulator="sim").notes == ()


def test_a_pose_at_which_a_robot_tips_over_is_refused(memory_world: MemoryWorld) -> None:
    with pytest.raises(ParameterError, match=r"^pose: burger tips over at"):
        rsegen.spawn(POST, robot="burger", pose=(0.1, 0.05, 0), simulator="sim")
    assert not changes(memory_world)


def test_a_map_in_the_simulation_is_neither_moved_nor_taken_for_another(memory_world: MemoryWorld) -> None:
    rsegen.spawn(EVEN, simulator="sim")
    with pytest.raises(ParameterError, match=r"^at: even_0000 is in the simulation already"):
        rsegen.spawn(EVEN, robot="burger", at=(5, 5), simulator="sim")
    other = replace(POST, name="even")
    with pytest.raises(ParameterError, match=r"^even_0000 in the simulation has other blocks"):
        rsegen.spawn(other, robot="burger", output="elsewhere", simulator="sim")
    assert memory_world.places.keys() == {"ground_plane", "even_0000"}


def test_the_map_to_replace_is_chosen_by_its_name(memory_world: MemoryWorld) -> None:
    for recipe in (EVEN, POST):
        rsegen.spawn(recipe, simulator="sim")
    with pytest.raises(
        ParameterError, match=r"^name: several maps could be replaced; choose one of even_0000, post_0000"
    ):
        rsegen.respawn(COURSE, simulator="sim")
    with pytest.raises(ParameterError, match=r"^name: no model 'evn' in the simulation"):
        rsegen.respawn(COURSE, name="evn", simulator="sim")
    assert rsegen.respawn(COURSE, name="post_0000", simulator="sim").instead_of == "post_0000"
    assert memory_world.places.keys() == {"ground_plane", "even_0000", "course_0000"}


def test_a_map_of_many_models_is_refused(memory_world: MemoryWorld) -> None:
    many = replace(COURSE, mesh_type="multi")
    with pytest.raises(ParameterError, match=r"^mesh_type: multi makes a map of many models"):
        rsegen.spawn(many, simulator="sim")
    rsegen.spawn(EVEN, simulator="sim")
    with pytest.raises(ParameterError, match=r"^mesh_type: multi makes a map of many models"):
        rsegen.respawn(many, simulator="sim")
    assert memory_world.places.keys() == {"ground_plane", "even_0000"}


def test_an_example_is_spawned_by_its_name(memory_world: MemoryWorld) -> None:
    assert rsegen.spawn("peak", simulator="sim").name == "peak_0000"


def test_of_several_maps_that_of_the_same_recipe_is_replaced(memory_world: MemoryWorld) -> None:
    """Also if its folder is not found: then its blocks are those of the recipe."""
    rsegen.spawn(EVEN, simulator="sim")
    rsegen.spawn(COURSE, simulator="sim")
    assert rsegen.respawn(COURSE, simulator="sim").instead_of == "course_0000"
    Path("worlds").rename("moved")
    assert rsegen.respawn(COURSE, simulator="sim").instead_of == "course_0001"
    assert memory_world.places.keys() == {"ground_plane", "even_0000", "course_0002"}


def test_a_folder_with_a_different_map_is_not_taken_for_the_recipe_s(memory_world: MemoryWorld) -> None:
    rsegen.spawn(EVEN, simulator="sim")
    rsegen.remove("even_0000", simulator="sim")
    with pytest.raises(OutputError, match="even_0000: exists already and is a different map"):
        rsegen.spawn(replace(POST, name="even"), simulator="sim")
    assert memory_world.places.keys() == {"ground_plane"}
