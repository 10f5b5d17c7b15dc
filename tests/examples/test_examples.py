"""The scripts of examples/, each run in an empty folder: it writes and prints what it says."""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import rsegen
from rsegen.rating.rating import Rating

ROOT = Path(__file__).parents[2]
EXAMPLES = {path.stem: path for path in sorted((ROOT / "examples").glob("*.py"))}

Run = Callable[[str], str]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    monkeypatch.chdir(tmp_path)

    def printed(name: str) -> str:
        runpy.run_path(str(EXAMPLES[name]), run_name="__main__")
        return capsys.readouterr().out

    return printed


def written() -> set[str]:
    return {path.name for path in Path().iterdir() if not path.name.startswith(".")}


def test_a_field_and_its_numbers(run: Run) -> None:
    out = run("a_field_and_its_numbers")
    assert len(re.findall(r"^ ?\[+[\d ]+\]+$", out, re.MULTILINE)) == 10
    assert re.search(r"rms step 0\.\d{3} m; \d+% of the steps", out)
    assert re.search(r"reaches \d+% of the cells", out)
    assert Path("field.png").read_bytes().startswith(b"\x89PNG")


def test_a_world_for_gazebo(run: Run) -> None:
    out = run("a_world_for_gazebo")
    folders = [Path(line) for line in out.splitlines()]
    assert [folder.name for folder in folders] == ["course_0000", "course_0001"]
    assert all((folder / f"{folder.name}.world").is_file() for folder in folders)


def test_an_obstacle_of_your_own(run: Run) -> None:
    (levels,) = run("an_obstacle_of_your_own").splitlines()
    assert levels == "[0 1 2 2 1 0 1 2 2 1]"


def test_very_many_maps(run: Run) -> None:
    assert "10000 maps in rubble/; number 1234 again: True" in run("very_many_maps")
    rsegen.verify("rubble")
    assert written() == {"rubble"}


def test_blocks_in_mujoco(run: Run) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    heights = [float(number) for number in re.findall(r"\d\.\d+", run("blocks_in_mujoco"))]
    assert heights == pytest.approx([0.32, 0.02], abs=0.002)  # three blocks and none, and the radius of a ball


def test_a_scan_measured(run: Run) -> None:
    wrong, forgotten = re.findall(r": \[?(\[\d, \d\])", run("a_scan_measured"))
    assert wrong == forgotten
    assert written() == {"pallet.xyz", "changes.png"}


def test_a_build_sheet(run: Run) -> None:
    assert "# cut: 19 blocks of 10 cm" in run("a_build_sheet")
    assert Path("pallet.pdf").read_bytes().startswith(b"%PDF")
    assert written() == {"pallet.pdf", "pallet.csv"}


def test_a_robot_on_the_blocks(run: Run) -> None:
    out = run("a_robot_on_the_blocks")
    assert re.search(r"stands at \d+% of the places, tilted by \d\.\d degrees", out)
    assert len(re.findall(r"a start at x = -?0\.\d\d, y = -?0\.\d\d m", out)) == 2


@pytest.mark.slow
def test_a_policy_rated(run: Run) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    out = run("a_policy_rated")
    level = re.search(r"policy crosses half of normal-random fields .*? at a unit of (\d\.\d+) cm .* 40 trials", out)
    assert level
    assert 1.5 < float(level[1]) < 3.5  # of 10 fields at 2 and at 3 cm, it crosses 9 and 2
    assert written() == set()


@pytest.mark.slow
def test_a_gymnasium_policy_rated(run: Run) -> None:
    pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    out = run("a_gymnasium_policy_rated")
    level = re.search(r"ant crosses half of ant-blocks fields .*? at a unit of (\d\.\d+) cm .* 24 trials", out)
    assert level
    assert 3 < float(level[1]) < 7  # of 4 fields at 3 and at 10 cm, it crosses 4 and none
    assert written() == set()


