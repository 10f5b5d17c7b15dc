"""Macros are expanded as ROS does it, and a file of macros does nothing but calculate, for a short time."""

from __future__ import annotations

import math
import resource
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

import pytest

from rsegen.errors import FileError, UserError
from rsegen.params import extras
from rsegen.robots.files import xacro_files
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from tests.robots.two_wheels import ROS_1, two_wheels
from tests.robots.urdf_robots import two_wheels_urdf

with_xacro = pytest.mark.skipif(find_spec("xacro") is None, reason="the package xacro is not installed")

SPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
NAMES: dict[str, Any] = {
    "r": 0.1,
    "table": {"a": [1, 2]},
    "math": math,
    "len": len,
    "list": list,
    "map": map,
    "float": float,
    "dict": dict,
    "name": "a_b",
    "true": True,
}


def expanding(folder: Path, inner: str, name: str = "mine.xacro") -> SdfRobot:
    text = two_wheels_urdf(ROS_1).replace('<robot name="my-robot">', f'<robot name="my-robot" {SPACE}>{inner}')
    (folder / name).write_text(text, "utf-8")
    return from_file(folder / name)


@with_xacro
@pytest.mark.slow
@pytest.mark.parametrize(
    ("ends", "says"),
    [
        ("raise ImportError('libexpat is broken')", "ImportError: libexpat is broken"),
        ("raise MemoryError", "it needs too much memory"),
        ("import os; os.kill(os.getpid(), 9)", "it needs too much memory"),
    ],
)
def test_a_process_that_ends_before_it_expands_anything_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ends: str, says: str
) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken/xml.py").write_text(ends)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "broken"))
    with pytest.raises(FileError, match=rf"mine\.xacro: xacro cannot expand it: {says}$"):
        expanding(tmp_path, "")


