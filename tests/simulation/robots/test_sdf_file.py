"""A robot of the user's own, and files that are none."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from rsegen.errors import FileError, ParameterError
from rsegen.simulation.robots import BACKENDS, ROBOTS, from_file

MODEL = '<sdf version="1.6"><model name="mine"><link name="base"/>{}</model></sdf>'


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.sdf"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize("kind", list(ROBOTS))
@pytest.mark.parametrize("simulator", ["classic", "sim", "fortress"])
def test_our_own_robots_are_found_again(tmp_path: Path, kind: str, simulator: str) -> None:
    found = from_file(written(tmp_path, ROBOTS[kind].file("mine", simulator)))
    assert (found.kind, found.backend) == ("mine", simulator)
    assert found.command("mine", 0, 0, simulator) == ROBOTS[kind].command("mine", 0, 0, simulator)
    for other in BACKENDS:
        assert found.command("mine", 0, 0, other) == ROBOTS[kind].command("mine", 0, 0, other)


def test_a_robot_without_a_known_drive_is_read_and_not_commanded(tmp_path: Path) -> None:
    found = from_file(written(tmp_path, MODEL.format("")))
    assert (found.kind, found.backend, found.topic) == ("mine", None, None)
    with pytest.raises(ParameterError, match="mine: no drive that rsegen knows"):
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
        ('<!DOCTYPE a [<!ENTITY b "c">]>' + MODEL, "document type or entities"),
        ("<robot/>", "URDF, not SDF"),
        ('<sdf version="1.6"/>', "one <model> in <sdf>"),
        (MODEL.replace("</sdf>", '<model name="two"><link name="l"/></model></sdf>'), "one <model> in <sdf>"),
        ('<sdf version="1.6"><world name="w"/></sdf>', "one <model> in <sdf>"),
        ('<sdf version="1.6"><model name="mine"/></sdf>', "no <link>"),
        (MODEL.replace("mine", " "), "the model has no name"),
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
