"""The scripts of examples/, each run in an empty folder: it writes and prints what it says."""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

import rsegen
from rsegen.rating.rating import Rating
from tests.support.missing import missing

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


@pytest.mark.long(reason="it drives eight times, each step answered by another process: 20 s of CPU")
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
            rating = rsegen.rate(drives, example["RUBBLE"], seed=7, trials=8)
            assert isinstance(rating, Rating)
            lowest, *_, highest = sorted(rating.curves[0].trials, key=lambda trial: trial.level)
            assert lowest.crossed
            assert not highest.crossed
            assert max(touches) > 1  # wheels on blocks
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


@pytest.fixture
def mjlab(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of the package mjlab, which the example finds; what mjlab needs for training is not there."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    folder = Path(sys.prefix) / "mjlab"
    if not (folder / "mjlab").is_dir():
        missing(f"no mjlab in {folder}: make learners puts it there")
    monkeypatch.syspath_prepend(folder)
    yield folder / "mjlab"
    for name in [name for name in sys.modules if name.startswith("mjlab.")]:
        monkeypatch.delitem(sys.modules, name)


@pytest.mark.long(reason="needs mjlab")
@pytest.mark.slow
@pytest.mark.usefixtures("mjlab")
def test_a_legged_robot_rated(run: Run) -> None:
    out = run("a_legged_robot_rated")
    number = r"(\d+\.?\d*)"
    interval = rf"at a unit of {number} cm \[{number}, {number}\]"
    level = re.search(rf"go1 crosses half of go1-blocks fields .*? {interval}, .* 40 trials", out)
    assert level, out
    half, low, high = map(float, level.groups())
    assert low < half < high
    assert 2 < half < 5  # of 10 fields at 2 and at 5 cm, it crosses 9 and 1
    assert written() == set()


def test_a_legged_robot_without_mjlab_says_what_to_install(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    monkeypatch.setitem(sys.modules, "mjlab", None)
    with pytest.raises(SystemExit, match=r"^mjlab is not installed: pip install --no-deps mjlab$"):
        run("a_legged_robot_rated")


@dataclass
class Walk:
    """A trial of Go1: its way and time, how many contacts with blocks it had, and on which ones its feet were."""

    crossed: bool = False
    metres: float = 0.0
    seconds: float = 0.0
    contacts: int = 0
    trodden: set[str] = field(default_factory=set)


@pytest.fixture
def walk(mjlab: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[float, int], Walk]:
    """A trial of the example on the field of a unit [cm] and a seed, of which every step of MuJoCo is looked at."""
    import mujoco

    example, step = runpy.run_path(str(EXAMPLES["a_legged_robot_rated"])), mujoco.mj_step

    def walked(unit_cm: float, seed: int) -> Walk:
        made = Walk()

        def watched(model: Any, data: Any, *others: Any) -> None:
            before = float(data.qpos[0])
            step(model, data, *others)
            made.metres, made.seconds = made.metres + float(data.qpos[0]) - before, float(data.time)
            for one, other in data.contact.geom.tolist():
                names = sorted((model.geom(one).name, model.geom(other).name))
                block = next((name for name in names if name.startswith("rse_0000_")), None)
                made.contacts += block is not None
                if block and names[0].endswith("_foot_collision"):
                    made.trodden.add(block)

        monkeypatch.setattr(mujoco, "mj_step", watched)
        steps = rsegen.build(replace(example["BLOCKS"], seed=seed, unit_cm=unit_cm or 1))
        made.crossed = example["go1"](steps if unit_cm else replace(steps, levels=0 * steps.levels), seed)
        return made

    return walked


@pytest.mark.long(reason="needs mjlab")
@pytest.mark.slow
def test_go1_walks_over_level_fields_from_every_start(walk: Callable[[float, int], Walk]) -> None:
    for seed in range(10):
        made = walk(0, seed)
        assert made.crossed, seed
        assert made.contacts == 0
        assert made.metres > 2.8  # 0.6 m before the field, 2 m of it, and 0.3 m
        assert made.metres / made.seconds > 0.2


@pytest.mark.long(reason="needs mjlab")
@pytest.mark.slow
def test_go1_walks_on_low_blocks_and_does_not_cross_high_ones(walk: Callable[[float, int], Walk]) -> None:
    for seed in range(5):
        low, high = walk(1, seed), walk(12, seed)
        assert low.crossed, seed
        assert len(low.trodden) > 8, low.trodden
        assert not high.crossed, seed
        assert high.contacts > 0


@pytest.mark.long(reason="needs mjlab")
def test_go1_s_motors_and_its_stance_are_those_of_mjlab(mjlab: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = runpy.run_path(str(EXAMPLES["a_legged_robot_rated"]))
    model = example["robot"]().compile()

    class Values(SimpleNamespace):
        """Values that mjlab's classes of settings are given."""

    package, actuator, entity = (ModuleType(name) for name in ("mjlab", "mjlab.actuator", "mjlab.entity"))
    package.__path__, package.MJLAB_SRC_PATH = [str(mjlab)], mjlab  # type: ignore[attr-defined]
    actuator.BuiltinPositionActuatorCfg = Values  # type: ignore[attr-defined]
    entity.EntityArticulationInfoCfg = Values  # type: ignore[attr-defined]
    entity.EntityCfg = SimpleNamespace(InitialStateCfg=Values)  # type: ignore[attr-defined]
    for module in (package, actuator, entity):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    own = runpy.run_path(str(mjlab / "asset_zoo" / "robots" / "unitree_go1" / "go1_constants.py"))

    for motor in range(model.nu):
        name = model.actuator(motor).name
        (theirs,) = (
            values
            for values in own["GO1_ARTICULATION"].actuators
            if any(re.fullmatch(names, name) for names in values.target_names_expr)
        )
        assert model.actuator_gainprm[motor, 0] == pytest.approx(theirs.stiffness)
        assert model.actuator_biasprm[motor, 1:3] == pytest.approx([-theirs.stiffness, -theirs.damping])
        assert model.actuator_forcerange[motor] == pytest.approx([-theirs.effort_limit, theirs.effort_limit])
        assert model.dof_armature[model.joint(name).dofadr] == pytest.approx(theirs.armature)
    assert model.nu == 12
    angles = own["INIT_STATE"].joint_pos
    assert example["STANDING"][1:] == (angles[".*thigh_joint"], angles[".*calf_joint"])


def test_every_example_is_run_here() -> None:
    tests = {name.removeprefix("test_") for name in globals()}
    assert EXAMPLES
    assert set(EXAMPLES) <= tests
