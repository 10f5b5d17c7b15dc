"""`rsegen robot`: a user sees what of his robot was read, and from where."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rsegen.cli.edge import main
from tests.robots.two_wheels import GZ, ROS_1, two_wheels
from tests.robots.urdf_robots import two_wheels_urdf


def figures(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, tuple[str, str]]:
    assert main(["robot", *words, "--json"]) == 0
    content: dict[str, Any] = json.loads(capsys.readouterr().out)
    return {figure["name"]: (figure["value"], figure["origin"]) for figure in content["figures"]}


def test_each_figure_has_its_origin(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.sdf"
    file.write_text(two_wheels(GZ))
    found = figures(capsys, str(file))
    assert found["mass"] == ("3.4 kg", "the <inertial> of 3 links")
    assert found["drive"] == ("left_hub and right_hub", "gz-sim-diff-drive-system")
    assert found["separation"][0] == "0.3 m"
    assert found["radius"][0] == "0.05 m"
    assert found["friction"][0] == "1"
    assert found["motor"][0] == "no limit"
    assert found["motor"][1].startswith("neither an <effort> of its joint nor the torque of a plug-in")
    assert found["shapes"] == ("4", "its <collision>: box 1, sphere 1, cylinder 2")


def test_what_is_assumed_is_said_and_effort_and_friction_are_the_joints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.urdf"
    text = two_wheels_urdf("").replace("</joint>", '<limit effort="7" velocity="0"/></joint>')
    file.write_text(text.replace("<mu1>1</mu1>", "<mu1>0.6</mu1>", 1))
    found = figures(capsys, str(file))
    assert found["drive"][1].startswith("the shapes of its links")
    assert found["speed"] == ("0.2 m/s", "assumed, as nothing says it")
    assert found["motor"] == ("7 Nm", "the <effort> of its joint")
    assert found["friction"][0] == "0.6 to 1"
    named = figures(capsys, str(file), "--wheels", "right_hub,left_hub")
    assert named["drive"] == ("left_hub and right_hub", "their names")


@pytest.mark.parametrize(
    ("said", "effort", "value", "origin"),
    [
        ("<torque>5</torque>", "", "5 Nm", "the torque of its plug-in"),
        ("<wheelTorque>5</wheelTorque>", "100", "5 Nm", "the torque of its plug-in"),
        ("<max_wheel_torque>20</max_wheel_torque>", "3", "3 Nm", "the <effort> of its joint"),
        ("<torque>0</torque>", "0", "no limit", "neither an <effort>"),
        ("", "-1", "no limit", "neither an <effort>"),
    ],
)
def test_a_motor_is_the_weaker_of_the_joints_and_the_plug_ins(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], said: str, effort: str, value: str, origin: str
) -> None:
    file = tmp_path / "mine.sdf"
    text = two_wheels(ROS_1.replace("<torque>5</torque>", said))
    limit = f"<limit><effort>{effort}</effort></limit></axis>" if effort else "</axis>"
    file.write_text(text.replace("</axis>", limit))
    found = figures(capsys, str(file))
    assert found["motor"][0] == value
    assert found["motor"][1].startswith(origin)


@pytest.mark.parametrize("kind", ["burger", "crawler"])
def test_a_robot_of_rsegen_names_its_source(capsys: pytest.CaptureFixture[str], kind: str) -> None:
    assert main(["robot", kind]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == kind
    assert lines[1].startswith("mass ")
    assert main(["robot", kind, "--wheels", "a,b"]) == 2


def test_a_robot_that_is_not_driven_says_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "box.sdf"
    file.write_text('<sdf version="1.6"><model name="box"><link name="a"/></model></sdf>')
    found = figures(capsys, str(file))
    assert found["drive"] == ("none", "nothing says it, and no links look like wheels")
    assert found["mass"] == ("1 kg", "the <inertial> of 1 links; 1 kg each, as SDF has it, for 1 without a mass")
    assert main(["robot", str(tmp_path / "nothing.sdf")]) == 2
