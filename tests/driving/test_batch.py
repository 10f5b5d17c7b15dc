"""Drives over many maps in a batch simulator: what each does, what is refused, and that they are those of one world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.driving.planning import required_simulator
from rsegen.driving.recording import record_batch, record_embedded
from rsegen.driving.robot_runs import robot_runs
from rsegen.errors import NoSimulator, ParameterError, SimulatorFailed, UnknownName
from rsegen.field.stepfield import Array
from rsegen.robots.lookup import robot_of
from rsegen.scene.scene import compose
from rsegen.simulators.batch import BATCH, BatchSimulator, BatchWorlds
from rsegen.simulators.embedded import EMBEDDED
from tests.support.late_import import LateImport

pytestmark = pytest.mark.skipif(not BATCH or not EMBEDDED, reason="the capability mujoco is not here")
many_maps = LateImport("rsegen.mujoco.many_maps", reason="mujoco_warp is not installed")
RUBBLE = rsegen.Recipe(
    name="rubble", seed=7, boundary="none", chunk_size=4, maps=5, obstacles=[rsegen.Random(levels=4)]
)
FASTER = 2.0
"""Times its speed that a robot goes here: with three times it would be impossible."""


class _Sliding(BatchWorlds):
    """Worlds in which robots go where they are told, the third farther; the second one sinks in after a second."""

    step_seconds = 0.001

    def __init__(self, starts: Array) -> None:
        self.at, self.second = starts, 0.0
        self.v = np.zeros(len(starts))

    def poses(self) -> Array:
        return self.at.copy()

    def drive(self, v: Array, w: Array) -> None:
        assert not w.any(), "they are on their lines"
        self.v = FASTER * v

    def step(self, steps: int) -> None:
        self.second += steps * self.step_seconds
        self.at[:, 0] += self.v * steps * self.step_seconds * np.where(np.arange(len(self.at)) == 2, 1.4, 1)

    def problems(self) -> Mapping[int, str]:
        return {1: "it sank in"} if self.second > 0.99 and len(self.at) > 2 else {}


class _Simulator(BatchSimulator):
    """A batch of three worlds."""

    name, title = "mujoco-warp", "Three worlds"

    def __init__(self) -> None:
        self.batches: list[list[int]] = []

    def refuse_missing(self) -> None:
        pass

    def size(self, recipe: rsegen.Recipe) -> int:
        return 3

    def worlds(self, scenes: Any, robots: Any, *, motors: str = "") -> BatchWorlds:
        self.batches.append([scene.index for scene in scenes])
        return _Sliding(np.array([[run.start.x, run.start.y, run.start.z, 0, 0, 0] for run in robots]))


@pytest.fixture
def simulator(monkeypatch: pytest.MonkeyPatch) -> _Simulator:
    known = _Simulator()
    monkeypatch.setattr("rsegen.simulators.batch.BATCH", {known.name: known})
    return known


def test_maps_are_driven_in_batches_and_each_drive_ends_by_itself(simulator: _Simulator) -> None:
    told: list[int] = []
    result = rsegen.drive_many(RUBBLE, simulator="mujoco-warp", duration=5, progress=told.append)
    assert simulator.batches == [[0, 1, 2], [3, 4]]
    assert told == [3, 2]
    assert result.simulator == "Three worlds"
    assert [drive.map for drive in result.drives] == [0, 1, 2, 3, 4]
    assert (result.counted, result.crossed) == (4, 4)
    failed = result.drives[1].failed
    assert failed == "Three worlds: after 1 s it sank in, so this drive has no result"
    # A route ends where it decides, twice a second, once it is at its goal; the quicker robot does so earlier.
    slow, _, quick, *_ = result.drives
    assert slow.crossed is not None
    assert quick.crossed is not None
    assert slow.crossed > quick.crossed > 0
    assert quick.seconds < slow.seconds < 5
    assert all(drive.seconds % 0.5 == pytest.approx(0) for drive in result.drives if not drive.failed)


def test_a_drive_lasts_as_long_as_asked_for(simulator: _Simulator) -> None:
    result = rsegen.drive_many(RUBBLE, maps=1, simulator="mujoco-warp", duration=0.13)
    assert result.drives[0].seconds == pytest.approx(0.13)
    assert result.drives[0].distance == pytest.approx(FASTER * robot_of("burger").driving_speed * 0.13, abs=5e-4)


def test_a_drive_that_cannot_begin_has_no_result(simulator: _Simulator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_Sliding, "problems", lambda self: {0: "it was inside a block"} if self.second == 0 else {})
    result = rsegen.drive_many(RUBBLE, maps=2, simulator="mujoco-warp", duration=1)
    assert [drive.failed for drive in result.drives] == [
        "Three worlds: after 0 s it was inside a block, so this drive has no result",
        "",
    ]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"route": "way"}, "route: 'way' needs simulator='mujoco'; mujoco-warp drives straight"),
        ({"route": "random"}, "route: 'random' needs simulator='mujoco'"),
        ({"workers": 2}, "workers: is for simulator='mujoco'; mujoco-warp makes all drives in one process"),
        ({"scheduler": "tcp://here:1"}, "scheduler: is for simulator='mujoco'"),
    ],
)
def test_what_a_batch_cannot_do_is_refused(simulator: _Simulator, given: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        rsegen.drive_many(RUBBLE, simulator="mujoco-warp", **given)
    assert not simulator.batches


def test_a_shell_does_not_share_out_a_batch(
    simulator: _Simulator, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    flags = ["--obstacle", "random levels=3", "--maps", "2", "--simulator", "mujoco-warp", "-o", str(tmp_path / "out")]
    assert main(["drives", *flags]) == 0
    assert "in Three worlds, straight" in capsys.readouterr().out
    assert main(["drives", *flags, "--force", "--route", "way"]) == 2
    assert "--route: 'way' needs --simulator mujoco" in capsys.readouterr().err


def test_gazebo_drives_over_one_map_at_a_time() -> None:
    with pytest.raises(UnknownName, match="mujoco-warp"):
        rsegen.drive_many(RUBBLE, simulator="classic")


def test_without_the_extra_one_line_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    from rsegen.mujoco import batch_simulator

    monkeypatch.setattr(batch_simulator, "find_spec", lambda name: None)
    with pytest.raises(NoSimulator, match=r"^MuJoCo Warp is not installed; to install it: .* -m pip install ") as error:
        rsegen.drive_many(RUBBLE, simulator="mujoco-warp")
    assert "\n" not in str(error.value)


def test_maps_that_are_too_large_or_of_several_frictions_are_refused() -> None:
    warp = BATCH["mujoco-warp"]
    with pytest.raises(ParameterError, match="level_friction: mujoco-warp has maps of one friction"):
        warp.size(replace(RUBBLE, level_friction=(0.5, 0.7, 0.9)))
    with pytest.raises(ParameterError, match="chunks: 80 x 80 blocks; mujoco-warp has up to 4000"):
        warp.size(replace(RUBBLE, chunks=(20, 20)))


class _Watched(BatchWorlds):
    """Worlds that count in which steps robots touch blocks."""

    def __init__(self, worlds: Any) -> None:
        self.worlds, self.step_seconds = worlds, worlds.step_seconds  # type: ignore[misc]  # as the worlds have it
        self.touches = np.zeros(worlds.many.worlds, dtype=int)

    def poses(self) -> Array:
        return self.worlds.poses()  # type: ignore[no-any-return]

    def drive(self, v: Array, w: Array) -> None:
        self.worlds.drive(v, w)

    def step(self, steps: int) -> None:
        self.worlds.step(steps)
        self.touches += self.worlds.many.touches(self.worlds.blocks).numpy() > 0

    def problems(self) -> Mapping[int, str]:
        return self.worlds.problems()  # type: ignore[no-any-return]


@pytest.mark.long(reason="Warp, 0.4 GB, which compiles its kernels")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "unit", "width", "boundary"),
    [("jackal", 2, 10, "none"), ("burger", 0.5, 5, "none"), ("crawler", 3, 10, "outer")],
)
def test_drives_are_within_a_millimetre_of_those_of_one_world(
    robot: str, unit: float, width: float, boundary: str
) -> None:
    recipe = replace(RUBBLE, unit_cm=unit, block_width_cm=width, boundary=boundary, maps=3)
    scenes, driven = [compose(recipe, index) for index in recipe.indices], robot_of(robot)
    runs = [robot_runs(scene.field, driven, "straight", count=1, seed=0)[0] for scene in scenes]
    worlds = _Watched(many_maps.ManyMaps(scenes, runs, "reaction"))
    made = record_batch("MuJoCo Warp", worlds, runs, 1.0)

    assert (worlds.touches > 0).all(), "each robot has touched blocks"
    boxes = worlds.worlds.many.model.geom_size.numpy()[:, worlds.worlds.blocks]
    assert np.ptp(boxes, axis=0).max() > 0, "each world has its own map"
    apart = []
    for scene, run, recording in zip(scenes, runs, made, strict=True):
        assert not isinstance(recording, SimulatorFailed)
        own = record_embedded(required_simulator("this needs"), scene, [run], 1.0, contacts=False)
        one, many = own.trajectories[run.name].rows, recording.trajectories[run.name].rows
        assert many[:, 0] == pytest.approx(one[:, 0])
        assert one[-1, 1] - one[0, 1] > 0.5 * driven.driving_speed
        apart.append(np.linalg.norm(many[:, 1:4] - one[:, 1:4], axis=1).max())
    assert np.median(apart) < 0.001, "mostly: a contact at an edge makes any difference grow"
    assert max(apart) < 0.003


@pytest.mark.long(reason="Warp, 0.4 GB, which compiles its kernels")
@pytest.mark.slow
def test_a_robot_that_starts_inside_a_block_does_not_drive() -> None:
    scenes, driven = [compose(RUBBLE, index) for index in (0, 1)], robot_of("jackal")
    runs = [robot_runs(scene.field, driven, "straight", count=1, seed=0)[0] for scene in scenes]
    middle_x, middle_y = scenes[1].field.middles()
    on_map = replace(runs[1].start, x=float(middle_x[2]), y=float(middle_y[2]))
    assert scenes[1].field.levels[1:4, 1:4].max() > 0
    runs[1] = replace(runs[1], start=on_map)
    with pytest.raises(SimulatorFailed, match="inside each other"):
        record_embedded(required_simulator("this needs"), scenes[1], [runs[1]], 1.0, contacts=False)
    beside, inside = record_batch("Warp", many_maps.ManyMaps(scenes, runs, "reaction"), runs, 0.1)
    assert not isinstance(beside, SimulatorFailed)
    assert str(inside) == "Warp: after 0 s it was inside a block, so this drive has no result"
