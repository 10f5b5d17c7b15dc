"""Clouds in files that others wrote: the same points come back; what is no cloud is one line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
import trimesh
from laspy.vlrs.vlr import VLR
from laspy.vlrs.vlrlist import VLRList
from PIL import Image
from pypcd4.pypcd4 import Encoding, PointCloud

from rsegen.errors import FileError, ParameterError, UserError
from rsegen.field.stepfield import Array
from rsegen.scanning import clouds
from rsegen.scanning.clouds import read_clouds

POINTS = np.round(np.random.default_rng(3).random((800, 3)) * 4 - 2, 4)


def text(path: Path, **options: Any) -> None:
    np.savetxt(path, POINTS, fmt="%.6f", **options)


def titled(path: Path) -> None:
    coloured = np.column_stack([POINTS, np.full((len(POINTS), 3), 255)])
    np.savetxt(path, coloured, fmt="%.6f", delimiter=";", header="x;y;z;r;g;b", comments="")


def counted(path: Path) -> None:
    np.savetxt(path, POINTS, fmt="%.6f", header=str(len(POINTS)), comments="")


def pcd(encoding: Encoding) -> Callable[[Path], None]:
    return lambda path: PointCloud.from_xyz_points(POINTS.astype("f4")).save(path, encoding=encoding)


def ply(encoding: str) -> Callable[[Path], Any]:
    return lambda path: path.write_bytes(trimesh.PointCloud(POINTS).export(file_type="ply", encoding=encoding))


def named(path: Path) -> None:
    """Columns in another order, with units, as CloudCompare and spreadsheets name them."""
    count = np.arange(len(POINTS))
    columns = np.column_stack([count, POINTS[:, [2, 0, 1]]])
    np.savetxt(path, columns, fmt="%.6f", delimiter=",", header='"No","Z [m]","X [m]","Y (m)"', comments="//")


def with_decimal_commas(separator: str) -> Callable[[Path], Any]:
    lines = (separator.join(f"{value:.6f}".replace(".", ",") for value in point) for point in POINTS)
    content = "\n".join(lines)
    return lambda path: path.write_text(content)


def upper_pcd(path: Path) -> None:
    head = f"VERSION .7\nFIELDS Intensity Z Y X\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {len(POINTS)}\n"
    head += f"HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(POINTS)}\nDATA ascii\n"
    rows = (" ".join(f"{value:.6f}" for value in (7, *point[::-1])) for point in POINTS)
    path.write_text(head + "\n".join(rows) + "\n")


def aligned_pcd(path: Path) -> None:
    """Columns that blanks align, with some at the ends of lines, after a field of two values and colours as numbers."""
    head = "# .PCD v.7\nVERSION .7\nFIELDS pair rgb x y z\nSIZE 4 4 4 4 4\nTYPE F U F F F\nCOUNT 2 1 1 1 1\n"
    head += f"WIDTH {len(POINTS)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(POINTS)}\nDATA ascii\n"
    rows = ("  7 8 4.2e+06" + "".join(f"{value:16.6f}" for value in point) + " " for point in POINTS)
    path.write_text(head + "\n".join(rows) + "\n")


def old_pcd(*, binary: bool) -> Callable[[Path], Any]:
    """A file of version .5, in whose header COUNT, HEIGHT and POINTS are left out, as PCL reads them too."""
    head = f"# .PCD v.5\nVERSION .5\nCOLUMNS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH {len(POINTS)}\nDATA "
    body = POINTS.astype("<f8").tobytes() if binary else str(POINTS.tolist()).translate(_BLANKS).encode()
    return lambda path: path.write_bytes(head.encode() + (b"binary\n" if binary else b"ascii\n") + body)


_BLANKS = str.maketrans({"[": " ", "]": "\n", ",": " "})


def of_names(path: Path) -> None:
    array = np.zeros(len(POINTS), dtype=[("rgb", "u4"), ("X", "f8"), ("Y", "f8"), ("Z", "f8")])
    for axis, values in zip("XYZ", POINTS.T, strict=True):
        array[axis] = values
    np.save(path, array)


def las(path: Path, points: Array = POINTS, *records: VLR, behind: Sequence[VLR] = ()) -> None:
    """A laser scan with whole tenths of a millimetre, as surveyors write it; records: of its coordinate system."""
    header = (
        laspy.LasHeader(point_format=6, version="1.4") if behind else laspy.LasHeader(point_format=3, version="1.2")
    )
    header.vlrs.extend(records)
    scan = laspy.LasData(header)
    scan.header.scales = np.full(3, 1e-4)
    scan.x, scan.y, scan.z = points.T
    if behind:
        scan.evlrs = VLRList(behind)
    scan.write(str(path))


def geokeys(*keys: int) -> VLR:
    """The keys of a coordinate reference system as GeoTIFF has them."""
    return VLR("LASF_Projection", 34735, "", np.array([1, 1, 0, len(keys) // 4, *keys], "<u2").tobytes())


def wkt(text: str) -> VLR:
    """The text of a coordinate reference system."""
    return VLR("LASF_Projection", 2112, "", text.encode() + b"\0")


WRITERS: Mapping[str, Callable[[Path], Any]] = {
    "a.xyz": text,
    "b.txt": lambda path: text(path, delimiter=", "),
    "c.csv": titled,
    "d.pts": counted,
    "e.asc": lambda path: text(path, delimiter="\t", header="points of a room"),
    "f.npy": lambda path: np.save(path, POINTS),
    "g.pcd": pcd(Encoding.ASCII),
    "h.pcd": pcd(Encoding.BINARY),
    "i.pcd": pcd(Encoding.BINARY_COMPRESSED),
    "j.ply": ply("binary"),
    "k.ply": ply("ascii"),
    "l.csv": named,
    "m.txt": lambda path: np.savetxt(path, POINTS, fmt="%.6f", delimiter="\t", header="x\ty\tz", comments=""),
    "n.csv": lambda path: np.savetxt(
        path, np.column_stack([POINTS, POINTS[:, 0]]), fmt="%.6f", delimiter=";", header="X;Y;Z;time", comments=""
    ),
    "o.txt": with_decimal_commas(";"),
    "p.txt": with_decimal_commas("\t"),
    "q.txt": with_decimal_commas(" "),
    "r.csv": with_decimal_commas(", "),
    "s.pcd": upper_pcd,
    "t.npy": lambda path: np.save(path, np.column_stack([POINTS, POINTS[:, 0]])),
    "u.npy": lambda path: np.save(path, np.column_stack([POINTS, POINTS]).astype("f4").reshape(20, 40, 6)),
    "v.npy": of_names,
    "w.las": las,
    "x.laz": las,
    "y.pcd": aligned_pcd,
    "z.pcd": old_pcd(binary=False),
    "1.pcd": old_pcd(binary=True),
}


@pytest.mark.parametrize("name", WRITERS)
def test_the_points_of_a_file_come_back(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path / name)
    assert np.abs(read_clouds([tmp_path / name]).points - POINTS).max() < 1e-5


@pytest.mark.parametrize(
    ("titles", "order"),
    [
        ("id,Easting,Northing,Elevation", "-xyz"),
        ("Easting,Northing,Elevation,Intensity", "xyz-"),
        ("Points_Magnitude,Points_0,Points_1,Points_2", "-xyz"),
        ("Points:2,Points:0,Points:1,Scalars", "zxy-"),
        ('"laser_id","Points_m_XYZ:0","Points_m_XYZ:1","Points_m_XYZ:2"', "-xyz"),
        ("time,field.position.x,field.position.y,field.position.z", "-xyz"),
        ("pos_z,pos_x,pos_y", "zxy"),
        ("position.x,x,y,z", "-xyz"),
    ],
)
def test_columns_of_other_titles_are_those_of_the_axes(titles: str, order: str, tmp_path: Path) -> None:
    columns = {**dict(zip("xyz", POINTS.T, strict=True)), "-": np.arange(len(POINTS))}
    table = np.column_stack([columns[axis] for axis in order])
    np.savetxt(tmp_path / "a.csv", table, fmt="%.6f", delimiter=",", header=titles, comments="")
    assert np.abs(read_clouds([tmp_path / "a.csv"]).points - POINTS).max() < 1e-5


@pytest.mark.parametrize(
    ("titles", "metres"),
    [
        ("x [mm];y [mm];z [mm]", 0.001),
        ('"X(cm)";"Y(cm)";"Z(cm)"', 0.01),
        ("x_mm;y_mm;z_mm", 0.001),
        ("x/ft;y/ft;z/ft", 0.3048),
        ("x [in];y;z", 0.0254),
        ("x_in;y_in;z_in", 1),
        ("x [m];y [m];z [m]", 1),
    ],
)
def test_points_are_in_the_unit_that_the_titles_say(titles: str, metres: float, tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.csv", POINTS, fmt="%.6f", delimiter=";", header=titles, comments="")
    assert np.abs(read_clouds([tmp_path / "a.csv"]).points - POINTS * metres).max() < 1e-5
    assert np.abs(read_clouds([tmp_path / "a.csv"], values="cm").points - POINTS / 100).max() < 1e-5


def test_several_files_are_one_cloud_in_the_unit_that_is_given(tmp_path: Path) -> None:
    text(tmp_path / "a.xyz")
    np.save(tmp_path / "b.npy", POINTS)
    found = read_clouds([tmp_path / "a.xyz", tmp_path / "b.npy"], values="mm").points
    assert np.allclose(found, np.concatenate([POINTS, POINTS]) / 1000)


DEGREES = 'GEOGCS["WGS 84",DATUM["W",SPHEROID["W",6378137,298.257]],UNIT["degree",0.01745]]'
IN_FEET = f'PROJCS["Ohio",{DEGREES},UNIT["US survey foot",0.304800609601219]]'
UP_IN_METRES = 'VERT_CS["NAVD88",VERT_DATUM["N",2005],UNIT["metre",1]]'


@pytest.mark.parametrize(
    ("records", "behind", "place", "code"),
    [
        ([geokeys(1024, 0, 1, 2)], [], (9.5, 47.2), "EPSG:32632"),
        ([wkt(DEGREES)], [], (-70.5, -33.4), "EPSG:32719"),
        ([geokeys(1024, 0, 1, 1), wkt(DEGREES)], [], (9.5, 47.2), "EPSG:32632"),
        ([], [wkt(DEGREES)], (180, 0), "EPSG:32660"),
        ([wkt(DEGREES)], [], (500, 400), "EPSG:CODE"),
    ],
)
def test_a_laser_scan_in_degrees_says_how_to_project_it(
    tmp_path: Path, records: Sequence[VLR], behind: Sequence[VLR], place: tuple[float, float], code: str
) -> None:
    path = tmp_path / "a.las"
    las(path, POINTS[:10] * (1e-5, 1e-5, 1) + (*place, 0), *records, behind=behind)
    command = f"pdal translate FILE NEW.laz reprojection --filters.reprojection.out_srs={code}"
    with pytest.raises(FileError) as refused:
        read_clouds([path])
    assert str(refused.value) == f"{path}: its places are in degrees; write them in metres with `{command}`"


def test_a_laser_scan_in_mercators_projection_says_how_to_project_it(tmp_path: Path) -> None:
    web = geokeys(1024, 0, 1, 1, 3072, 0, 1, 3857, 3076, 0, 1, 9001)
    las(tmp_path / "local.las", POINTS, web)
    assert np.abs(read_clouds([tmp_path / "local.las"]).points - POINTS).max() < 1e-5
    far = wkt(f'PROJCS["Web",{DEGREES},PROJECTION["Mercator_Auxiliary_Sphere"],UNIT["kilometre",1000]]')
    las(tmp_path / "a.las", POINTS[:10] + np.array([1000, 8_399.738, 0]), far)
    with pytest.raises(FileError, match=r"in Mercator's projection, .* as far apart as on the ground; .*EPSG:32632`"):
        read_clouds([tmp_path / "a.las"])


@pytest.mark.parametrize(
    ("records", "values", "scale"),
    [
        ([geokeys(1024, 0, 1, 1, 3076, 0, 1, 9001)], None, (1, 1, 1)),
        ([geokeys(1024, 0, 1, 1)], None, (1, 1, 1)),
        ([geokeys(1024, 0, 1, 1, 3076, 0, 1, 9003)], None, (0.3048, 0.3048, 0.3048)),
        ([geokeys(1024, 0, 1, 1, 3076, 0, 1, 9001, 4099, 0, 1, 9002)], None, (1, 1, 0.3048)),
        ([wkt(IN_FEET)], None, (0.3048, 0.3048, 0.3048)),
        ([wkt(f'COMPD_CS["both",{IN_FEET},{UP_IN_METRES}]')], None, (0.3048, 0.3048, 1)),
        ([wkt(IN_FEET)], "cm", (0.01, 0.01, 0.01)),
    ],
)
def test_a_laser_scan_is_read_in_the_unit_that_it_says(
    tmp_path: Path, records: Sequence[VLR], values: str | None, scale: tuple[float, float, float]
) -> None:
    las(tmp_path / "a.las", POINTS, *records)
    assert np.abs(read_clouds([tmp_path / "a.las"], values=values).points - POINTS * scale).max() < 1e-5


def test_a_laser_scan_in_a_unit_that_is_not_known_is_refused(tmp_path: Path) -> None:
    las(tmp_path / "a.las", POINTS, wkt(IN_FEET.replace("0.304800609601219", "0.9144")))
    with pytest.raises(FileError, match=r"a\.las: a unit of its places is 0\.9144 m; write them in metres with `pdal "):
        read_clouds([tmp_path / "a.las"])


def depths(shape: tuple[int, int] = (6, 8)) -> Array:
    return np.arange(1000.0, 1000 + 10 * shape[0] * shape[1], 10).reshape(shape)


@pytest.mark.parametrize("shape", [(-1, 3), (-1, 3, 1), (-1, 1, 3), (20, -1, 3)])
def test_points_may_have_an_axis_more(shape: tuple[int, ...], tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", POINTS.reshape(shape))
    assert np.array_equal(read_clouds([tmp_path / "a.npy"]).points, POINTS)


@pytest.mark.parametrize("name", ["depth.png", "depth.tif", "depth.npy", "with_a_channel.npy"])
def test_a_depth_image_is_seen_through_its_camera(name: str, tmp_path: Path) -> None:
    depth = depths().astype(np.uint16)
    depth[0, 0], depth[-1, -1] = 0, 65535  # holes
    if name.endswith("npy"):
        np.save(tmp_path / name, depth[..., None] if name.startswith("with") else depth)
    else:
        Image.fromarray(depth).save(tmp_path / name)
    found = read_clouds([tmp_path / name], intrinsics=(4.0, 5.0, 3.5, 2.5)).points
    v, u = np.indices(depth.shape).reshape(2, -1)[:, 1:-1]
    z = depth.reshape(-1)[1:-1] / 1000
    assert np.allclose(found, np.column_stack([(u - 3.5) / 4 * z, (v - 2.5) / 5 * z, z]))


def damaged(content: bytes) -> Callable[[Path], Any]:
    return lambda path: path.write_bytes(content)


def las_with(at: int, number: bytes, *, points: int = len(POINTS)) -> Callable[[Path], Any]:
    """A laser scan with another number in its header, and only some of its points."""

    def write(path: Path) -> None:
        las(path)
        content = path.read_bytes()
        end = len(content) - (len(POINTS) - points) * 34  # bytes of a point
        path.write_bytes(content[:at] + number + content[at + len(number) : end])

    return write


PCD = b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n"
PLANE_PLY = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n"
NO_CLOUDS: Mapping[str, tuple[Callable[[Path], Any], str]] = {
    "a.fls": (damaged(b"laser"), "clouds are read from files named"),
    "a.las": (damaged(b"LASF"), "a.las: not a LAS file that can be read"),
    "a.laz": (damaged(b"LASF" + bytes(400)), "a.laz: "),
    "b.las": (las_with(100, b"\xff\xff\xff\x7f"), "its header counts 2,147,483,647 records of variable length"),
    "c.las": (las_with(0, b"", points=700), "has 700 of the 800 points that it says"),
    "a.bt": (damaged(b"# Octomap OcTree binary file\n"), "write its points with `octree2pointcloud FILE NEW.pcd`"),
    "a.asc": (damaged(b"ncols 3\nnrows 1\ncellsize 5\n1 2 3\n"), "not points; rsegen import reads it"),
    "b.ply": (damaged(PLANE_PLY), "not a PLY file that can be read (lacks 'z')"),
    "w.pcd": (damaged(b"1 2 3\n" * 20), "no FIELDS, SIZE, TYPE, WIDTH, DATA in its header"),
    "b.xyz": (damaged(b"no numbers\nat all"), "no line has three numbers"),
    "c.xyz": (damaged(b"1 2 3\n4 5\n"), "c.xyz: "),
    "d.xyz": (damaged(b"1 2 3\n4 five 6\n"), "d.xyz: "),
    "e.xyz": (damaged(b"\xff\xfe\x00"), "not a text in UTF-8"),
    "f.ply": (damaged(b"ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n"), "f.ply: "),
    "g.ply": (damaged(b"no ply"), "not a PLY file"),
    "h.pcd": (damaged(b"VERSION .7\nFIELDS x y\n"), "not a PCD file"),
    "i.pcd": (damaged(bytes(200)), "not a PCD file"),
    "v.pcd": (damaged(PCD.replace(b"POINTS 1", b"POINTS 3")), "has 1 of the 3 points that it says"),
    "p.pcd": (damaged(PCD.replace(b"COUNT 1 1 1", b"COUNT 1 4294967296 1")), "4,294,967,298 values per point"),
    "q.pcd": (damaged(PCD.replace(b"POINTS 1", b"POINTS 99999999999")), "99,999,999,999 points"),
    "j.npy": (lambda path: np.save(path, np.ones((2, 3, 4))), "expected points (n, 3)"),
    "k.npy": (lambda path: np.save(path, np.array(["a", "b"])), "k.npy: "),
    "r.npy": (lambda path: np.save(path, np.ones((3, 900))), "use its transpose"),
    "s.csv": (damaged(b"0,033,-0,566,0,000\n0,317,-0,333,0,400\n"), "write semicolons or blanks between them"),
    "t.csv": (damaged(b"x,y,height\n1,2,3\n"), "0 of the titles 'x,y,height' name the column of z"),
    "ta.csv": (damaged(b"id,a,b,c\n7,1,2,3\n"), "none of the titles 'id,a,b,c' name the columns of x, y and z; name"),
    "tb.csv": (damaged(b"n,pos.x,pos.y,pos.z,v.x\n7,1,2,3,4\n"), "2 of the titles 'n,pos.x,pos.y,pos.z,v.x' name the "),
    "tc.csv": (damaged(b"x [mm],y [mm],z [m]\n1,2,3\n"), "x, y and z are in m and mm; write all three in one unit"),
    "u.pcd": (damaged(PCD.replace(b"x y z", b"u v w")), "no field x among u, v, w"),
    "l.png": (damaged(b"no image"), "not an image"),
    "m.png": (lambda path: Image.new("RGB", (4, 4)).save(path), "expected a depth image of one channel"),
    "n.stl": (damaged(b""), "n.stl: "),
    "o.xyz": (lambda path: path.mkdir(), "o.xyz: "),
}


@pytest.mark.parametrize("name", NO_CLOUDS)
def test_an_invalid_cloud_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    write, said = NO_CLOUDS[name]
    write(tmp_path / name)
    with pytest.raises(FileError) as refused:
        read_clouds([tmp_path / name], intrinsics=None)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("largest", [200, 255, 300, 4095, 65535])
def test_depths_of_a_pgm_are_its_numbers_whatever_its_largest_is(largest: int, tmp_path: Path) -> None:
    depth = np.arange(1, 49).reshape(6, 8) * 4
    numbers = depth.astype(">u2" if largest > 255 else "u1")
    (tmp_path / "depth.pgm").write_bytes(f"P5\n8 6\n{largest}\n".encode() + numbers.tobytes())
    values = None if largest > 255 else "mm"
    cloud = read_clouds([tmp_path / "depth.pgm"], values, intrinsics=(5, 5, 2, 2))
    assert cloud.points[:, 2] == pytest.approx(depth.ravel() / 1000)


@pytest.mark.parametrize("name", ["depth.png", "depth.pgm", "depth.tif"])
def test_a_depth_image_of_three_columns_is_no_list_of_points(name: str, tmp_path: Path) -> None:
    depth = depths((8, 3)).astype(np.uint16)
    Image.fromarray(depth).save(tmp_path / name)
    with pytest.raises(ParameterError, match="is a depth image; pass fx,fy,cx,cy"):
        read_clouds([tmp_path / name])
    z = read_clouds([tmp_path / name], intrinsics=(5, 5, 1, 4)).points[:, 2]
    assert z == pytest.approx(depth[depth > 0] / 1000)


def test_the_viewpoint_of_a_pcd_file_is_not_applied(tmp_path: Path) -> None:
    """The readers of the Point Cloud Library and of Open3D give the points as they are in the file."""
    for name, viewpoint in (("a.pcd", b"0 0 0 1 0 0 0"), ("b.pcd", b"1 2 3 0 1 0 0")):
        (tmp_path / name).write_bytes(PCD.replace(b"POINTS", b"VIEWPOINT " + viewpoint + b"\nPOINTS"))
    first, second = (read_clouds([tmp_path / name]).points for name in ("a.pcd", "b.pcd"))
    assert len(first)
    assert np.array_equal(first, second)


@pytest.mark.parametrize("name", ["depth.png", "depth.npy"])
def test_depths_of_8_bits_have_no_unit_by_themselves(name: str, tmp_path: Path) -> None:
    depth, path = np.arange(1, 49, dtype=np.uint8).reshape(6, 8), tmp_path / name
    if name.endswith("npy"):
        np.save(path, depth)
    else:
        Image.fromarray(depth).save(path)
    with pytest.raises(
        ParameterError, match=rf"values: .*{name} has depths of 8 bits, too few for millimetres; set mm"
    ):
        read_clouds([path], intrinsics=(5, 5, 2, 2))
    assert read_clouds([path], "cm", (5, 5, 2, 2)).points[:, 2] == pytest.approx(depth.ravel() / 100)


def test_faces_that_count_their_corners_backwards_are_where_they_are_in_the_file(tmp_path: Path) -> None:
    low, high = ("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", "v 2 0 1\nv 3 0 1\nv 3 1 1\nv 2 1 1\n")
    (tmp_path / "a.obj").write_text(f"{low}f -4 -3 -2 -1\n{high}f -4 -3 -2 -1\n")
    points = read_clouds([tmp_path / "a.obj"], up=(0, 0, 1)).points
    is_low = points[:, 2] < 0.5
    assert 0.4 < is_low.mean() < 0.6
    assert points[is_low, 0].max() < 1.001
    assert points[~is_low, 0].min() > 1.999


def test_a_depth_image_wants_its_camera_and_points_want_none(tmp_path: Path) -> None:
    np.save(tmp_path / "depth.npy", depths())
    text(tmp_path / "points.xyz")
    with pytest.raises(ParameterError, match="pass fx,fy,cx,cy"):
        read_clouds([tmp_path / "depth.npy"])
    with pytest.raises(ParameterError, match="have to be above 0"):
        read_clouds([tmp_path / "depth.npy"], intrinsics=(0, 1, 1, 1))
    with pytest.raises(ParameterError, match="has points, not the depths"):
        read_clouds([tmp_path / "points.xyz"], intrinsics=(1, 1, 1, 1))


@pytest.mark.parametrize(
    ("intrinsics", "is_doubtful"),
    [
        ((600, 600, 319.5, 239.5), False),
        ((615, 610, 332, 228), False),
        ((900, 900, 639.5, 359.5), True),  # of an image of 1280 x 720
        ((300, 300, 159.5, 119.5), True),
        ((600, 600, 239.5, 319.5), True),  # of an image upright
        ((600, 319.5, 600, 239.5), True),  # as a matrix has them
    ],
)
def test_intrinsics_of_another_image_are_doubtful(
    intrinsics: tuple[float, ...], *, is_doubtful: bool, tmp_path: Path
) -> None:
    np.save(tmp_path / "depth.npy", np.ones((480, 640)))
    said = ",".join(f"{number:g}" for number in intrinsics)
    wanted = f"intrinsics {said} are perhaps of another image than one of 640 x 480 pixels"
    assert read_clouds([tmp_path / "depth.npy"], intrinsics=intrinsics).doubt == wanted * is_doubtful


def test_too_many_points_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clouds, "MOST_POINTS", 100)
    for name in ("a.xyz", "f.npy", "g.pcd", "j.ply"):
        WRITERS[name](tmp_path / name)
        with pytest.raises(FileError, match="800 points; at most 100 are allowed"):
            read_clouds([tmp_path / name])


def test_a_missing_library_is_named_with_its_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    WRITERS["g.pcd"](tmp_path / "g.pcd")
    monkeypatch.setitem(__import__("sys").modules, "pypcd4", None)
    monkeypatch.setitem(__import__("sys").modules, "pypcd4.pypcd4", None)
    with pytest.raises(UserError, match=r"needs pypcd4.*, which is not installed; .* -m pip install .*'pypcd4>="):
        read_clouds([tmp_path / "g.pcd"])


class PanicException(BaseException):
    """Exception of code in Rust, as lazrs does at files of early versions of LASzip: no Exception."""


@pytest.mark.parametrize(("raised", "seen"), [(PanicException("no table"), FileError), (KeyboardInterrupt(), None)])
def test_a_library_that_panics_is_one_line_and_a_signal_stays_one(
    raised: BaseException, seen: type[BaseException] | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def panics(*_: object) -> None:
        raise raised

    WRITERS["w.las"](tmp_path / "w.las")
    monkeypatch.setattr(laspy, "open", panics)
    with pytest.raises(seen or type(raised)) as refused:
        read_clouds([tmp_path / "w.las"])
    assert not seen or str(refused.value).endswith("w.las: not a LAS file that can be read (no table)")
