"""A robot of models that include each other is the robot that has all of it in one file."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from rsegen.errors import FileError
from rsegen.robots.drives import Wheels
from rsegen.robots.files.sdf_file import from_file

BODY = """<link name="base"><pose>0 0 0.1 0 0 0</pose><inertial><mass>5</mass>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
<collision name="c"><geometry><box><size>0.4 0.2 0.1</size></box></geometry></collision>
</link>"""
WHEEL = """<link name="{0}wheel"><inertial><mass>1</mass>
<inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia>
</inertial><collision name="c"><geometry><cylinder><radius>0.1</radius><length>0.04</length></cylinder></geometry>
</collision></link>"""
JOINT = (
    """<joint name="{0}" type="revolute"><parent>base</parent><child>{1}</child><axis><xyz>0 0 1</xyz></axis></joint>"""
)
CONFIG = '<model><sdf version="1.5">old.sdf</sdf><sdf version="1.7">{}</sdf></model>'
TURNED = "-1.5707963267948966 0 0"


def sdf(name: str, inside: str, version: str = "1.9") -> str:
    return f'<sdf version="{version}"><model name="{name}">{inside}</model></sdf>'


def include(uri: str, more: str = "", merge: str = "") -> str:
    return f"<include{merge}><uri>{uri}</uri>{more}</include>"


def written(folder: Path, robot: str, **models: str) -> Path:
    """Write models into folders next to that of a robot."""
    for name, inside in models.items():
        (folder / name).mkdir(parents=True)
        (folder / name / "wheel_1.sdf").write_text(sdf(name, inside))
        (folder / name / "model.config").write_text(CONFIG.format("wheel_1.sdf"))
    (folder / "robot").mkdir(parents=True)
    file = folder / "robot" / "model.sdf"
    file.write_text(sdf("robot", robot))
    return file


def whole() -> str:
    """The robot in one file."""
    wheels = "".join(
        WHEEL.format(side).replace("<inertial>", f"<pose>0 {y} 0.1 {TURNED}</pose><inertial>", 1)
        + JOINT.format(f"{side}joint", f"{side}wheel")
        for side, y in (("l", 0.2), ("r", -0.2))
    )
    return BODY + wheels


def nested(uri: str) -> str:
    parts = "".join(
        include(uri, f"<name>{side}</name><pose>0 {y} 0.1 {TURNED}</pose>")
        + JOINT.format(f"{side}joint", f"{side}::wheel")
        for side, y in (("l", 0.2), ("r", -0.2))
    )
    return BODY + parts


MERGED = JOINT.format("ljoint", "lwheel") + JOINT.format("rjoint", "rwheel")


@pytest.mark.parametrize("uri", ["model://tyre", "model:///tyre", "tyre", "file://../tyre", "../tyre/wheel_1.sdf"])
def test_a_robot_of_included_wheels_is_the_one_in_one_file(tmp_path: Path, uri: str) -> None:
    same_as_whole(tmp_path, written(tmp_path / "a", nested(uri), tyre=WHEEL.format("")))


def test_a_model_is_found_whatever_its_config_is(tmp_path: Path) -> None:
    """A number of a thousand digits is no version, and a pipe to which nobody writes has none."""
    file = written(tmp_path / "a", nested("model://tyre"), tyre=WHEEL.format(""))
    (config,) = tmp_path.rglob("tyre/model.config")
    config.write_text(f"<model><sdf version='1.{'9' * 5000}'>other.sdf</sdf></model>")
    (config.parent / "wheel_1.sdf").rename(config.parent / "model.sdf")
    same_as_whole(tmp_path, file)
    known = from_file(file)
    config.unlink()
    os.mkfifo(config)
    assert from_file(file) == known


def test_merged_wheels_are_links_of_the_robot(tmp_path: Path) -> None:
    merge = ' merge="true"'
    parts = "".join(
        include(f"model://{side}tyre", f"<pose>0 {y} 0.1 {TURNED}</pose>", merge)
        for side, y in (("l", 0.2), ("r", -0.2))
    )
    file = written(tmp_path / "a", BODY + parts + MERGED, ltyre=WHEEL.format("l"), rtyre=WHEEL.format("r"))
    same_as_whole(tmp_path, file)
    assert from_file(file).drive.left == ("ljoint",)


def test_a_file_that_only_names_a_model_is_that_model(tmp_path: Path) -> None:
    written(tmp_path / "a", "", inner=whole())
    file = tmp_path / "a/named.sdf"
    file.write_text(f'<sdf version="1.9">{include("model://inner", "<name>mine</name>")}</sdf>')
    same_as_whole(tmp_path, file)
    assert from_file(file).kind == "mine"


def test_a_merged_robot_is_placed_by_its_frame(tmp_path: Path) -> None:
    """The whole robot is included, with its pose in the file that is included, or that of a frame of it."""
    frame = "<frame name='foot'><pose>0 0 0.3 0 0 0</pose></frame>"
    more = "<placement_frame>foot</placement_frame><pose>1 2 0.3 0 0 0</pose>"
    outer = include("model://inner", more, ' merge="1"')
    file = written(tmp_path / "a", outer, inner=whole() + frame)
    assert "<pose>1 2 0.1 0 0 0</pose>" in from_file(file).text
    assert from_file(file).drive.separation == pytest.approx(0.4)


def test_a_nested_model_is_placed_by_its_frame(tmp_path: Path) -> None:
    frame = "<frame name='foot'><pose>0 0 0.3 0 0 0</pose></frame>"
    inner = f"<model name='inner' placement_frame='foot'><pose>1 2 0.4 0 0 0</pose>{whole()}{frame}</model>"
    file = written(tmp_path / "a", inner)
    robot = from_file(file)
    assert robot.lift == pytest.approx(-0.1)  # where the floor of the inner one is, 0.3 below its frame
    np.testing.assert_allclose(robot.body.centre[:2], (1, 2), atol=1e-6)


def test_a_robot_with_a_placement_frame_is_placed_by_its_origin(tmp_path: Path) -> None:
    file = written(tmp_path / "a", whole())
    file.write_text(file.read_text().replace("<model ", "<model placement_frame='base' "))
    assert "placement_frame" not in from_file(file).model("one", "sim")


def test_a_part_may_be_relative_to_another_and_include_more(tmp_path: Path) -> None:
    pair = (
        nested("model://tyre")
        .replace(BODY, "")
        .replace("<pose>0", "<pose relative_to='base'>0")
        .replace(" 0.1 -1", " 0 -1")
    )
    file = written(
        tmp_path / "a",
        include("model://body", merge=' merge="true"') + pair,
        tyre=include("model://rubber", merge=' merge="true"'),
        rubber=WHEEL.format(""),
        body=BODY,
    )
    same_as_whole(tmp_path, file)


def same_as_whole(tmp_path: Path, file: Path) -> None:
    robot, one = from_file(file), from_file(written(tmp_path / "b", whole()))
    assert isinstance(robot.drive, Wheels)
    assert isinstance(one.drive, Wheels)
    assert robot.drive.separation == pytest.approx(one.drive.separation)
    assert robot.drive.radius == pytest.approx(one.drive.radius)
    assert robot.body.mass == pytest.approx(one.body.mass) == 7
    np.testing.assert_allclose(robot.body.centre, one.body.centre, atol=1e-9)
    assert (*robot.size, robot.lift) == pytest.approx((*one.size, one.lift))


def test_what_is_not_found_is_left_out_with_its_joints_and_named(tmp_path: Path) -> None:
    lidar = include("https://fuel.gazebosim.org/1.0/somebody/models/lidar", "<name>eye</name>")
    file = written(tmp_path / "a", whole() + lidar + JOINT.format("neck", "eye::head"))
    robot = from_file(file)
    assert robot.drive.separation == pytest.approx(0.4)
    assert "neck" not in robot.text
    assert any(
        remark.endswith("is not found: https://fuel.gazebosim.org/1.0/somebody/models/lidar")
        for remark in robot.remarks
    )


@pytest.mark.parametrize(
    ("inside", "says"),
    [
        (include("model://nowhere"), "model://nowhere that it includes is not found: put its folder next to"),
        (
            include("model://base", merge=" merge='true'") + BODY,
            "model://base, of which it is a part, is not found: put",
        ),
        (include("model://loop"), "includes itself"),
        (include("model://odd", "<placement_frame>top</placement_frame>"), "has no frame 'top'"),
        ("", "the model has no <link>"),
    ],
)
def test_what_cannot_be_included_is_one_line(tmp_path: Path, inside: str, says: str) -> None:
    file = written(tmp_path / "a", inside, loop=include("model://loop"), odd=BODY)
    with pytest.raises(FileError) as caught:
        from_file(file)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_models_that_include_very_many_are_refused(tmp_path: Path) -> None:
    doubling = {f"m{n}": include(f"model://m{n + 1}") * 3 for n in range(8)} | {"m8": BODY}
    with pytest.raises(FileError, match="more than 100 models are included"):
        from_file(written(tmp_path / "a", include("model://m0"), **doubling))


@pytest.mark.parametrize("pose", ["", "<pose>0.1 0.2 0.3 0.1 0.2 0.3</pose>"])
def test_a_merged_model_is_as_it_would_be_nested(tmp_path: Path, pose: str) -> None:
    part = """<pose>0 0 0.02 0 0.1 0</pose>
      <frame name="mount" attached_to="__model__"><pose>0.1 0 0 0 0 0.1</pose></frame>
      <link name="foot"><pose relative_to="mount">0 0 0.1 0 0 0</pose></link><link name="head"/>
      <joint name="neck" type="fixed">
        <pose relative_to="__model__">0 0 0.1 0.1 0 0</pose><parent>__model__</parent><child>head</child>
        <axis><xyz expressed_in="__model__">0 0.6 0.8</xyz></axis>
      </joint>
      <joint name="nod" type="fixed"><parent>foot</parent><child>head</child>
        <axis><xyz>0 0.6 0.8</xyz><use_parent_model_frame>true</use_parent_model_frame></axis></joint>"""
    merged, nested = (
        from_file(written(tmp_path / name, BODY + include("model://part", pose, merge), part=part)).frames()
        for name, merge in (("merged", ' merge="true"'), ("nested", ""))
    )
    for name in ("mount", "foot", "head"):
        np.testing.assert_allclose(merged.transform(name), nested.transform(f"part::{name}"), atol=1e-9)
    assert merged.parent("neck") == "foot"
    for joint in ("neck", "nod"):
        np.testing.assert_allclose(merged.joint(joint), nested.joint(f"part::{joint}"), atol=1e-9)
        np.testing.assert_allclose(merged.axis(joint), nested.axis(f"part::{joint}"), atol=1e-9)
