"""The meshes of a step field by their names: `merged`, `watertight`, `blocks`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from rsegen.errors import UnknownName, refuse_other
from rsegen.field.stepfield import CellWindow, StepField
from rsegen.geometry.exposed_faces import surface, unmerged
from rsegen.geometry.mesh import Mesh, split_window
from rsegen.geometry.watertight_mesh import watertight

PIECE = 512
"""Side of the pieces, in cells, that large maps are split into, so that memory does not grow with the map (decision 7);
smaller ones would have more seams."""

MESHES: Mapping[str, Callable[[StepField], Mesh]] = {"merged": surface, "watertight": watertight, "blocks": unmerged}
"""Function that makes each mesh, by the name that a recipe's `mesh` gives it."""


def meshes(field: StepField, mesh: str, window: CellWindow | None = None) -> Iterator[Mesh]:
    """Yield the meshes of a field or a window by a recipe's `mesh`: of large fields in pieces, unless watertight."""
    if mesh == "watertight":
        yield watertight(field)
        return
    piece = {"merged": surface, "blocks": unmerged}[mesh]
    for part in split_window(window or field.whole, PIECE):
        yield piece(field, part)


def mesh(field: StepField, kind: str = "merged") -> Mesh:
    """Return a field as one mesh.

    Parameters
    ----------
    field : StepField
        The blocks and frames.
    kind : {'merged', 'watertight', 'blocks'}, default 'merged'
        `merged` is the visible surface in few faces; `watertight` is closed, in few triangles; `blocks` has six faces
        for each block.

    Returns
    -------
    Mesh
        The mesh, metres, centred on x = y = 0.

    Raises
    ------
    UnknownName
        If there is no such kind.
    """
    refuse_other("field", field, StepField)
    if kind not in MESHES:
        raise UnknownName.among("mesh", "mesh", kind, MESHES)
    return MESHES[kind](field)