@pytest.mark.slow
def test_the_ant_walks_on_the_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
    example = runpy.run_path(str(EXAMPLES["a_gymnasium_policy_rated"]))
    touched, step = set[str](), mujoco.mj_step

    def watched(model: Any, data: Any, *others: Any, **named: Any) -> None:
        step(model, data, *others, **named)
        touched.update(model.geom(geom).name for geom in set(data.contact.geom.ravel().tolist()))

    monkeypatch.setattr(mujoco, "mj_step", watched)
    assert example["ant"](rsegen.build(replace(example["BLOCKS"], seed=3, unit_cm=1)), 0)
    assert len([name for name in touched if name.startswith("rse_0000_")]) > 8, touched


@pytest.mark.long
def test_a_ros_stack_rated(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    from rsegen.training.gymnasium import CrossingEnv

    alone = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
      </General><Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address="localhost"/></Peers>
      </Discovery></Domain></CycloneDDS>"""
    monkeypatch.setenv("CYCLONEDDS_URI", alone)
    monkeypatch.setenv("ROS_DOMAIN_ID", str(os.getpid() % 100))
    touches, step = [], CrossingEnv.step

    def watched(self: CrossingEnv, action: Any) -> Any:
        touches.append((result := step(self, action))[4]["touches"])
        return result

    monkeypatch.setattr(CrossingEnv, "step", watched)
    example = runpy.run_path(str(EXAMPLES["a_ros_stack_rated"]))
    drives = example["RosStack"]()
    with subprocess.Popen([sys.executable, str(EXAMPLES["a_ros_stack_rated"]), "--stack"]) as stack:
        try:
            assert drives(rsegen.build(replace(example["RUBBLE"], unit_cm=0.5)), 0)
            assert max(touches) > 1  # wheels on blocks
            assert not drives(rsegen.build(replace(example["RUBBLE"], unit_cm=10)), 0)
            rating = rsegen.rate(drives, example["RUBBLE"], seed=7, trials=8)
            assert isinstance(rating, Rating)
            assert {trial.crossed for trial in rating.curves[0].trials} == {True, False}
        finally:
            stack.terminate()
    monkeypatch.setitem(example["RosStack"].command_at.__globals__, "PATIENCE", 0.5)
    with pytest.raises(SystemExit, match="nothing answers /odom with /cmd_vel"):
        drives(rsegen.build(example["RUBBLE"]), 0)


def test_messages_of_the_ros_example_are_those_of_ros() -> None:
    pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
    typesys = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed")
    example, store = (
        runpy.run_path(str(EXAMPLES["a_ros_stack_rated"])),
        typesys.get_typestore(typesys.Stores.ROS2_HUMBLE),
    )
    stamp = example["Time"](7, 5)
    pose = example["Pose"](example["Point"](1.0, 2.0, 3.0), example["Quaternion"](0.1, 0.2, 0.3, 0.9))
    whole = example["Odometry"](
        example["Header"](stamp, "odom"),
        "base_link",
        example["PoseCovariance"](pose, [*map(float, range(36))]),
        example["TwistCovariance"](example["twist"](0.4, -0.2), [0.5] * 36),
    )
    assert example["Odometry"].__idl_typename__ == "nav_msgs.msg.dds_.Odometry_"
    read = store.deserialize_cdr(whole.serialize(), "nav_msgs/msg/Odometry")
    assert (read.header.stamp.sec, read.header.frame_id, read.child_frame_id) == (7, "odom", "base_link")
    assert (read.pose.pose.position.z, read.pose.pose.orientation.w) == (3.0, 0.9)
    assert read.pose.covariance.tolist() == list(range(36))
    assert (read.twist.twist.linear.x, read.twist.twist.angular.z) == (0.4, -0.2)
    clock = store.deserialize_cdr(example["Clock"](stamp).serialize(), "rosgraph_msgs/msg/Clock")
    assert (clock.clock.sec, clock.clock.nanosec) == (7, 5)
    told = store.deserialize_cdr(example["twist"](0.4, -0.2).serialize(), "geometry_msgs/msg/Twist")
    assert (told.linear.x, told.angular.z) == (0.4, -0.2)


def test_every_example_is_run_here() -> None:
    tests = {name.removeprefix("test_") for name in globals()}
    assert EXAMPLES
    assert set(EXAMPLES) <= tests
