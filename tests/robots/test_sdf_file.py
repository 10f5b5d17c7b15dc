"""A robot of the user's own, and files that are none."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
import trimesh

from rsegen.errors import FileError, ParameterError
from rsegen.robots.base import ROBOTS
from rsegen.robots.drives import BACKENDS
from rsegen.robots.files.sdf_file import from_file

MODEL = '<sdf version="1.6"><model name="mine"><link name="base"/>{}</model></sdf>'


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.sdf"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize("kind", list(ROBOTS))
@pytest.mark.parametrize("simulator", ["classic", "sim", "fortress"])
def test_our_own_robots_are_found_again(tmp_path: Path, kind: str, simulator: str) -> None:
    found = from_file(written(tmp_path, ROBOTS[kind].file("mine", simulator)))
    assert found.kind == "mine"
    assert found.command("mine", 0, 0, simulator) == ROBOTS[kind].command("mine", 0, 0, simulator)
    for other in BACKENDS:
        assert found.command("mine", 0, 0, other) == ROBOTS[kind].command("mine", 0, 0, other)


def test_a_robot_without_a_known_drive_is_read_and_not_commanded(tmp_path: Path) -> None:
    found = from_file(written(tmp_path, MODEL.format("")))
    assert (found.kind, found.read_drive) == ("mine", None)
    with pytest.raises(ParameterError, match="mine: no wheels or tracks: "):
        found.command("mine", 1, 0)


def test_it_stands_under_the_name_and_at_the_place_that_it_is_given(tmp_path: Path) -> None:
    for pose in ("", "<pose>9 9 9 0 0 0</pose>"):
        model = ElementTree.fromstring(
            from_file(written(tmp_path, MODEL.format(pose))).model("two", at=(1, 2, 3, 0, 0, 4))
        )
        assert model.get("name") == "two"
        assert [place.text for place in model.findall("pose")] == ["1 2 3 0 0 4"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "not XML"),
        ("robot", "not XML"),
        ('<!DOCTYPE a [<!ENTITY b "c">]>' + MODEL, "DOCTYPE or entities"),
        ("<robot/>", "the robot has no <link>"),
        ('<robot><link name="l"/></robot>', "link 'l' has no mass"),
        ('<sdf version="1.6"/>', "one <model> in <sdf>"),
        (MODEL.replace("</sdf>", '<model name="two"><link name="l"/></model></sdf>'), "one <model> in <sdf>"),
        ('<sdf version="1.6"><world name="w"/></sdf>', "one <model> in <sdf>"),
        ('<sdf version="1.6"><model name="mine"/></sdf>', "no <link>"),
        (MODEL.replace("mine", " "), "the model has no name"),
        (
            '<sdf><model name="m"><link name="l"><inertial><mass value="1"/></inertial></link></model></sdf>',
            "its links and joints are of URDF; put them into <robot name='...'>, in place of <sdf>",
        ),
    ],
)
def test_files_that_are_no_robot_are_refused_in_one_line(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(FileError) as caught:
        from_file(written(tmp_path, text))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none\.sdf: No such file"):
        from_file(tmp_path / "none.sdf")


@pytest.mark.parametrize("levels", [300, 200_000])
def test_a_robot_of_elements_nested_too_deeply_is_refused(tmp_path: Path, levels: int) -> None:
    path = tmp_path / "deep.sdf"
    path.write_text(f"<sdf><model name='r'><link/>{'<a>' * levels}{'</a>' * levels}</model></sdf>")
    with pytest.raises(FileError, match=r"deep\.sdf: nested too deeply, in more than 200 levels"):
        from_file(path)


DRIVEN = (
    '<link name="base"><collision name="c"><geometry><box><size>{size}</size></box></geometry></collision></link>'
    '<joint name="l" type="revolute"><parent>base</parent><child>lw</child><axis><xyz>0 1 0</xyz></axis></joint>'
    '<link name="lw"/>'
    '<joint name="r" type="revolute"><parent>base</parent><child>rw</child><axis><xyz>0 1 0</xyz></axis></joint>'
    '<link name="rw"/>'
    '<plugin name="d" filename="libgazebo_ros_diff_drive.so"><left_joint>l</left_joint><right_joint>r</right_joint>'
    "<wheel_separation>{separation}</wheel_separation><wheel_radius>{radius}</wheel_radius>"
    "<max_linear_velocity>{speed}</max_linear_velocity><max_angular_velocity>{turn}</max_angular_velocity></plugin>"
)
USUAL = {"size": "0.4 0.3 0.1", "separation": "0.3", "radius": "0.03", "speed": "0.3", "turn": "1"}


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("size", "600 450 100", "its collision shapes, 600 x 450 x 100 m: 600.0 is outside 0.01..100 m"),
        ("size", "0.4 100.1 0.1", "0.4 x 100.1 x 0.1 m: 100.1 is outside 0.01..100 m"),
        ("separation", "160", "the separation of its wheels or tracks: 160.0 is outside 0.001..100 m"),
        ("radius", "1e-9", "the radius of its wheels or tracks: 1e-09 is outside 0.001..100 m"),
        ("speed", "0.0001", "the limit of a velocity: 0.0001 is outside 0.001..100 m/s"),
        ("turn", "0.0001", "the limit of a velocity: 0.0001 is outside 0.001..100 rad/s"),
    ],
)
def test_a_robot_in_millimetres_is_refused_in_one_line(tmp_path: Path, name: str, value: str, says: str) -> None:
    from_file(written(tmp_path, MODEL.format(DRIVEN.format(**USUAL))))
    with pytest.raises(FileError, match=r"mine\.sdf: ") as caught:
        from_file(written(tmp_path, MODEL.format(DRIVEN.format(**{**USUAL, name: value}))))
    assert says in str(caught.value)


def test_an_extreme_limit_counts_as_none(tmp_path: Path) -> None:
    robot = from_file(written(tmp_path, MODEL.format(DRIVEN.format(**USUAL | {"speed": "1e16", "turn": "200"}))))
    assert {"speed", "turn"} <= set(robot.assumed)


def test_a_mesh_with_a_vertex_far_away_is_refused(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.4, 0.3, 0.1))
    box.vertices[0, 0] = 1e37
    box.export(tmp_path / "box.obj")
    mesh = "<collision name='c'><geometry><mesh><uri>box.obj</uri></mesh></geometry></collision>"
    with pytest.raises(
        FileError, match=r"mine\.sdf: the box around its collision shapes.*2e\+37 is outside 0.01..100 m"
    ):
        from_file(written(tmp_path, MODEL.replace('<link name="base"/>', f"<link name='b'>{mesh}</link>")))
