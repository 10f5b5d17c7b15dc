"""A page that shows maps, as one HTML file: `rsegen.view(recipe).save("map.html")`.

Recipe, Scene or StepField --view--> View, shown in a notebook or saved as HTML
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from math import prod
from pathlib import Path

from rsegen.errors import FileError, TooLarge, refuse_other
from rsegen.field.stepfield import StepField
from rsegen.page.shown_map import ShownMap, page
from rsegen.recipe.codec import to_json
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import to_yaml
from rsegen.scene.scene import Scene, compose
from rsegen.writing.resources import refuse_too_large
from rsegen.writing.store import write_file

MOST_CELLS = 1_500_000
"""Cells of a map on a page at most, as of 1000 x 1000 blocks with frames: its faces need 0.3 GB in a browser."""

MOST_CELLS_TOGETHER = 5_000_000
"""Cells of all maps on a page at most: 7 to 14 MB of HTML."""

MOST_MAPS = 1000
"""Maps on a page at most: they are chosen from a list."""

_LONG = 100_000
"""Letters of JSON from which on a page shows a recipe as JSON: PyYAML would take a second and more for it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class View:
    """A page that shows maps: in a notebook as it is, or saved as an HTML file.

    Attributes
    ----------
    html : bytes
        The page.
    """

    html: bytes = field(repr=False)

    def save(self, path: str | Path, *, force: bool = False) -> Path:
        """Write the HTML file, whole or not at all; an OutputError if it exists already, unless `force`."""
        path = html_path(path)
        write_file([self.html], path, force=force)
        return path

    def _repr_html_(self) -> str:
        """Return the page in its own frame, which notebooks show; its scripts cannot reach the notebook."""
        frame = 'width="100%" height="760" style="border: 0" sandbox="allow-scripts allow-downloads"'
        return f'<iframe {frame} allow="clipboard-write" srcdoc="{escape(self.html.decode())}"></iframe>'


def view(shown: Recipe | Scene | StepField, index: int | None = None) -> View:
    """Return a page that shows a map in three dimensions and as a plan: `rsegen.view(recipe).save("map.html")`.

    Parameters
    ----------
    shown : Recipe, Scene or StepField
        What is shown: a field, a scene, or the maps of a recipe.
    index : int, optional
        Which map of a recipe; by default all are on the page.

    Returns
    -------
    View
        The page.

    Raises
    ------
    TooLarge
        If the maps are more than a browser shows.
    """
    refuse_other("shown", shown, Recipe, Scene, StepField)
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
        raise TooLarge(f"{maps:,} maps are too many for a page, which holds up to {MOST_MAPS}; choose one by its index")
    cells = 0
    for recipe in recipes:
        _refuse_unshowable(recipe.cells)
        refuse_too_large(recipe, "measure")
        cells += recipe.maps * prod(recipe.cells)
    if cells > MOST_CELLS_TOGETHER:
        most = f"a page holds up to {MOST_CELLS_TOGETHER:,}"
        raise TooLarge(f"{maps} maps have {cells:,} cells, and {most}; choose one by its index")
    return View(html=page([_shown(compose(recipe, index)) for recipe in recipes for index in recipe.indices]))


def _refuse_unshowable(shape: tuple[int, int]) -> None:
    """Raise a TooLarge for a map of these cells along x and y if a browser would not show it."""
    n_x, n_y = shape
    if n_x * n_y > MOST_CELLS:
        raise TooLarge(f"{n_x} x {n_y} cells are too many to show in a browser, where a map has up to {MOST_CELLS:,}")


def html_path(path: str | Path) -> Path:
    """Return the path of a page; a FileError if it is not called .html or .htm."""
    path = Path(path)
    if path.suffix.lower() not in (".html", ".htm"):
        raise FileError(f"{path}: a page must be an .html file")
    return path


def _shown(scene: Scene) -> ShownMap:
    text = to_json(scene.alone, derived_keys=False)
    if len(text) > _LONG:
        return ShownMap.of(scene, text, ".json")
    return ShownMap.of(scene, to_yaml(scene.alone), ".yaml")
