"""Meshes of robots in COLLADA files."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from rsegen.errors import FileError
from rsegen.geometry import mesh_files
from rsegen.geometry.mesh_files import read_collada
from rsegen.robots.files.sdf_file import from_file
from tests.robots.test_body import model

CORNERS = "0 0 0  2 0 0  2 1 0  0 1 0  0 0 3"
TRIANGLES = "<triangles count='2'><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2 0 2 3</p></triangles>"
POLYLIST = """<polylist count='1'><input semantic='NORMAL' source='#n' offset='0'/>
<input semantic='VERTEX' source='#v' offset='1'/><vcount>4</vcount><p>7 0 7 1 7 2 7 3</p></polylist>"""
POLYGONS = "<polygons count='1'><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2 3</p></polygons>"
NODE = "<node><instance_geometry url='#g'/></node>"


def document(nodes: str = NODE, faces: str = TRIANGLES, unit: str = "<unit meter='1'/>", library: str = "") -> str:
    """A file with the geometry `g`, whose points are CORNERS, in two columns more than are of use."""
    rows = " ".join(f"{corner} 9" for corner in CORNERS.split("  "))
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{unit}</asset>
<library_geometries><geometry id="g"><mesh><source id="s"><float_array id="a" count="20">{rows}</float_array>
<technique_common><accessor source="#a" count="5" stride="4"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>{faces}</mesh></geometry></library_geometries>
<library_nodes>{library}</library_nodes>
<library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""


def box_of(folder: Path, text: str) -> list[float]:
    """The lowest and the highest corner of all triangles."""
    (folder / "hull.dae").write_text(text, "utf-8")
    points, corners = read_collada(folder / "hull.dae")
    ends = points[corners].reshape(-1, 3)
    return [*ends.min(axis=0).round(9), *ends.max(axis=0).round(9)]


@pytest.mark.parametrize("faces", [TRIANGLES, POLYLIST, POLYGONS])
def test_triangles_and_polygons_are_read_and_points_without_any_are_left_out(faces: str, tmp_path: Path) -> None:
    assert box_of(tmp_path, document(faces=faces)) == [0, 0, 0, 2, 1, 0]
    points, corners = read_collada(tmp_path / "hull.dae")
    np.testing.assert_array_equal(points[corners], points[[[0, 1, 2], [0, 2, 3]]])


@pytest.mark.parametrize(
    ("transforms", "box"),
    [
        ("<translate>1 2 3</translate>", [1, 2, 3, 3, 3, 3]),
        ("<scale>1 2 1</scale>", [0, 0, 0, 2, 2, 0]),
        ("<rotate>0 0 2 90</rotate>", [-1, 0, 0, 0, 2, 0]),
        ("<matrix>1 0 0 5  0 1 0 0  0 0 1 0  0 0 0 1</matrix>", [5, 0, 0, 7, 1, 0]),
        ("<translate>1 0 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>", [0, 0, 0, 1, 4, 0]),
    ],
)
def test_each_transform_of_a_node_is_in_the_frame_of_those_before_it(
    transforms: str, box: list[float], tmp_path: Path
) -> None:
    assert box_of(tmp_path, document(f"<node>{transforms}<instance_geometry url='#g'/></node>")) == box
    assert box_of(tmp_path, document(f"<node>{transforms}{NODE}</node>")) == box


def test_a_node_of_the_library_is_placed_wherever_it_is_named(tmp_path: Path) -> None:
    library = "<node id='part'><translate>0 0 1</translate><instance_geometry url='#g'/></node>"
    nodes = (
        "<node><instance_node url='#part'/></node><node><translate>5 0 0</translate><instance_node url='#part'/></node>"
    )
    assert box_of(tmp_path, document(nodes, library=library)) == [0, 0, 1, 7, 1, 1]


def test_lengths_are_in_the_unit_of_the_file_and_the_axis_that_points_up_is_left_alone_as_in_gazebo(
    tmp_path: Path,
) -> None:
    unit = "<unit name='centimeter' meter='0.01'/><up_axis>Y_UP</up_axis>"
    moved = f"<node><translate>100 0 0</translate>{NODE}</node>"
    assert box_of(tmp_path, document(moved, unit=unit)) == [1, 0, 0, 1.02, 0.01, 0]
    assert box_of(tmp_path, document(unit="")) == [0, 0, 0, 2, 1, 0]


def test_ids_that_geometries_share_are_those_of_their_own_points(tmp_path: Path) -> None:
    first = document().partition("<library_geometries>")[2].partition("</library_geometries>")[0]
    second = first.replace('id="g"', 'id="h"').replace(
        "0 0 0 9 2 0 0 9 2 1 0 9 0 1 0 9", "5 5 5 9 7 5 5 9 7 6 5 9 5 6 5 9"
    )
    both = document(NODE + "<node><instance_geometry url='#h'/></node>").replace(first, first + second)
    assert both.count('id="v"') == 2
    assert box_of(tmp_path, both) == [0, 0, 0, 7, 6, 5]
    assert len(read_collada(tmp_path / "hull.dae").corners) == 4


def test_a_node_may_have_the_id_of_its_geometry(tmp_path: Path) -> None:
    assert box_of(tmp_path, document("<node id='g'><instance_geometry url='#g'/></node>")) == [0, 0, 0, 2, 1, 0]


def test_a_robot_with_such_a_mesh_needs_no_size_and_stands_on_its_triangles(tmp_path: Path) -> None:
    downward = TRIANGLES.replace("0 1 2 0 2 3", "0 2 1 0 3 2")
    (tmp_path / "hull.dae").write_text(document(faces=downward, unit="<unit meter='0.1'/>"), "utf-8")
    robot = from_file(model(tmp_path, f"<geometry><mesh><uri>{tmp_path}/hull.dae</uri></mesh></geometry>"))
    assert "size" in robot.derived
    assert robot.size[:2] == pytest.approx((0.4, 0.2))
    assert robot.body.low[2] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (document(""), "has no triangles"),
        (document("<node><instance_geometry url='#none'/></node>"), "not a DAE file that can be read"),
        (document(faces=TRIANGLES.replace("0 2 3", "0 2 9")), "a corner of a triangle is no point"),
        (document(faces=TRIANGLES.replace("0 2 3", "0 2")), "not a DAE file that can be read"),
        (document("<node><matrix>1 2 3</matrix></node>"), "not a DAE file that can be read"),
        (document("<node id='own'><instance_node url='#own'/></node>"), "not a DAE file that can be read"),
        (
            document("<node><rotate>0 0 0 90</rotate><instance_geometry url='#g'/></node>"),
            "a point whose place is no number",
        ),
        (document().replace("0 1 0 9", "0 nan 0 9"), "a point whose place is no number"),
        (document().replace("<COLLADA", "<!DOCTYPE a><COLLADA"), "contains a DOCTYPE or entities"),
        ("no xml", "not XML"),
    ],
)
def test_what_is_no_mesh_is_refused_in_a_line(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=message) as error:
        box_of(tmp_path, text)
    assert "\n" not in str(error.value)


def test_a_geometry_may_not_be_named_without_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh_files, "_MOST_TRIANGLES", 100)  # of 5 points each
    with pytest.raises(FileError, match="more than 100 triangles"):
        box_of(tmp_path, document(NODE * 21))
    assert box_of(tmp_path, document(NODE * 20)) == [0, 0, 0, 2, 1, 0]


def test_nodes_that_double_themselves_end_within_a_second(tmp_path: Path) -> None:
    two = "<node id='n{0}'><instance_node url='#n{1}'/><instance_node url='#n{1}'/></node>"
    library = "".join(two.format(depth, depth + 1) for depth in range(60)) + "<node id='n60'/>"
    began = time.process_time()
    with pytest.raises(FileError, match="more than 10000 nodes"):
        box_of(tmp_path, document("<node><instance_node url='#n0'/></node>", library=library))
    assert time.process_time() - began < 1