@with_xacro
@pytest.mark.slow
def test_macros_includes_and_arguments_are_expanded_without_ros(tmp_path: Path) -> None:
    part = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="post" params="name height">
        <link name="${name}"><inertial><mass value="${height / 2}"/>
          <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
          <collision><geometry><box size="0.1 0.1 ${height}"/></geometry></collision></link>
        <joint name="${name}_joint" type="fixed"><parent link="base"/><child link="${name}"/></joint>
        </xacro:macro></robot>"""
    (tmp_path / "parts_description").mkdir()
    (tmp_path / "parts_description/part.xacro").write_text(part)
    inner = """<xacro:include filename="$(find parts_description)/part.xacro"/>
        <xacro:arg name="tall" default="true"/><xacro:property name="height" value="${1 + 1}"/>
        <xacro:if value="$(arg tall)"><xacro:post name="mast" height="${height * radians(180) / pi}"/></xacro:if>"""
    robot = expanding(tmp_path, inner)
    plain = from_file(written(tmp_path / "mine.sdf", two_wheels(ROS_1)))
    assert robot.drive == plain.drive
    assert robot.size[2] == pytest.approx(2)  # the mast is the highest and the lowest


@with_xacro
@pytest.mark.slow
def test_expressions_make_a_file_xacro_whatever_its_name(tmp_path: Path) -> None:
    inner = '<xacro:arg name="namespace" default=""/><xacro:property name="n" value="$(arg namespace)"/>'
    robot = expanding(tmp_path, inner + '<gazebo reference="${n}base"><kp>${10**6}</kp></gazebo>', "mine.urdf")
    assert "<kp>1000000</kp>" in robot.text


@with_xacro
@pytest.mark.slow
def test_functions_of_mathematics_are_called(tmp_path: Path) -> None:
    robot = expanding(tmp_path, '<gazebo reference="base"><kp>${log10(10**6) + math.fmod(5, 3)}</kp></gazebo>')
    assert "<kp>8.0</kp>" in robot.text


@with_xacro
@pytest.mark.slow
@pytest.mark.parametrize(
    ("inner", "says"),
    [
        ('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>', "maximum recursion depth"),
        ('<xacro:include filename="mine.xacro"/>', "maximum recursion depth"),
        ('<xacro:include filename="none.xacro"/>', "none.xacro, and there is no such file"),
        ('<gazebo><a b="$(find none_description)/x"/></gazebo>', "the package none_description is not found"),
        ('<gazebo><a b="$(arg none)"/></gazebo>', "Undefined substitution argument none"),
        (
            '<gazebo reference="${of_another_part}"/>',
            "'of_another_part'; if it is a part of a robot, use the file of the robot that includes it",
        ),
        (
            "<xacro:box_inertia/>",
            "xacro:box_inertia; if it is a part of a robot, use the file of the robot that includes it",
        ),
        ('<gazebo><a b="$(eval none + 1)"/></gazebo>', "name 'none' is not defined"),
        ('<gazebo><a b="$(eval 1 .__class__.__base__)"/></gazebo>', "is more than arithmetic"),
        ('<gazebo><a b="${[0] * 10**10}"/></gazebo>', "xacro cannot expand it"),
        ("<gazebo><a b=\"${'x' * 10**7}\"/></gazebo>", "an expression makes a value of 10,000,000 parts"),
        ("<gazebo>" + "<a b=\"${'x' * 10**6}\"/>" * 5 + "</gazebo>", "its macros make 5 MiB of it"),
        ('<gazebo><a b="${(lambda: ().__class__)()}"/></gazebo>', "is more than arithmetic"),
    ],
)
def test_macros_that_cannot_be_expanded_are_refused_in_one_line(tmp_path: Path, inner: str, says: str) -> None:
    with pytest.raises(FileError, match=r"mine\.xacro: xacro cannot expand it: ") as caught:
        expanding(tmp_path, inner)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def doubling(body: str, most: int = 40) -> str:
    """Macros of which each calls the one below it twice."""
    pairs = "".join(
        f'<xacro:macro name="m{i}"><xacro:m{i - 1}/><xacro:m{i - 1}/></xacro:macro>' for i in range(1, most)
    )
    return f'<xacro:macro name="m0">{body}</xacro:macro>{pairs}<xacro:m{most - 1}/>'


ITSELF = """<xacro:macro name="m" params="n"><xacro:if value="${n > 0}">
    <xacro:m n="${n - 1}"/><xacro:m n="${n - 1}"/></xacro:if></xacro:macro><xacro:m n="40"/>"""
TEXTS = "".join(f'<xacro:property name="p{i}" value="${{p{i - 1} * 10}}"/>' for i in range(1, 12))


@with_xacro
@pytest.mark.slow
@pytest.mark.parametrize(
    ("inner", "says"),
    [
        (doubling("<gazebo/>"), "its macros make more than 20,000 elements"),
        (doubling(""), "its macros make more than 20,000 elements"),
        (ITSELF, "its macros make more than 20,000 elements"),
        (doubling("<gazebo>" + "<a/>" * 500 + "</gazebo>", 9), "its macros make more than 20,000 elements"),
        (
            f'<xacro:property name="p0" value="xxxxxxxxxx"/>{TEXTS}<gazebo><a b="${{p11}}"/></gazebo>',
            "an expression makes",
        ),
        ('<gazebo><a b="${len(str(10**10**9))}"/></gazebo>', "an expression takes more than 1 s"),
        ('<gazebo><a b="${max(range(10**12))}"/></gazebo>', "an expression takes more than 1 s"),
    ],
    ids=["twice", "nothing", "itself", "elements", "texts", "power", "range"],
)
def test_macros_that_make_very_much_are_refused_at_once(tmp_path: Path, inner: str, says: str) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with pytest.raises(FileError, match=r"mine\.xacro: xacro cannot expand it: ") as caught:
        expanding(tmp_path, inner)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    # The limit is 2 s, and Python starts; on a busy machine that is more. Without a limit it took 20 s.
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 10


def test_without_xacro_the_way_to_get_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda module: None)
    with pytest.raises(UserError, match=r"mine\.xacro: needs xacro, .* -m pip install 'xacro>=2\.1'$"):
        expanding(tmp_path, "")


def test_urdf_that_xacro_has_expanded_needs_it_no_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda module: None)
    assert expanding(tmp_path, "", "mine.urdf").drive


def test_a_macro_may_take_the_items_of_a_list_one_by_one(tmp_path: Path) -> None:
    file = tmp_path / "a.urdf.xacro"
    file.write_text(
        '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:macro name="each" params="names"><xacro:if value="${names}">'
        '<xacro:property name="name" value="${names.pop(0)}"/><link name="${name}"/><xacro:each names="${names}"/>'
        "</xacro:if></xacro:macro>"
        """<xacro:each names="${['base', 'left', 'right']}"/></robot>"""
    )
    text, _ = xacro_files.expanded(file.read_text(), str(file), {})
    assert [link.get("name") for link in fromstring(text).iter("link")] == ["base", "left", "right"]


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("2 * r + 1", 1.2),
        (" -r ** 2 if true and not r > 1 else 0", -0.01),
        ("table['a'][1]", 2),
        ("len(table['a'][:1])", 1),
        ("math.cos(math.pi)", -1),
        ("name.split('_')[0] + 'c'", "ac"),
        ("[r, (1, 'x'), {'a': 1}]", [0.1, (1, "x"), {"a": 1}]),
        ("dict(a=r, b='x')", {"a": 0.1, "b": "x"}),
        ("name.find('b')", 2),
        ("'-'.join([name, 'c'])", "a_b-c"),
        ("[name, 'c'].pop(0)", "a_b"),
        ("list(map(float, '1 2.5'.split()))", [1.0, 2.5]),
    ],
)
def test_expressions_calculate(expression: str, value: object) -> None:
    found = xacro_files._evaluated(expression, dict(NAMES))
    assert found == (pytest.approx(value) if isinstance(value, float) else value)


@pytest.mark.parametrize(
    "expression",
    [
        "().__class__.__base__.__subclasses__()",
        "(lambda: ().__class__)()",
        "[x.__class__ for x in [1]]",
        "(x for x in [1]).gi_frame",
        "math",
        "math.__dict__",
        "python.vars(r)",
        "python.type(r)",
        "xacro.vars",
        "vars(r)",
        "type(r)",
        "open('/etc/passwd')",
        "eval('1')",
        "__import__('os')",
        "name.format(r)",
        "name.split('_')[0].format(r)",
        "table['a'].append(1)",
        "sorted([1], key=len)",
        "list(map(map, [1], [2]))",
        "list(map(name.format, [1]))",
        "list(map(open, [name]))",
        "dict(**table)",
        "(len)(*[1])",
        "(len or len)([1])",
        "f'{r!r}'",
        "(y := 1)",
        "len",
    ],
)
def test_expressions_that_may_do_more_are_refused(expression: str) -> None:
    """But for a function that is only named, and numbers in place of arguments, which do nothing."""
    if expression == "len":
        assert xacro_files._evaluated(expression, dict(NAMES)) is len
        return
    with pytest.raises(ValueError, match="is more than arithmetic, and is not evaluated"):
        xacro_files._evaluated(expression, dict(NAMES))


def test_a_name_may_begin_with_an_underscore_but_not_with_two() -> None:
    assert xacro_files._evaluated("2 * _ixx", {**NAMES, "_ixx": 3}) == 6
    with pytest.raises(ValueError, match="__ixx is more than arithmetic, and is not evaluated"):
        xacro_files._evaluated("2 * __ixx", {**NAMES, "__ixx": 3})


def written(path: Path, text: str) -> Path:
    path.write_text(text, "utf-8")
    return path


HEAVY = '<xacro:macro name="heavy" params="m"><mass value="${m}"/></xacro:macro>'


@with_xacro
@pytest.mark.slow
@pytest.mark.parametrize(
    ("inner", "names"),
    [
        ('<property name="side" value="0.2"/><gazebo reference="base"><kp>${side}</kp></gazebo>', "<property>"),
        ('<macro name="heavy" params="m"><mass value="${m}"/></macro>', "<macro>"),
        (HEAVY + "<link name='extra'><heavy m='1'/></link>", "<heavy>"),
        (HEAVY + "<property name='a' value='1'/><heavy m='1'/>", "<property>, <heavy>"),
    ],
)
def test_macros_of_old_files_are_named(tmp_path: Path, inner: str, names: str) -> None:
    with pytest.raises(FileError, match=f"mine.xacro: there is no xacro: before the names of {names}, without which"):
        expanding(tmp_path, inner)


@with_xacro
@pytest.mark.slow
def test_macros_of_included_files_are_not_called_without_xacro_before_them(tmp_path: Path) -> None:
    (tmp_path / "wheels.xacro").write_text(f"<robot {SPACE}>{HEAVY}</robot>")
    include = '<xacro:include filename="wheels.xacro"/>'
    assert expanding(tmp_path, include).drive
    with pytest.raises(FileError, match="there is no xacro: before the names of <heavy>, without which ROS expands"):
        expanding(tmp_path, include + '<heavy m="2"/>')


@with_xacro
@pytest.mark.slow
def test_values_of_included_files_without_xacro_before_them_are_named(tmp_path: Path) -> None:
    (tmp_path / "sizes.xacro").write_text("<robot><property name='side' value='2'/></robot>")
    inner = '<xacro:include filename="sizes.xacro"/><gazebo reference="base"><kp>${side}</kp></gazebo>'
    with pytest.raises(
        FileError, match=r"'side' is not defined .*sizes.xacro: there is no xacro: before the names of <p"
    ):
        expanding(tmp_path, inner)


@with_xacro
@pytest.mark.slow
def test_a_macro_may_be_called_like_an_element(tmp_path: Path) -> None:
    box = '<xacro:macro name="box"><box size="3 3 3"/></xacro:macro><xacro:macro name="visual"/>'
    hull = '<gazebo reference="base"><kp>1</kp></gazebo>'
    assert expanding(tmp_path, box + hull).size == expanding(tmp_path, hull).size


@with_xacro
@pytest.mark.slow
def test_packages_that_are_not_found_are_named_where_their_values_are_missing(tmp_path: Path) -> None:
    include = '<xacro:include filename="$(find b_description)/urdf/lengths.xacro"/>'
    inner = include + '<gazebo reference="base"><kp>${side}</kp></gazebo>'
    (tmp_path / "ws/a_description").mkdir(parents=True)
    (tmp_path / "ws/a_description/package.xml").write_text("<package><name>a_description</name></package>")
    with pytest.raises(FileError, match=r"'side' is not defined .*; these packages are not found: b_description; put"):
        expanding(tmp_path / "ws/a_description", inner)
    deep = tmp_path / "ws/somebodys-repository/common/b"
    (deep / "urdf").mkdir(parents=True)
    (deep / "package.xml").write_text("<package><name>b_description</name></package>")
    (deep / "urdf/lengths.xacro").write_text(f"<robot {SPACE}><xacro:property name='side' value='3000'/></robot>")
    assert "<kp>3000</kp>" in expanding(tmp_path / "ws/a_description", inner).text


@with_xacro
@pytest.mark.slow
@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("1 + 1", "2"),
        ("tall * 2", "5.0"),
        ("kind == 'big' and not flat", "True"),
        ("[kind, flat][1] or pi > 3", "True"),
    ],
)
def test_the_expressions_of_launch_files_calculate(tmp_path: Path, expression: str, value: str) -> None:
    values = {"tall": "2.5", "kind": "big", "flat": "false"}
    inner = "".join(f'<xacro:arg name="{name}" default="{value}"/>' for name, value in values.items())
    robot = expanding(tmp_path, f'{inner}<gazebo><a b="$(eval {expression})"/></gazebo>')
    assert f'b="{value}"' in robot.text


PART = f"<robot {SPACE}><xacro:property name='side' value='3000'/></robot>"


@with_xacro
@pytest.mark.slow
@pytest.mark.parametrize("at", ["urdf/part.xacro", "description/urdf/part.xacro", "a/urdf/part.xacro"])
def test_a_package_is_read_as_it_is_installed(tmp_path: Path, at: str) -> None:
    """CMake installs `description/urdf` of a package as its `urdf`, so its files say this one."""
    package = tmp_path / "clone/b_description"
    (package / at).parent.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>b_description</name></package>")
    (package / at).write_text(PART)
    inner = '<xacro:include filename="$(find b_description)/urdf/part.xacro"/>'
    robot = expanding(package, inner + '<gazebo reference="base"><kp>${side}</kp></gazebo>')
    assert "<kp>3000</kp>" in robot.text


@with_xacro
@pytest.mark.slow
def test_a_folder_that_is_called_as_the_package_that_it_is_in_is_not_taken_for_it(tmp_path: Path) -> None:
    """As packages of Python are, which lie in one of ROS; the clone has any name."""
    clone = tmp_path / "b-ros2"
    (clone / "b_description").mkdir(parents=True)
    (clone / "urdf").mkdir()
    (clone / "package.xml").write_text("<package><name>b_description</name></package>")
    (clone / "urdf/part.xacro").write_text(PART)
    inner = '<xacro:include filename="$(find b_description)/urdf/part.xacro"/>'
    robot = expanding(clone / "urdf", inner + '<gazebo reference="base"><kp>${side}</kp></gazebo>')
    assert "<kp>3000</kp>" in robot.text
