"""Cutting the tops of a field into rectangles, plainly and slowly."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Mask
from rsegen.geometry.rectangles import merge


class Patch(NamedTuple):
    """The cells i0 <= i < i1, j0 <= j < j1, all of one height [m]."""

    i0: int
    i1: int
    j0: int
    j1: int
    height: float


def merged(heights: Array) -> Iterator[Patch]:
    """The fewest rectangles, as in the shipped surface."""
    for height in np.unique(heights[heights > 0]).tolist():
        yield from _joined(heights == height, height)


def layered(heights: Array) -> Iterator[Patch]:
    """For each height all that is as high or higher, so that no rectangle ends below a higher block's foot."""
    for height in np.unique(heights[heights > 0]).tolist():
        yield from _joined(heights >= height, height)


def largest_first(heights: Array) -> Iterator[Patch]:
    """The largest rectangle of each connected region, then the largest of what remains."""
    for height in np.unique(heights[heights > 0]).tolist():
        for low_i, low_j, region in _regions(heights == height):
            for i0, i1, j0, j1 in _largest(region):
                yield Patch(low_i + i0, low_i + i1, low_j + j0, low_j + j1, height)


def extended(heights: Array) -> Iterator[Patch]:
    """The merged rectangles, each made longer as far as it stays below blocks at least as high."""
    for patch in merged(heights):
        i0, i1, j0, j1, height = patch
        covered = heights > height
        while i0 > 0 and covered[i0 - 1, j0:j1].all():
            i0 -= 1
        while i1 < len(heights) and covered[i1, j0:j1].all():
            i1 += 1
        while j0 > 0 and covered[i0:i1, j0 - 1].all():
            j0 -= 1
        while j1 < heights.shape[1] and covered[i0:i1, j1].all():
            j1 += 1
        yield Patch(i0, i1, j0, j1, height)


def cells(heights: Array) -> Iterator[Patch]:
    """Every cell by itself."""
    for i, j in np.argwhere(heights > 0).tolist():
        yield Patch(i, i + 1, j, j + 1, float(heights[i, j]))


def _joined(mask: Mask, height: float) -> Iterator[Patch]:
    for _, u0, u1, v0, v1 in zip(*(column.tolist() for column in merge(mask.astype(np.int8))), strict=True):
        yield Patch(u0, u1, v0, v1, height)


def _regions(mask: Mask) -> Iterator[tuple[int, int, Mask]]:
    """The 4-connected regions: lowest i and j, and the region within its bounding box."""
    left = mask.copy()
    for start in map(tuple, np.argwhere(mask).tolist()):
        if not left[start]:
            continue
        left[start] = False
        found, edge = [start], [start]
        while edge:
            i, j = edge.pop()
            for near in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
                inside = 0 <= near[0] < mask.shape[0] and 0 <= near[1] < mask.shape[1]
                if inside and left[near]:
                    left[near] = False
                    found.append(near)
                    edge.append(near)
        i, j = np.array(found).T
        region = np.zeros((np.ptp(i) + 1, np.ptp(j) + 1), dtype=bool)
        region[i - i.min(), j - j.min()] = True
        yield int(i.min()), int(j.min()), region


def _largest(region: Mask) -> Iterator[tuple[int, int, int, int]]:
    left = region.copy()
    while left.any():
        i0, i1, j0, j1 = _largest_rectangle(left)
        left[i0:i1, j0:j1] = False
        yield i0, i1, j0, j1


def _largest_rectangle(mask: Mask) -> tuple[int, int, int, int]:
    """By the stack of a histogram, row by row."""
    best, place = 0, (0, 0, 0, 0)
    depth = np.zeros(mask.shape[1], dtype=int)
    for i, row in enumerate(mask):
        depth = np.where(row, depth + 1, 0)
        stack: list[tuple[int, int]] = []
        for j, height in enumerate([*depth.tolist(), 0]):
            start = j
            while stack and stack[-1][1] >= height:
                start, tall = stack.pop()
                if tall * (j - start) > best:
                    best, place = tall * (j - start), (i + 1 - tall, i + 1, start, j)
            stack.append((start, height))
    return place
