"""Read from a file of ground how wide its cells are: the units of its coordinate reference system.

A GeoTIFF and a laser scan (LAS) name the system by the same keys (OGC 19-008, GeoTIFF 1.1) or by a text in WKT, of both
versions (OGC 01-009, ISO 19162); Esri's files have the text next to them, in NAME.prj. Only what blocks need is read:
whether places are longitudes and latitudes, or in Mercator's projection, which maps on the web have and which makes the
ground 1 / cos(latitude) times as large (Snyder 1987); and the lengths of the units of x and y, and of heights. It
projects nothing.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import atan, cos, degrees, isfinite, radians, sinh
from pathlib import Path
from typing import NamedTuple

from rsegen.errors import FileError
from rsegen.input_files import regular_content
from rsegen.params.sorts import CENTIMETRES

IN_METRES = "gdalwarp -t_srs {} FILE NEW.tif"
"""The command that projects a map of ground."""

_MOST_BYTES = 2**16
"""Bytes of a text in WKT that are read at most; a system has some thousand."""

_MODEL_TYPE, _SYSTEM, _UNIT, _UNIT_SIZE, _UNIT_UP = 1024, 3072, 3076, 3077, 4099
"""Keys of GeoTIFF: type and code of the system, code and size of its unit, and the code of the unit of heights."""

_ZONES = (*range(32601, 32661), *range(32701, 32761), *range(25828, 25839))
"""Codes of EPSG of the zones of UTM, of WGS 84 and of ETRS89: in metres, which MATLAB takes to be known."""

_MERCATORS, _PROJECTION, _MERCATOR = (3857, 3395, 3785, 41001, 54004), 3075, 7
"""Codes of systems in Mercator's projection (EPSG, and older ones); the key of GeoTIFF for a projection, and its value.

Systems of UTM are in the transverse projection, and true to scale.
"""

_MERCATOR_IN_WKT = re.compile(
    r'\b(PROJECTION|METHOD)\s*[\[(]\s*"(?![^"]*(transverse|oblique))[^"]*mercator', re.IGNORECASE
)
"""Mercator's projection in WKT."""

_RADIUS, _AS_LARGE = 6_378_137.0, 1.001
"""The radius of the Earth in Mercator's projection, metres, and the enlargement up to which it does not count."""

_GEOGRAPHIC, _DOUBLES = 2, 34736
"""The type of a system of longitudes and latitudes, and the tag with the values of keys that are no integers."""

_METRE = 9001
_OTHER_NAMES: Mapping[str, Sequence[int | str]] = {
    "m": (_METRE, "metre", "meter", "metres", "meters"),
    "ft": (9002, "foot", "feet"),
    "cm": ("centimetre",),
    "mm": ("millimetre",),
}
METRES: Mapping[int | str, float] = {
    **{name: CENTIMETRES[unit] / 100 for unit, others in _OTHER_NAMES.items() for name in (unit, *others)},
    **dict.fromkeys((9003, "us survey foot", "us-ft", "ftus"), 1200 / 3937),
}
"""Metres of units by their codes of EPSG, and by their names in GDAL's metadata and in Esri's files."""

_PLANE = {"PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"}
_OF_DEGREES = {"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"}
_OF_EITHER = {"GEODCRS", "GEODETICCRS"}
_UPWARDS = {"VERT_CS", "VERTCRS", "VERTICALCRS"}
_LENGTHS = {"UNIT", "LENGTHUNIT"}
"""Words of WKT: systems with places on a plane, with longitudes and latitudes, with either; with heights; and units."""

_TOKEN = re.compile(r'([A-Za-z]\w*)\s*[\[(]|"([^"]*)"|([\])])|([^\s,\[\]()"]+)')
"""A word that opens a bracket, a text, the end of a bracket, or a number or another word."""

_ROUNDED = 1e-3
"""Share by which the sides of square cells may differ: some programs round them."""

_DEEPEST = 30
"""Brackets in each other at most; a system has some ten."""


class CoordinateSystem(NamedTuple):
    """The units of places and heights: whether places are in degrees, and metres of the units, None if not known.

    is_mercator: whether places are in Mercator's projection
    """

    is_geographic: bool = False
    metres: float | None = None
    metres_up: float | None = None
    is_mercator: bool = False


class CellSides(NamedTuple):
    """Sides of cells along x and y, and metres of the unit that they are in, None if the file does not say it."""

    x: float
    y: float
    metres: float | None

    @property
    def is_square(self) -> bool:
        """Return whether both sides are equally long, up to a rounding in the file."""
        return abs(self.x - self.y) <= _ROUNDED * max(self.x, self.y)

    def of_blocks(self, cells_x: float, cells_y: float) -> CellSides:
        """Return the sides of blocks of some cells along x and y."""
        return self._replace(x=self.x * cells_x, y=self.y * cells_y)


