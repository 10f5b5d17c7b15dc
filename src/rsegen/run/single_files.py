"""Content of single files, and writing it: pages for browsers, build sheets, recipes, and the tiles of a terrain.

    Recipe, Scene or StepField --view--> View, shown in a notebook or saved as HTML
    Recipe --write_sheets--> PDF or CSV       Recipe --save--> YAML or JSON       Terrain --tiles_json--> JSON

All content is made before the first file is written, whole or not at all (`store`).
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from math import prod
from pathlib import Path

from rsegen.errors import FileError, TooLarge
from rsegen.exporters.browser.page import ShownMap, page
from rsegen.exporters.scene import Scene, compose
from rsegen.exporters.sheet import CutSettings, refuse_unbuildable, sheet, sheet_format
from rsegen.field.stepfield import StepField
from rsegen.io.recipe_file import to_yaml
from rsegen.io.resources import refuse_too_large
from rsegen.recipe.codec import to_json
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.terrain import Terrain
from rsegen.recipe.tiles import tile_shape
from rsegen.run.store import refuse_taken_file, write_file, write_files

MOST_CELLS = 1_500_000
"""Cells of a map on a page at most, as of 1000 x 1000 blocks with frames: its faces need 0.3 GB in a browser."""

MOST_CELLS_TOGETHER = 5_000_000
"""Cells of all maps on a page at most: 7 to 14 MB of HTML."""

MOST_MAPS = 1000
"""Maps on a page at most: they are chosen from a list."""

_LONG = 100_000
"""Letters of JSON from which on a page shows a recipe as JSON: as YAML it would take PyYAML a second and more."""


@dataclass(frozen=True, kw_only=True, slots=True)
class View:
    """A page that shows maps: in a notebook as it is, or saved as an HTML file."""

    html: bytes

    def save(self, path: str | Path, *, force: bool = False) -> Path:
        """Write the HTML file, whole or not at all; an OutputError if it exists already, unless `force`."""
        path = html_path(path)
        write_file([self.html], path, force=force)
        return path

    def _repr_html_(self) -> str:
        """Return the page in a frame of its own, which notebooks show; its scripts cannot reach the notebook."""
        frame = 'width="100%" height="760" style="border: 0" sandbox="allow-scripts allow-downloads"'
        return f'<iframe {frame} allow="clipboard-write" srcdoc="{escape(self.html.decode())}"></iframe>'


def view(shown: Recipe | Scene | StepField, index: int | None = None) -> View:
    """A page that shows a map in three dimensions and as a plan: `rsegen.view(recipe).save("map.html")`.

    shown: a field, a scene, or a recipe, of which all maps are on the page, or map `index` alone. TooLarge if they are
    more than a browser shows.
    """
    match shown:
        case StepField():
            _refuse_unshowable(shown.shape)
            return View(html=page([ShownMap.of_field(shown)]))
        case Scene():
            _refuse_unshowable(shown.field.shape)
            return View(html=page([_shown(shown)]))
    return view_all([shown if index is None else shown.alone(index)])


def view_all(recipes: Sequence[Recipe]) -> View:
    """Return the page of all maps of some recipes, which are checked before the first map is made."""
    maps = sum(recipe.maps for recipe in recipes)
    if maps > MOST_MAPS:
        raise TooLarge(f"{maps:,} maps are more than the {MOST_MAPS} of a page; select one by its index")
    cells = 0
    for recipe in recipes:
        _refuse_unshowable(tile_shape(recipe))
        refuse_too_large(recipe, "measure")
        cells += recipe.maps * prod(tile_shape(recipe))
    if cells > MOST_CELLS_TOGETHER:
        most = f"the {MOST_CELLS_TOGETHER:,} of a page"
        raise TooLarge(f"{maps} maps have {cells:,} cells, more than {most}; select one by its index")
    return View(html=page([_shown(compose(recipe, index)) for recipe in recipes for index in recipe.indices]))


def _refuse_unshowable(shape: tuple[int, int]) -> None:
    """Raise a TooLarge for a map of these cells along x and y if a browser would not show it."""
    n_x, n_y = shape
    if n_x * n_y > MOST_CELLS:
        raise TooLarge(f"{n_x} x {n_y} cells are more than the {MOST_CELLS:,} of a map that browsers show")


def html_path(path: str | Path) -> Path:
    """Return the path of a page; a FileError if it is not called .html or .htm."""
    path = Path(path)
    if path.suffix.lower() not in (".html", ".htm"):
        raise FileError(f"{path}: not a page's name; end it in .html")
    return path


def _shown(scene: Scene) -> ShownMap:
    text = to_json(scene.alone)
    if len(text) > _LONG:
        return ShownMap.of(scene, text, ".json")
    return ShownMap.of(scene, to_yaml(scene.alone), ".yaml")


def write_sheets(
    recipe: Recipe, index: int, paths: Iterable[Path], saw: CutSettings | None = None, *, force: bool = False
) -> Scene:
    """Write the build sheet of one map into files, each in the format that its name asks for; gives the map.

    All are made before the first is written. Raises an OutputError if a file exists already, unless `force`; TooLarge
    or a ParameterError if the map cannot have a sheet.
    """
    # Everything that may be wrong is checked first, as a map and its sheet take their time.
    saw = saw or CutSettings.default(recipe.units)
    formats = {path: sheet_format(path) for path in paths}
    for path in formats:
        refuse_taken_file(path, force=force)
    refuse_too_large(recipe)
    refuse_unbuildable(recipe, saw)
    scene = compose(recipe, index)
    write_files({path: [sheet(scene, saw, format_)] for path, format_ in formats.items()}, force=force)
    return scene


def save(recipe: Recipe, path: str | Path, *, force: bool = False) -> None:
    """Write a recipe file, whole or not at all; an OutputError if it exists already, unless `force`."""
    path = Path(path)
    text = to_json(recipe) if path.suffix.lower() == ".json" else to_yaml(recipe)
    write_file([text.encode()], path, force=force)


def copy_examples(folder: Path, *, force: bool = False) -> Sequence[Path]:
    """Write the included recipes into a folder, all or none of them; return their paths."""
    copies = {folder / path.name: [path.read_bytes()] for path in EXAMPLES.values()}
    write_files(copies, force=force)
    return list(copies)


def tiles_json(terrain: Terrain, robot_size: tuple[float, float] | None = None) -> bytes:
    """Return the content of NAME_0000.json: difficulty, kind, map and origin of each tile; metres, radians.

    robot_size: length and width of a robot, for which each tile gets a spot to start at
    """
    spots = {} if robot_size is None else {"spots": terrain.spots(robot_size, evenest=True)[:, :, 0].tolist()}
    tiles = {
        "name": terrain.name,
        "tile_size": list(terrain.tile_size),
        "difficulty": terrain.difficulties.tolist(),
        "kinds": list(terrain.kinds),
        "maps": terrain.maps.tolist(),
        "origins": terrain.origins.tolist(),
        **spots,
    }
    return json.dumps(tiles).encode() + b"\n"
