"""Units of places in maps of ground: keys of GeoTIFF, WKT of both versions, and NAME.prj next to grids of Esri."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from PIL.TiffImagePlugin import ImageFileDirectory_v2

from rsegen.cli.edge import main
from rsegen.errors import FileError
from rsegen.heights.base import heights_in
from rsegen.heights.coordinate_system import CoordinateSystem, of_keys, of_wkt
from rsegen.heights.image import Picture
from rsegen.heights.table import Table
from rsegen.recipe.recipe_file import load

FOOT = 1200 / 3937
HEIGHTS = (100 + np.arange(12).reshape(3, 4)).astype("f4")

DEGREES = [1, 1, 0, 1, 1024, 0, 1, 2]
METRES = [1, 1, 0, 3, 1024, 0, 1, 1, 3072, 0, 1, 32632, 3076, 0, 1, 9001]
FEET = [1, 1, 0, 2, 1024, 0, 1, 1, 3076, 0, 1, 9003]
WITHOUT_UNIT = [1, 1, 0, 1, 1024, 0, 1, 1]

GEOGCS = 'GEOGCS["WGS 84",DATUM["W",SPHEROID["W",6378137,298.257]],PRIMEM["Greenwich",0],UNIT["degree",0.01745]]'
UTM = f'PROJCS["UTM zone 32N",{GEOGCS},PROJECTION["Transverse_Mercator"],PARAMETER["scale",0.9996],UNIT["metre",1]]'
OHIO = f'PROJCS["Ohio (ftUS)",{GEOGCS},UNIT["US survey foot",{FOOT}],AXIS["Easting",EAST]]'
NAVD88 = 'VERT_CS["NAVD88 height",VERT_DATUM["N",2005],UNIT["metre",1],AXIS["Up",UP]]'
UTM_2019 = """PROJCRS["WGS 84 / UTM zone 32N",
  BASEGEOGCRS["WGS 84",DATUM["W",ELLIPSOID["WGS 84",6378137,298.257,LENGTHUNIT["metre",1]]]],
  CONVERSION["UTM",METHOD["TM"],PARAMETER["False easting",500000,LENGTHUNIT["foot",0.3048]]],CS[Cartesian,2],
  AXIS["(E)",east,ORDER[1],LENGTHUNIT["kilometre",1000]],AXIS["(N)",north,LENGTHUNIT["kilometre",1000]]]"""
MERCATOR = UTM.replace("Transverse_Mercator", "Mercator_1SP")
MERCATOR_2019 = UTM_2019.replace('METHOD["TM"]', 'METHOD["Popular Visualisation Pseudo Mercator",ID["EPSG",1024]]')
OBLIQUE = UTM.replace("Transverse_Mercator", "Hotine_Oblique_Mercator_Azimuth_Center")
CENTRE_OF_EARTH = 'GEODCRS["WGS 84",DATUM["W"],CS[Cartesian,3],AXIS["(X)",geocentricX,LENGTHUNIT["metre",1]]]'


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (GEOGCS, CoordinateSystem(is_geographic=True)),
        (GEOGCS.replace("[", "(").replace("]", ")"), CoordinateSystem(is_geographic=True)),
        (
            'GEOGCRS["WGS 84",DATUM["W"],CS[ellipsoidal,2],ANGLEUNIT["degree",0.017]]',
            CoordinateSystem(is_geographic=True),
        ),
        (CENTRE_OF_EARTH.replace("Cartesian", "ellipsoidal"), CoordinateSystem(is_geographic=True)),
        (f'COMPD_CS["both",{GEOGCS},{NAVD88}]', CoordinateSystem(is_geographic=True, metres_up=1.0)),
        ("Projection    GEOGRAPHIC\nDatum WGS84\nUnits         DD\n", CoordinateSystem(is_geographic=True)),
        (UTM, CoordinateSystem(metres=1.0)),
        (UTM_2019, CoordinateSystem(metres=1000.0)),
        (MERCATOR, CoordinateSystem(metres=1.0, is_mercator=True)),
        (
            UTM.replace("Transverse_Mercator", "Mercator_Auxiliary_Sphere"),
            CoordinateSystem(metres=1.0, is_mercator=True),
        ),
        (MERCATOR_2019, CoordinateSystem(metres=1000.0, is_mercator=True)),
        (OBLIQUE, CoordinateSystem(metres=1.0)),
        (f'COMPD_CS["both",{OHIO},{NAVD88}]', CoordinateSystem(metres=FOOT, metres_up=1.0)),
        ("Projection STATEPLANE\nUnits FEET\n", CoordinateSystem(metres=0.3048)),
        (CENTRE_OF_EARTH, CoordinateSystem()),
        ("", CoordinateSystem()),
        ("PROJCS[" * 10_000 + 'UNIT["metre",x', CoordinateSystem()),
    ],
)
def test_the_units_of_a_text_in_wkt(text: str, wanted: CoordinateSystem) -> None:
    assert of_wkt(text) == wanted


@pytest.mark.parametrize(
    ("keys", "doubles", "wanted"),
    [
        (DEGREES, (), CoordinateSystem(is_geographic=True)),
        (METRES, (), CoordinateSystem(metres=1.0)),
        ([*FEET, 4099, 0, 1, 9002], (), CoordinateSystem(metres=FOOT, metres_up=0.3048)),
        ([1, 1, 0, 2, 3076, 0, 1, 32767, 3077, 34736, 1, 1], (7.0, 0.9144), CoordinateSystem(metres=0.9144)),
        ([1, 1, 0, 2, 3076, 0, 1, 32767, 3077, 34736, 1, 9], (7.0,), CoordinateSystem()),
        (METRES[:12], (), CoordinateSystem(metres=1.0)),
        ([*METRES[:11], 2154], (), CoordinateSystem()),
        ([*METRES[:11], 3857, 3076, 0, 1, 9001], (), CoordinateSystem(metres=1.0, is_mercator=True)),
        ([*METRES[:11], 32767, 3075, 0, 1, 7, 3076, 0, 1, 9001], (), CoordinateSystem(metres=1.0, is_mercator=True)),
        ([*METRES[:11], 32767, 3075, 0, 1, 1, 3076, 0, 1, 9001], (), CoordinateSystem(metres=1.0)),
        (METRES[:11], (), CoordinateSystem()),
        ([], (), CoordinateSystem()),
    ],
)
def test_the_units_of_keys(keys: Sequence[int], doubles: Sequence[float], wanted: CoordinateSystem) -> None:
    assert of_keys(keys, doubles) == wanted


def geotiff(path: Path, keys: Sequence[int], x: float, y: float, place: Sequence[float] = (5e5, 4e6)) -> Path:
    tags: Any = ImageFileDirectory_v2()
    tags[33550], tags[33922], tags[34735] = (x, y, 0.0), (0.0, 0.0, 0.0, *place, 0.0), tuple(keys)
    tags.tagtype.update({33550: 12, 33922: 12, 34735: 3})
    Image.fromarray(HEIGHTS).save(path, tiffinfo=tags)
    return path


def esri(path: Path, size: str, system: str = "") -> Path:
    rows = "\n".join(" ".join(map(str, row)) for row in HEIGHTS.tolist())
    path.write_text(f"ncols 4\nnrows 3\nxllcorner -70.5\nyllcorner -33.4\n{size}\n{rows}")
    if system:
        path.with_suffix(".prj").write_text(system)
    return path


def test_cells_in_degrees_are_refused_with_the_zone_to_project_them_to(tmp_path: Path) -> None:
    north = geotiff(tmp_path / "north.tif", DEGREES, 1 / 3600, 1 / 3600, (9.5, 47.2))
    nowhere = geotiff(tmp_path / "nowhere.tif", DEGREES, 1, 1)
    south = esri(tmp_path / "south.asc", "cellsize 0.001", GEOGCS)
    for path, reading, code in (
        (north, Picture(values="m"), "EPSG:32632"),
        (nowhere, Picture(values="m"), "EPSG:CODE"),
        (south, Table(values="m"), "EPSG:32719"),
    ):
        with pytest.raises(FileError) as refused:
            heights_in(path, reading, 100)
        advice = f"its places are in degrees; write them in metres with `gdalwarp -t_srs {code} FILE NEW.tif`"
        assert str(refused.value) == f"{path}: {advice}"


WEB = [*METRES[:11], 3857, 3076, 0, 1, 9001]


def test_cells_in_mercators_projection_are_refused_where_they_are_larger_than_on_the_ground(tmp_path: Path) -> None:
    north = geotiff(tmp_path / "north.tif", WEB, 1, 1, (1e6, 8_399_737.9))  # 60 degrees
    grid = esri(tmp_path / "south.asc", "cellsize 1", MERCATOR)
    grid.write_text(
        grid.read_text().replace("corner -70.5", "corner -7.85e6").replace("corner -33.4", "corner -3.95e6")
    )
    for path, reading, larger, code in (
        (north, Picture(values="m"), "2", "EPSG:32632"),
        (grid, Table(values="m"), "1.198", "EPSG:32719"),
    ):
        with pytest.raises(FileError) as refused:
            heights_in(path, reading, 100)
        assert str(refused.value) == (
            f"{path}: its places are in Mercator's projection, {larger} times as far apart as on the ground; "
            f"write them in metres with `gdalwarp -t_srs {code} FILE NEW.tif`"
        )
    near_equator = geotiff(tmp_path / "local.tif", WEB, 1, 1, (0.0, 50.0))
    read = heights_in(near_equator, Picture(values="m", any_heights=True), 100)
    assert read.recipe_values["block_width_cm"] == 100


@pytest.mark.parametrize(
    ("options", "keys", "sides", "wanted"),
    [
        ({}, METRES, (0.25, 0.25), 25),
        ({}, FEET, (2, 2), 2 * FOOT * 100),
        ({"rotation": 90}, METRES, (2, 2), 200),
        ({"size": (2, 3), "cells_per_block": 1.5, "rotation": 10}, METRES, (2, 2), 300),
        ({"size": (2, 3)}, METRES, (1, 2), 200),
        ({"size": (3, 2), "rotation": 90}, METRES, (1, 2), 200),
        ({"size": (3, 2), "rotation": 90}, METRES, (2, 1), None),
        ({}, METRES, (2, 3), None),
        ({}, METRES, (5e6, 5e6), None),
        ({}, WITHOUT_UNIT, (2, 2), None),
    ],
)
def test_blocks_are_as_wide_as_the_cells_that_they_cover(
    tmp_path: Path, options: dict[str, Any], keys: Sequence[int], sides: tuple[float, float], wanted: float | None
) -> None:
    reading = Picture(values="m", datum_cm=10_000, any_heights=True, fill_holes=True, **options)
    heights = heights_in(geotiff(tmp_path / "a.tif", keys, *sides), reading, 100)
    assert heights.sides is not None
    assert heights.recipe_values.get("block_width_cm") == (wanted and pytest.approx(wanted))


def test_the_width_of_blocks_is_written_and_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    known = geotiff(tmp_path / "known.tif", METRES, 0.25, 0.25)
    unknown = esri(tmp_path / "unknown.asc", "cellsize 2")
    oblong = geotiff(tmp_path / "oblong.tif", METRES, 0.25, 0.5)
    beside = esri(tmp_path / "beside.asc", "dx 0.5\ndy 0.5", UTM)
    line = "blocks are {} cm wide, as the file says (--block-width-cm if they are not)"
    doubt = "warning: blocks are 10 cm wide, and in the file they are 2 x 2 in a unit that it does not say "
    for path, more, width, said in (
        (known, (), 25, line.format(25)),
        (beside, (), 50, line.format(50)),
        (unknown, (), 10, f"{doubt}(--block-width-cm)"),
        (oblong, (), 10, f"{doubt.partition('2 x 2')[0]}0.25 x 0.5 m (--block-width-cm)"),
        (unknown, ("--block-width-cm", "200"), 200, ""),
    ):
        flags = ("--values", "m", "--datum-cm", "10000", "--unit-cm", "100", *more)
        assert main(["import", str(path), *flags, "-o", str(tmp_path / "out"), "--force"]) == 0
        shown = capsys.readouterr()
        told = [text for text in (shown.out + shown.err).splitlines() if "wide" in text]
        assert told == [said] * bool(said)
        (recipe,) = (tmp_path / "out").glob(f"{path.stem}*/recipe.json")
        assert load(recipe).block_width_cm == width
