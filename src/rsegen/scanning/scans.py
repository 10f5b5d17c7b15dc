"""Scans of real fields: `rsegen.scan` gives the map that was built, `rsegen.compare` what is built wrong.

clouds --read_clouds--> points --find_field--> Scan --> Recipe of one matrix, or a Comparison with a map
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

import numpy as np

from rsegen.errors import FileError, ScanError, refuse_other
from rsegen.field.stepfield import Array, StepField
from rsegen.heights.base import Heights, filled, recipe_of_heights
from rsegen.params.sorts import FilePath
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe
from rsegen.scanning.clouds import read_clouds
from rsegen.scanning.comparison import Comparison, compared
from rsegen.scanning.evidence import rows_may_follow
from rsegen.scanning.finding import find_field
from rsegen.scanning.grid import without_sides
from rsegen.scanning.ground import usable
from rsegen.scanning.meshes import Cloud
from rsegen.scanning.pictures import comparison_plot, scan_plot
from rsegen.scanning.scan import Scan, ScanSettings
from rsegen.scanning.scan_options import ScanOptions
from rsegen.scanning.surroundings import (
    find_field_apart,
    is_doubtful,
    may_be_field,
    may_be_part,
    with_beside,
    without_others,
)

Clouds: TypeAlias = "str | Path | Sequence[str | Path] | Array"
"""Files of one scan, or points (n, 3) [m]."""

_AS_WIDE = 0.03
"""Share by which blocks of one width may differ as they are measured."""

_FEW_SIDES = 0.05
"""Share of the points that are of sides up to which looking at the others alone is in vain."""

_MOST_UNSEEN = 0.5
"""Share of blocks that may be filled by their neighbours: with more, the map would be made up rather than scanned."""


@dataclass(frozen=True, kw_only=True)
class ScannedMap:
    """The result of `scan`: a field that was found in a cloud.

    Attributes
    ----------
    scan : Scan
        Its levels with their confidence, and its pose in the cloud.
    recipe : Recipe
        The field as a recipe of one map.
    points : ndarray, shape (n, 3)
        The points that it was read from, metres, in the frame of the clouds.
    left_out : int
        Number of other points: of things that stand apart from the field.
    clearer_up : str or None
        The axis from which more of a mesh, or of its heights, is seen than from the one that was given as up.
    doubt : str
        Why the intrinsics are perhaps those of another image; empty if nothing speaks against them.
    """

    scan: Scan
    recipe: Recipe
    points: Array
    left_out: int = 0
    clearer_up: str | None = None
    doubt: str = ""

    @cached_property
    def field(self) -> StepField:
        """The field that the recipe makes."""
        return build(self.recipe, self.recipe.first_map)

    def picture(self, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
        """Return the points from above with the grid that was found, and how far each top is from its level."""
        return scan_plot(self.scan, self.points, format, self.recipe.units)

    def _repr_png_(self) -> bytes:
        return self.picture()


@dataclass(frozen=True, kw_only=True)
class ComparedMap:
    """The result of `compare`: the differences between a map and a built field.

    Attributes
    ----------
    comparison : Comparison
        The two fields, cell by cell.
    scan : Scan or None
        The field as it was found, if a cloud was compared.
    units : {'cm', 'in'}
        Lengths in the picture, as in recipes: those of the map.
    doubt : str
        Why the intrinsics are perhaps those of another image; empty if nothing speaks against them.
    """

    comparison: Comparison
    scan: Scan | None = None
    units: str = "cm"
    doubt: str = ""

    def picture(self, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
        """Return the plan with every block that is wrong, for mending the real field."""
        return comparison_plot(self.comparison, format, self.units)

    def _repr_png_(self) -> bytes:
        return self.picture()


def scan(clouds: Clouds, options: ScanOptions | None = None) -> ScannedMap:
    """Find the step field in a point cloud, and return it as a recipe too: `rsegen.scan("pallet.ply").recipe`.

    Parameters
    ----------
    clouds : path, sequence of paths, or ndarray of shape (n, 3)
        Files in one common frame (XYZ, CSV, PLY, PCD, meshes, arrays, depth images), or points in metres.
    options : ScanOptions, optional
        How the clouds are read, and what is known of the field.

    Returns
    -------
    ScannedMap
        The field, its recipe and the points.

    Raises
    ------
    FileError
        If a file cannot be read.
    ScanError
        If there is no field in the cloud.
    """
    options = options or ScanOptions()
    cloud, settings, name = _cloud(clouds, options)
    field, points = _found(cloud, settings)
    return ScannedMap(
        scan=field,
        recipe=_recipe(field, name, fill_holes=options.fill_holes),
        points=points,
        left_out=len(cloud.points) - len(points),
        clearer_up=None if cloud.clearer is None else _axis(cloud.clearer),
        doubt=cloud.doubt,
    )


def compare(
    stands: Recipe | StepField | Clouds, wanted: Recipe | StepField, options: ScanOptions | None = None
) -> ComparedMap:
    """Compare a real field, or a map, with a map: `rsegen.compare("pallet.ply", recipe).comparison.wrong`.

    A scan is turned and moved to where the map fits best, and has the map's block width and unit.

    Parameters
    ----------
    stands : Recipe, StepField, or clouds
        A recipe (its first map), a field, or clouds as for `scan`.
    wanted : Recipe or StepField
        A recipe (its first map), or a field.
    options : ScanOptions, optional
        As for `scan`.

    Returns
    -------
    ComparedMap
        The differences.

    Raises
    ------
    ParameterError
        If two maps have different cells.
    ScanError
        If a scan shows another map.
    """
    field = _field(wanted)
    units = wanted.units if isinstance(wanted, Recipe) else "cm"
    if isinstance(stands, (Recipe, StepField)):
        return ComparedMap(comparison=compared(_field(stands), field), units=units)
    options = options or ScanOptions()
    cloud, settings, _ = _cloud(stands, options)
    built, _ = _found(cloud, settings, field)
    stretch = built.unit / built.measured_unit  # heights in the map's unit, as blocks may all be a little lower
    comparison = Comparison(heights=built.heights * stretch, wanted=field, tolerance=field.unit / 2)
    return ComparedMap(comparison=comparison, scan=built, units=units, doubt=cloud.doubt)


def _field(shown: Recipe | StepField) -> StepField:
    refuse_other("wanted", shown, Recipe, StepField)
    return build(shown, shown.first_map) if isinstance(shown, Recipe) else shown


def _cloud(clouds: Clouds, options: ScanOptions) -> tuple[Cloud, ScanSettings, str]:
    """Return the points [m], what is known of the field in them, and a name for what they show."""
    settings = options.settings
    if isinstance(clouds, np.ndarray):
        return Cloud(clouds), settings, "scan"
    given = clouds if isinstance(clouds, (list, tuple)) else [clouds]
    paths = [FilePath("a file with points").check("clouds", path) for path in given]
    if not paths:
        raise FileError("no cloud is given")
    cloud = read_clouds(paths, options.values, options.intrinsics, settings.up, options.topic)
    return cloud, settings if cloud.up is None else replace(settings, up=_vector(cloud.up)), paths[0].stem


def _found(cloud: Cloud, settings: ScanSettings, known: StepField | None = None) -> tuple[Scan, Array]:
    """Return the field in a cloud, and the points that it was read from: all, or those of one of the things in it."""
    # The cloud as a whole first. If that shows no field for sure, the things in it, and of both what is the field.
    whole, apart, refused = None, None, ScanError("")
    try:
        whole = with_beside(_in_all(cloud, settings, known), cloud.points, settings, known)
    except ScanError as error:
        refused = error
    if not whole or is_doubtful(whole, settings, known):
        apart = find_field_apart(cloud.points, settings, known)
    if apart:
        apart = with_beside(apart[0], cloud.points, settings, known), apart[1]
    if whole and (not apart or _is_of_whole(apart[0], whole)):
        apart = whole, cloud.points
    if not apart:
        whole = with_beside(_without_sides(cloud, settings, known, refused), cloud.points, settings, known)
        apart = whole, cloud.points
    # Then it is read once more without what stands beside it, and refused if it may be a part, or may go on.
    scan, points = without_others(*apart, settings, known)
    if not whole:
        _refuse_part(scan)
    if settings.blocks is None and not known:
        _refuse_unended(scan, cloud)
    found = replace(
        scan,
        is_up_assumed=scan.is_up_assumed or cloud.is_up_assumed,
        whole=scan.whole if cloud.has_floor else None,  # else that of the ground that was added
    )
    return found, points


def _is_of_whole(scan: Scan, whole: Scan) -> bool:
    """Return whether one of the things in a cloud is a part of the field in all of it: parts of few obstacles have its
    blocks, or others next to them; of a room that looks like blocks they have others.
    """
    return may_be_part(scan) or abs(scan.measured_width / whole.measured_width - 1) < _AS_WIDE


def _in_all(cloud: Cloud, settings: ScanSettings, known: StepField | None) -> Scan:
    """Return the field in a cloud; of a surface in which none is found, as its faces look up."""
    try:
        return find_field(cloud.points, settings, known)
    except ScanError:
        if cloud.facing is None:
            raise
        with suppress(ScanError):
            return find_field(cloud.points, replace(settings, up=_vector(cloud.facing)), known)
        raise


def _without_sides(cloud: Cloud, settings: ScanSettings, known: StepField | None, refused: ScanError) -> Scan:
    """Return the field in a cloud without points of sides; else raise what the search in all of it was refused with.

    That it is another map than the known one says more. Without sides other things look like blocks too, so what is
    found has to show blocks: a carton does not if somebody says how wide they are.
    """
    try:
        near, middle = usable(cloud.points)
        others = without_sides(near, settings.up, settings.eye_from(middle))
        if len(others) < (1 - _FEW_SIDES) * len(near):
            scan = find_field(others + middle, settings, known)
            if may_be_field(scan, settings, known):
                return scan
    except ScanError as error:
        refused = error if known else refused
    raise ScanError(f"{refused}; {cloud.doubt}") if cloud.doubt else refused


def _refuse_unended(scan: Scan, cloud: Cloud) -> None:
    """Raise a ScanError if nothing shows where a field ends, as blocks at level 0 may be next to what is raised."""
    n_x, n_y = scan.blocks.shape
    if not cloud.has_floor:
        if why := _may_go_on(scan):
            raise ScanError(
                f"{n_x} x {n_y} blocks are raised, and more at level 0 may be next to them, which a mesh without a "
                f"floor does not have: {why}; set size, to {n_x}x{n_y} if there are no more"
            )
    elif scan.whole and not scan.has_floor:
        raise ScanError(
            f"the lowest row around {n_x} x {n_y} blocks, with which the cloud ends, may be floor, blocks or a frame; "
            f"set size, to {n_x}x{n_y} if it is floor"
        )


def _refuse_part(scan: Scan) -> None:
    """Raise a ScanError if one of the things in a cloud may be a part of the field only."""
    if may_be_part(scan):
        n_x, n_y = scan.blocks.shape
        raise ScanError(
            f"{n_x} x {n_y} blocks may be a part of the field: {scan.beside} cells near them are as high as blocks; "
            "set size, or cut everything but the field and its floor out of the cloud"
        )


def _may_go_on(scan: Scan) -> str:
    """Return why blocks at level 0 may be next to those that are raised; nothing if that is unlikely."""
    return f"{scan.apart} of the raised stand apart" if scan.apart else rows_may_follow(scan)


def _vector(direction: Array) -> tuple[float, float, float]:
    x, y, z = direction.tolist()
    return x, y, z


def _axis(direction: Array) -> str:
    """Return the axis that is nearest to a direction, as options have it."""
    at = int(np.abs(direction).argmax())
    return f"{'-' if direction[at] < 0 else ''}{'xyz'[at]}"


def _recipe(scan: Scan, name: str, *, fill_holes: bool) -> Recipe:
    """Return the field as a recipe of one matrix, and of another one for blocks that were not seen but filled."""
    levels = scan.blocks
    holes = levels < 0
    fill_holes = fill_holes and 0 < holes.mean() <= _MOST_UNSEEN
    if fill_holes:
        levels = np.rint(filled(np.maximum(levels, 0).astype(float), holes)).astype(np.int64)
    heights = Heights(
        levels=levels,
        unit_cm=round(scan.unit * 100, 6),
        recipe_values={
            "boundary": scan.boundary,
            "block_width_cm": round(scan.block_width * 100, 6),
            **({"frame_height_cm": round(scan.frame_height * 100, 6)} if scan.boundary != "none" else {}),
        },
        holes=holes if fill_holes else None,
    )
    recipe = recipe_of_heights(Path(name), heights, scan.chunk_size)
    return replace(recipe, description=f"scan of {name}"[:500])