def of_keys(keys: Sequence[int], doubles: Sequence[float] = ()) -> CoordinateSystem:
    """Return the system that the keys of a GeoTIFF or of a laser scan name: four numbers for each, after a header."""
    # A key is (key, tag, count, value): without a tag the value itself, else its index in the numbers of that tag.
    values: dict[int, float] = {}
    for key, tag, _, value in zip(*(keys[4 + at :: 4] for at in range(4)), strict=False):
        if tag == 0:
            values[key] = value
        elif tag == _DOUBLES and value < len(doubles):
            values[key] = doubles[value]
    is_geographic = values.get(_MODEL_TYPE) == _GEOGRAPHIC
    size = _length(values.get(_UNIT_SIZE))
    unit = values.get(_UNIT, _METRE if values.get(_SYSTEM) in _ZONES else 0)
    metres = None if is_geographic else METRES.get(int(unit), size)
    is_mercator = values.get(_SYSTEM) in _MERCATORS or values.get(_PROJECTION) == _MERCATOR
    return CoordinateSystem(is_geographic, metres, METRES.get(int(values.get(_UNIT_UP, 0))), is_mercator)


def of_wkt(text: str) -> CoordinateSystem:
    """Return the system that a text in WKT defines; in Esri's older form, lines of names and values, too."""
    if line := re.search(r"^\s*units\s+(\w+)", text[:_MOST_BYTES], re.IGNORECASE | re.MULTILINE):
        unit = line[1].lower()
        return CoordinateSystem(unit in ("dd", "ds"), METRES.get(unit))
    # `opened` are the brackets around a token, so a unit of length counts for the innermost system that it is in; an
    # axis may have its own. Places and heights may each have one: lengths[False] and lengths[True].
    opened, seen, words, lengths = list[str](), set[str](), set[str](), dict[bool, float]()
    for keyword, _, end, word in _TOKEN.findall(text[:_MOST_BYTES]):
        if keyword and len(opened) >= _DEEPEST:
            break
        if keyword:
            opened.append(keyword.upper())
            seen.add(keyword.upper())
        elif end:
            del opened[-1:]
        elif word:
            words.add(word.lower())
            *outer, innermost = opened or [""]
            system = next((name for name in reversed(outer) if name != "AXIS"), "")
            length = _length(word) if innermost in _LENGTHS and system in _PLANE | _UPWARDS else None
            if length is not None:
                lengths.setdefault(system in _UPWARDS, length)
    is_geographic = not seen & _PLANE and bool(seen & _OF_DEGREES or (seen & _OF_EITHER and "ellipsoidal" in words))
    is_mercator = bool(_MERCATOR_IN_WKT.search(text[:_MOST_BYTES]))
    return CoordinateSystem(is_geographic, lengths.get(False), lengths.get(True), is_mercator)


def beside(path: Path) -> CoordinateSystem:
    """Return the system in NAME.prj next to a file of Esri; without that file one of which nothing is known."""
    content = regular_content(path.with_suffix(".prj"), _MOST_BYTES) or b""
    return of_wkt(content.decode("utf-8", "replace"))


def refuse_distorted(path: Path, system: CoordinateSystem, place: tuple[float, float], command: str) -> None:
    """Raise a FileError for a file whose places are no metres of the ground: they are degrees, or as Mercator's.

    place: x and y of any of them; command: what projects it, with `{}` for its system.
    """
    if system.is_geographic:
        longitude, latitude, problem = *place, "are in degrees"
    else:
        # The inverse of Mercator's projection; sinh of 9 is at the pole but for 0.02 degrees, and cannot overflow.
        x, y = (along * (system.metres or 1) / _RADIUS for along in place)
        longitude, latitude, problem = degrees(x), degrees(atan(sinh(max(min(y, 9.0), -9.0)))), ""
        if system.is_mercator and (larger := 1 / cos(radians(latitude))) > _AS_LARGE:
            problem = f"are in Mercator's projection, {larger:.4g} times as far apart as on the ground"
    if problem:
        advice = command.format(f"EPSG:{_utm(longitude, latitude)}")
        raise FileError(f"{path}: its places {problem}; write them in metres with `{advice}`")


def _utm(longitude: float, latitude: float) -> str:
    """Return the code of the zone of UTM in which a place is (EPSG)."""
    if not (-180 <= longitude <= 180 and -90 <= latitude <= 90):
        return "CODE"
    zone = min(int((longitude + 180) // 6) + 1, 60)
    return f"32{7 if latitude < 0 else 6}{zone:02}"


def _length(value: float | str | None) -> float | None:
    try:
        length = float(value or 0)
    except ValueError:
        return None
    return length if isfinite(length) and length > 0 else None
