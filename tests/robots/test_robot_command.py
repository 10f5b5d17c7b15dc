"""`rsegen robot`: a user sees which robots there are, or what of his own was read, and from where."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from rsegen.cli.edge import main
from rsegen.robots.base import ROBOTS
from tests.robots.two_wheels import GZ, ROS_1, two_wheels
from tests.robots.urdf_robots import two_wheels_urdf


def listed(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    assert main(["robot", "--json"]) == 0
    robots: list[dict[str, Any]] = json.loads(capsys.readouterr().out)["robots"]
    return robots


def figures(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, tuple[str, str]]:
    assert main(["robot", *words, "--json"]) == 0
    content: dict[str, Any] = json.loads(capsys.readouterr().out)
    return {figure["name"]: (figure["text"], figure["origin"]) for figure in content["figures"]}


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


def test_what_has_a_unit_is_in_numbers_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", "burger", "--json"]) == 0
    found = {figure["name"]: figure for figure in json.loads(capsys.readouterr().out)["figures"]}
    in_numbers = {name: figure["value"] for name, figure in found.items() if figure["unit"]}
    burger = ROBOTS["burger"]
    assert in_numbers == {
        "mass": round(burger.mass, 9),
        "size": list(burger.size),
        "separation": burger.drive.separation,
        "radius": burger.drive.radius,
        "speed": burger.speed,
        "turn rate": burger.turn,
        "balance": in_numbers["balance"],
        "clearance": in_numbers["clearance"],
    }
    ahead, high = in_numbers["balance"]
    assert found["balance"]["text"] == f"{-ahead:.3f} m behind, {high:.3f} m high"
    assert found["clearance"]["text"] == f"{in_numbers['clearance']:.3f} m"


def test_the_source_of_a_kind_is_printed_once_and_is_the_origin_of_each_figure(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for kind, robot in ROBOTS.items():
        assert {origin for _, origin in figures(capsys, kind).values()} == {robot.source}
        assert main(["robot", kind]) == 0
        text = " ".join(capsys.readouterr().out.split())
        assert text.count(robot.source) == 1
        assert text.endswith(f"source {robot.source}")


def test_what_is_assumed_is_said_and_effort_and_friction_are_the_joints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.urdf"
    text = two_wheels_urdf("").replace("</joint>", '<limit effort="7" velocity="0"/></joint>')
    file.write_text(text.replace("<mu1>1</mu1>", "<mu1>0.6</mu1>", 1))
    found = figures(capsys, str(file))
    assert found["drive"][1].startswith("the shapes of its links")
    assert found["speed"] == ("0.2 m/s", "assumed, as its file does not say")
    assert found["motor"] == ("7 Nm", "the <effort> of its joint")
    assert found["friction"][0] == "0.6 to 1"
    named = figures(capsys, str(file), "--wheels", "right_hub,left_hub")
    assert named["drive"] == ("left_hub and right_hub", "their names")
    limited = text.replace('velocity="0"', 'velocity="8"')
    file.write_text(limited)
    assert figures(capsys, str(file), "--wheels", "left_hub,right_hub")["speed"] == ("0.4 m/s", "its joints")
    file.write_text(text.replace("<mu1>1</mu1>", "<mu1>100000</mu1>"))
    assert figures(capsys, str(file))["friction"] == (
        "1",
        "<mu> of what it drives on, 1 if missing; 100000 acts as 1, as blocks have no more",
    )


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


HULL = "<pose>-0.05 0 0.04 0 0 0</pose>"
WEIGHT = "<inertial><mass>3</mass>"


def test_a_robot_of_a_file_is_described_as_it_stands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.sdf"
    file.write_text(two_wheels(GZ))
    found = figures(capsys, str(file))
    assert found["front"] == ("along x of its model", "as in ROS and Gazebo")
    assert found["balance"][0] == "0.000 m ahead, 0.050 m high"
    assert found["supports"][0] == "base::ball 0.150 m behind"
    assert found["supports"][1].endswith("; friction 0")
    # The hull is from 0 to 0.08 above its link, and that is 0.05 m above the ground.
    assert found["clearance"] == ("0.050 m", "the lowest of all else above level ground, base::hull")
    assert "stands" not in found


def test_a_low_belly_is_a_support_and_leaves_no_clearance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.sdf"
    file.write_text(two_wheels(GZ).replace(HULL, HULL.replace("0.04", "-0.01")))
    found = figures(capsys, str(file))
    assert found["supports"][0] == "base::hull 0.050 m behind, base::ball 0.150 m behind"
    assert found["supports"][1].endswith("; friction 0 to 1")
    assert "clearance" not in found


def test_a_robot_that_tips_over_on_level_ground_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.sdf"
    file.write_text(two_wheels(GZ).replace(WEIGHT, WEIGHT.replace("<mass>", "<pose>-0.4 0 0 0 0 0</pose><mass>")))
    found = figures(capsys, str(file))
    assert found["balance"][0].startswith("0.353 m behind")  # 3 of 3.4 kg, 0.4 m behind the wheels
    assert found["stands"][0] == "no"


def test_wheels_without_collision_shapes_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.sdf"
    file.write_text(re.sub('<collision name="tyre">.*?</collision>', "", two_wheels(GZ), flags=re.DOTALL))
    found = figures(capsys, str(file))
    assert found["friction"] == ("none", "what it drives on has no collision shapes")
    assert "supports" not in found


def test_a_caster_on_a_fixed_joint_has_the_name_of_its_link(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.urdf"
    file.write_text(two_wheels_urdf())
    assert figures(capsys, str(file))["supports"][0] == "caster 0.150 m behind"


@pytest.mark.parametrize("kind", ["burger", "crawler", "jackal"])
def test_the_clearance_of_a_kind_is_that_of_its_shapes(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert figures(capsys, kind)["clearance"][0] == f"{ROBOTS[kind].clearance:.3f} m"


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
    assert found["drive"] == ("none", "not in its file, and no links look like wheels")
    assert found["mass"] == ("1 kg", "1 kg each, as SDF has it, for 1 link without a mass")
    assert main(["robot", str(tmp_path / "nothing.sdf")]) == 2


def test_without_a_file_every_robot_is_listed_with_what_it_climbs(capsys: pytest.CaptureFixture[str]) -> None:
    robots = listed(capsys)
    assert [each["kind"] for each in robots] == list(ROBOTS)
    for each, robot in zip(robots, ROBOTS.values(), strict=True):
        assert (tuple(each["size"]), each["climbs"], each["title"]) == (robot.size, robot.climbs, robot.title)
        assert each["mass"] == pytest.approx(robot.mass)
    assert [each["drive"] for each in robots if each["kind"] in ("burger", "crawler", "jackal")] == [
        "2 wheels",
        "2 tracks, 2 flippers",
        "4 wheels",
    ]
    assert main(["robot"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1 : len(ROBOTS) + 1]] == list(ROBOTS)
    assert "97.5 x 53 x 32 cm      22.6 kg  2 tracks, 2 flippers  20 cm" in lines[list(ROBOTS).index("crawler") + 1]
    assert main(["robot", "--wheels", "a,b"]) == 2
    assert "--wheels: is for one robot: name it first" in capsys.readouterr().err


def test_pictures_are_where_the_list_says(capsys: pytest.CaptureFixture[str]) -> None:
    robots = listed(capsys)
    assert len(robots) >= 3
    root = Path(__file__).parents[2]
    assert all((root / each["picture"]).is_file() for each in robots)


def test_a_robot_of_a_plug_in_is_listed_without_a_picture(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    other = replace(ROBOTS["jackal"], kind="loader", climbs=0.07)
    monkeypatch.setattr(ROBOTS, "_things", {**ROBOTS._things, "loader": other})
    monkeypatch.setattr(ROBOTS, "_sources", {**ROBOTS._sources, "loader": "loader.py"})
    (loader,) = (each for each in listed(capsys) if each["kind"] == "loader")
    assert (loader["climbs"], loader["picture"]) == (0.07, None)


def test_the_plural_is_answered_with_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["robots"])
    assert "did you mean 'robot'?" in capsys.readouterr().err


@pytest.mark.parametrize("columns", [60, 80, 100, 400])
def test_a_table_fits_the_terminal_however_long_names_of_joints_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    file, long = tmp_path / "mine.sdf", "_of_a_rover_with_six_wheels_and_a_rocker" * 2
    file.write_text(two_wheels(GZ).replace("left_hub", f"left{long}").replace("right_hub", f"right{long}"))
    found = figures(capsys, str(file))
    monkeypatch.setenv("COLUMNS", str(columns))
    assert main(["robot", str(file)]) == 0
    table = capsys.readouterr().out.splitlines()[1:]
    assert max(map(len, table)) <= columns
    printed = "".join("".join(table).split())
    if columns == 400:  # in lines of their own
        assert len(table) == len(found)
        assert all("".join(word.split()) in printed for row in found.items() for word in (row[0], *row[1]))
    else:
        assert len(table) > len(found)
        cells = [line[len("separation") + 2 :].split("  ")[0].strip() for line in table]
        assert f"left{long} and right{long}".replace(" ", "") in "".join(cells).replace(" ", "")


def test_suspensions_are_named_and_arms_are_not_among_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    joints = "".join(
        f'<link name="{name}"/><joint name="{name}_joint" type="prismatic"><parent>base</parent><child>{name}</child>'
        f"<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit>{inner}</axis></joint>"
        for name, inner in (
            ("mast", ""),
            ("damper", "<dynamics><spring_stiffness>5</spring_stiffness></dynamics>"),
        )
    )
    file = tmp_path / "mine.sdf"
    file.write_text(two_wheels(GZ + joints))
    assert main(["robot", str(file)]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert "moves on springs in a drive, where poses take it as rigid: damper_joint" in printed
    assert "held in a drive as its model has them, as nothing drives them: mast_joint" in printed
