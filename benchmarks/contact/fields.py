"""Geometries of which the shapes of a field can be made: boxes, meshes, a height map."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from benchmarks.contact import partitions
from benchmarks.contact.partitions import Patch
from benchmarks.contact.shapes import Box, Heights, Shape, Triangles
from rsegen import StepField
from rsegen.field.stepfield import Array
from rsegen.geometry import surface, watertight

Shapes = Callable[[StepField], Iterable[Shape]]
Partition = Callable[[Array], Iterable[Patch]]


def boxes(partition: Partition) -> Shapes:
    """A box from the ground for each patch."""

    def shapes(field: StepField) -> Iterator[Shape]:
        x, y = (line.tolist() for line in field.edges())
        for i0, i1, j0, j1, height in partition(field.heights):
            centre = ((x[i0] + x[i1]) / 2, (y[j0] + y[j1]) / 2, height / 2)
            yield Box(centre=centre, size=(x[i1] - x[i0], y[j1] - y[j0], height))

    return shapes


def mesh(partition: Partition) -> Shapes:
    """One mesh of the patches as tops and the shipped surface's walls."""
    return lambda field: [Triangles(corners=np.concatenate([tops(field, partition), walls(field)]))]


def shipped(field: StepField) -> Iterator[Shape]:
    """One mesh of the shipped surface."""
    made = surface(field)
    yield Triangles(corners=made.vertices[made.triangles])


def block_mesh(field: StepField) -> Iterator[Shape]:
    """One mesh with all six faces of every block."""
    faces = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    x, y = (line.tolist() for line in field.edges())
    blocks = []
    for i0, i1, j0, j1, height in partitions.cells(field.heights):
        ring = [(x[i0], y[j0]), (x[i1], y[j0]), (x[i1], y[j1]), (x[i0], y[j1])]
        blocks.append([(a, b, c) for c in (0.0, height) for a, b in ring])
    yield Triangles(corners=_halved(np.array(blocks)[:, faces].reshape(-1, 4, 3)))


def closed(field: StepField) -> Iterator[Shape]:
    """One mesh of the watertight surface: no T-junctions."""
    made = watertight(field)
    yield Triangles(corners=made.vertices[made.triangles])


def height_map(samples: int) -> Shapes:
    """Floors as a height map with so many samples a cell, each the lowest of the cells it touches; walls as a mesh."""

    def shapes(field: StepField) -> Iterator[Shape]:
        yield Heights(samples=_sampled(field, samples), side=_side(field, samples), height=field.unit * 255 / _STEP)
        yield Triangles(corners=np.concatenate([walls(field), _rims(field, field.block_width / samples)]))

    return shapes


def tops(field: StepField, partition: Partition) -> Array:
    """Two triangles for each patch."""
    x, y = field.edges()
    i0, i1, j0, j1, height = (np.array(column) for column in zip(*partition(field.heights), strict=True))
    ring = ((i0, j0), (i1, j0), (i1, j1), (i0, j1))
    return _halved(np.stack([np.stack([x[i], y[j], height], axis=1) for i, j in ring], axis=1))


def walls(field: StepField) -> Array:
    """The shipped surface without its tops."""
    made = surface(field)
    return _halved(made.vertices[made.faces[made.normals != 4]])


_STEP = 16
"""Grey of a level in a height map."""


def _side(field: StepField, samples: int) -> float:
    return (len(_sampled(field, samples)) - 1) * field.block_width / samples


def _sampled(field: StepField, samples: int) -> np.ndarray[tuple[int, int], np.dtype[np.uint8]]:
    """In the middle of a larger square of ground."""
    levels = np.pad(field.levels, 1)
    fine = np.repeat(np.repeat(levels, samples, axis=0), samples, axis=1)
    corners = np.minimum.reduce([fine[:-1, :-1], fine[1:, :-1], fine[:-1, 1:], fine[1:, 1:]])[
        samples - 1 :, samples - 1 :
    ]
    corners = corners[: field.shape[0] * samples + 1, : field.shape[1] * samples + 1]
    side = 2 ** int(np.ceil(np.log2(max(corners.shape) - 1))) + 1
    whole = np.zeros((side, side), dtype=np.uint8)
    i, j = ((side - length) // 2 for length in corners.shape)
    whole[i : i + corners.shape[0], j : j + corners.shape[1]] = corners * _STEP
    return whole


def _rims(field: StepField, width: float) -> Array:
    """Strips along the ledges of tops, on the higher side."""
    made = surface(field)
    sides = made.normals != 4
    rings, outward = made.vertices[made.faces[sides]], _OUTWARD[made.normals[sides]]
    ends = [np.where((ring[:, 2] == ring[:, 2].max())[:, None], ring, np.nan) for ring in rings]
    strips = []
    for ring, out in zip(ends, outward, strict=True):
        a, b = ring[~np.isnan(ring[:, 0])]
        strip = np.array([a, b, b - out * width, a - out * width])
        upward = np.cross(strip[1] - strip[0], strip[2] - strip[0])[2] > 0
        strips.append(strip if upward else strip[::-1])
    return _halved(np.array(strips))


_OUTWARD = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])


def _halved(rings: Array) -> Array:
    """Every rectangle as two triangles."""
    return rings[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3, 3)
