"""A robot from below: samples of the surface that it can stand on, with their normals, and its centre of mass.

Solids (boxes, cylinders, spheres, meshes) are sampled where they look down; points inside another solid, or hidden
from below by a lower one, are left out. So a wheel, the round end of a track, a belly and a caster are all samples.
The distance between samples is a sixtieth of the robot's length; half of it is the error with which the edge of a
block is met. Of a fine mesh one sample is kept in each cube of that size, and inside of its flat faces one in each cube
of three times that size, as on the faces of boxes. Cost: once per robot, some ten milliseconds, and a second for a mesh
of 100,000 triangles; larger ones are simplified before (`robots/files/meshes.py`). What breaks it: a part thinner than
the distance of samples.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil, pi
from typing import NamedTuple

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Ints, Mask, make_read_only, read_only_copies
from rsegen.geometry.poses import pose_matrix

_SHARE, _LEAST, _MOST = 60, 0.0025, 0.012
"""Samples along a robot, and the least and largest distance between two of them, metres."""

_DOWN = 0.2
"""Largest upward part of a normal that is kept: a round end that is tilted by 11 degrees still has its lowest point."""

_FLAT, _ROUND = 3, 4
"""A flat face has samples every three distances, as its edge counts; a ball at least every quarter of its radius."""

_HIDDEN, _HIDDEN_FLAT, _PLACE = 0.02, 0.0025, 1.5
"""Metres above another sample of the same place from which a sample is hidden by it, up to tilts of some 30 degrees,
and of one that looks straight down; and distances across a place. With places of 1 distance, or none hidden, 7,000
poses on drives agree as often with MuJoCo's (benchmarks/driven_poses.py); with places of 3, or 1 mm, less well."""

_INSIDE, _COVERED = 2e-4, 2e-3
"""Metres inside another solid from which a sample is left out: more than rounding; 0.1 and 1 mm leave out the same but
for 4 of the crawler's 773. And metres outside of one up to which no wall is above an edge, as the edge of a belt's box
is the belt's round end: 0 and 5 mm tell the same edges of rsegen's robots."""

_EVEN = 0.0005
"""Metres within which the samples of a fine mesh are as low as each other, and flat."""

_NEAR, _GAP = 3.2, 3.1
"""Inside of a flat face a sample has others in its plane, up to `_NEAR` distances away, on all sides: no angle between
two directions to them is as large as that, radians; at a straight edge it is pi. Makers' meshes have 0.6 to 0.75 of
their samples then, and rest where they did (tests/standing/test_fine_meshes.py)."""

_PLACES = 8
"""Possible rows per row up to which rows are numbered by their place among all possible ones, in an array of those."""

_ROWS = 256
"""Samples whose distances to all others are measured together: ten megabytes."""

_NEIGHBOURS = 8
"""Samples of a group: those of a flat part are some 5 cm across, half a block of 10 cm."""


_HIDES_NOTHING = ("mesh", "ellipsoid")
"""Solids inside of which no sample is left out: of a mesh nobody says that it is closed."""


class SurfaceSamples(NamedTuple):
    """Points (n, 3) of a solid's surface, metres, in its own frame, with their outward normals (n, 3).

    rim: which points are on the edge of a flat face, with a wall above; size, kind: the solid, by which `depth` goes
    """

    points: Array
    normals: Array
    rim: Mask
    size: tuple[float, ...]
    kind: str

    def depth(self, points: Array) -> Array:
        """Return how deep points in the solid's frame are inside it, metres; negative outside."""
        if self.kind == "box":
            return np.asarray((np.array(self.size) / 2 - np.abs(points)).min(axis=1))
        if self.kind == "cylinder":
            radius, length = self.size
            return np.minimum(radius - np.hypot(points[:, 0], points[:, 1]), length / 2 + 1e-6 - np.abs(points[:, 2]))
        if self.kind == "ball":
            return np.asarray(self.size[0] - np.linalg.norm(points, axis=1))
        return np.full(len(points), -np.inf)


def sampled_box(size: Sequence[float], distance: float) -> SurfaceSamples:
    """Return the samples of a box along the axes; sides in metres."""
    half, points, normals, rim = np.array(size) / 2, [], [], []
    for axis in range(3):
        first, second = (index for index in range(3) if index != axis)
        along = np.meshgrid(
            *(_grid(-half[index], half[index], _FLAT * distance) for index in (first, second)), indexing="ij"
        )
        for side in (-1, 1):
            face = np.zeros((along[0].size, 3))
            face[:, first], face[:, second], face[:, axis] = along[0].ravel(), along[1].ravel(), side * half[axis]
            normal = np.zeros_like(face)
            normal[:, axis] = side
            points.append(face)
            normals.append(normal)
            # Its edges at the front and the rear: above them is an upright face, which may hit a block (lanes.py).
            rim.append((half[0] - np.abs(face[:, 0]) < 1e-6) & (axis != 0))
    return SurfaceSamples(np.concatenate(points), np.concatenate(normals), np.concatenate(rim), tuple(size), "box")


def sampled_cylinder(radius: float, length: float, distance: float) -> SurfaceSamples:
    """Return the samples of a cylinder along z, with its ends; metres."""
    around = np.arange(max(2 * ceil(pi * radius / distance), 12))
    turns, heights = np.meshgrid(around * 2 * pi / len(around), _grid(-length / 2, length / 2, 3 * distance))
    normals = np.stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)], axis=-1).reshape(-1, 3)
    side = normals * radius + np.array([0, 0, 1]) * heights.reshape(-1, 1)
    # The ends matter for an upright one: rings, down to the middle.
    rings = _grid(0, radius, _FLAT * distance)[:-1]
    disc = [(r * np.cos(t), r * np.sin(t)) for r in rings for t in np.linspace(0, 2 * pi, 9)[:-1]] if len(rings) else []
    ends = [np.array([(x, y, end) for x, y in disc]).reshape(-1, 3) for end in (-length / 2, length / 2)]
    up = [np.tile([0.0, 0.0, float(np.sign(end))], (len(disc), 1)) for end in (-1, 1)]
    points = np.concatenate([side, *ends])
    return SurfaceSamples(
        points, np.concatenate([normals, *up]), np.zeros(len(points), bool), (radius, length), "cylinder"
    )


def sampled_ball(radius: float, distance: float) -> SurfaceSamples:
    """Return the samples of a sphere, metres."""
    normals = _directions(min(_FLAT * distance, radius / _ROUND) / radius)
    return SurfaceSamples(normals * radius, normals, np.zeros(len(normals), bool), (radius,), "ball")


def sampled_ellipsoid(radii: Sequence[float], distance: float) -> SurfaceSamples:
    """Return the samples of an ellipsoid along the axes; radii in metres."""
    directions = _directions(min(_FLAT * distance / max(radii), 1 / _ROUND))
    normals = directions / np.array(radii)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return SurfaceSamples(
        directions * np.array(radii), normals, np.zeros(len(normals), bool), tuple(radii), "ellipsoid"
    )


def sampled_mesh(vertices: Array, faces: Ints, distance: float) -> SurfaceSamples:
    """Return the samples of triangles: vertices (n, 3), metres, and faces (m, 3), which look outward."""
    corners = vertices[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    corners, normal = corners[area > 0], across[area > 0] / area[area > 0, None]  # those of no area look nowhere
    # A triangle gets its corners and middle, and a large one a grid of barycentric coordinates.
    points, normals = [corners.reshape(-1, 3), corners.mean(axis=1)], [np.repeat(normal, 3, axis=0), normal]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0)
    for parts in (2, 4, 8, 16):
        large = longest > parts * _FLAT * distance / 2
        i, j = (index.ravel() for index in np.meshgrid(range(parts + 1), range(parts + 1)))
        shares = np.stack([i, j, parts - i - j], axis=1)[i + j <= parts] / parts
        points.append(np.einsum("ks,msx->mkx", shares, corners[large]).reshape(-1, 3))
        normals.append(np.repeat(normal[large], len(shares), axis=0))
    every = np.concatenate(points)
    return SurfaceSamples(every, np.concatenate(normals), np.zeros(len(every), bool), (), "mesh")


def _grid(low: float, high: float, distance: float) -> Array:
    return np.linspace(low, high, max(ceil((high - low) / distance - 1e-9), 1) + 1)


def _directions(step: float) -> Array:
    """Return unit vectors (n, 3) about `step` radians apart, in rings about z."""
    rings = []
    for polar in np.linspace(0, pi, max(ceil(pi / step), 8) + 1):
        around = np.arange(max(round(2 * pi * np.sin(polar) / step), 1))
        turn = around * 2 * pi / len(around)
        rings.append(
            np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), -np.cos(polar) + 0 * turn], axis=1)
        )
    return np.concatenate(rings)


class CollisionPart(NamedTuple):
    """A collision shape of a robot: its name, whether its surface is driven, and its friction along and across."""

    name: str
    drives: bool
    mu: float
    mu2: float


@read_only_copies
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Body:
    """A rigid robot from below, in the frame of its model, x forward.

    points, normals: samples of its surface (n, 3), metres, and the outward normals there
    groups: (m, 8), samples that are neighbours; all of them, and some twice where their number is no multiple of 8
    part: (n,) index into `parts`; rim: (n,) whether a sample is on the edge of a flat face, with a wall above it
    mass, centre: kg, and the centre of mass (3,); speed: at which it drives over rough ground, m/s
    surface, part_of_surface: samples from all sides, (m, 3) and (m,), part by part, to draw it
    reaction: whether its motors act back on it; else round parts are not held at the sides of blocks
    """

    points: Array
    normals: Array
    groups: Ints
    part: Ints
    rim: Mask
    parts: tuple[CollisionPart, ...]
    mass: float
    centre: Array
    speed: float
    surface: Array
    part_of_surface: Ints
    reaction: bool = True

    def __post_init__(self) -> None:
        own = (self.points, self.normals, self.groups, self.part, self.rim, self.centre)
        make_read_only(*own, self.surface, self.part_of_surface)

    @property
    def low(self) -> Array:
        """The least x, y and z of its samples, metres."""
        return np.asarray(self.points.min(axis=0))

    @property
    def high(self) -> Array:
        """The largest x, y and z of its samples, metres."""
        return np.asarray(self.points.max(axis=0))

    @property
    def width(self) -> float:
        """Width of the body, metres."""
        return float(self.high[1] - self.low[1])

    @property
    def length(self) -> float:
        """Length of the body, metres."""
        return float(self.high[0] - self.low[0])

    def by_part(self, surface: Array) -> list[Array]:
        """Return the rows of `surface`, or of it where the robot stands, of each part."""
        return np.split(surface, self.part_of_surface.searchsorted(np.arange(1, len(self.parts))))

    @property
    def drives(self) -> Mask:
        """Mask of the samples that are driven, (n,)."""
        return np.array([part.drives for part in self.parts])[self.part]


Shape = tuple[CollisionPart, SurfaceSamples, Array]
"""A part, its solid, and the pose of the solid in the model's frame, (4, 4)."""


def sample_distance(length: float) -> float:
    """Return the distance between the samples of a robot of a length, metres."""
    return min(max(length / _SHARE, _LEAST), _MOST)


def body_of_shapes(
    shapes: Iterable[Shape], *, mass: float, centre: Array, speed: float, distance: float, where: str
) -> Body:
    """Return the body of collision shapes; ParameterError if nothing of them looks down."""
    # The samples that look down; of these the lowest ones, outside of all other solids; of meshes as few as of boxes.
    shapes = list(shapes)
    points, normals, part, rim, placed_points = [], [], [], [], []
    for index, (_, solid, pose) in enumerate(shapes):
        # Faces of a box that stand upright have nothing to stand on; their lower edge is that of the face below.
        down = np.flatnonzero(solid.normals @ pose[2, :3] < (-0.05 if solid.kind == "box" else _DOWN))
        placed = solid.points @ pose[:3, :3].T + pose[:3, 3]
        placed_points.append(placed)
        points.append(placed[down])
        normals.append(solid.normals[down] @ pose[:3, :3].T)
        part.append(np.full(len(down), index))
        rim.append(solid.rim[down])
    if not sum(map(len, points)):
        raise ParameterError(where, "has no collision shapes, so it stands on nothing")
    every, normal = np.concatenate(points), np.concatenate(normals)
    seen = np.flatnonzero(~_hidden(every, normal, distance))  # few of the samples of fine meshes
    every, normal, of_part = every[seen], normal[seen], np.concatenate(part)[seen]
    inside, covered = np.zeros(len(every), bool), np.zeros(len(every), bool)
    for index, (_, solid, pose) in enumerate(shapes):
        if solid.kind in _HIDES_NOTHING:
            continue
        depth = solid.depth((every - pose[:3, 3]) @ pose[:3, :3])
        inside |= (depth > _INSIDE) & (of_part != index)
        covered |= (depth > -_COVERED) & (of_part != index)
    outside = np.flatnonzero(~inside)
    is_mesh = np.array([solid.kind == "mesh" for _, solid, _ in shapes])[of_part[outside]]
    of_mesh = outside[is_mesh]
    thinned = _thinned(every[of_mesh] - centre, normal[of_mesh], of_part[of_mesh], distance)
    chosen = np.sort(np.append(outside[~is_mesh], of_mesh[thinned]))
    return Body(
        points=every[chosen],
        normals=normal[chosen],
        groups=_groups(every[chosen]),
        part=of_part[chosen],
        rim=(np.concatenate(rim)[seen] & ~covered)[chosen],
        parts=tuple(part for part, _, _ in shapes),
        mass=mass,
        centre=centre,
        speed=speed,
        surface=np.concatenate(placed_points),
        part_of_surface=np.repeat(np.arange(len(shapes)), [len(placed) for placed in placed_points]),
    )


def _groups(points: Array) -> Ints:
    """Return groups of eight neighbours: the samples are halved across their longest side, and these again."""

    def halves(own: Ints) -> list[Ints]:
        if len(own) <= _NEIGHBOURS:
            return [own]
        across = np.ptp(points[own], axis=0).argmax()
        own = own[np.argsort(points[own, across], kind="stable")]
        # The first half is of whole groups, so only the very last group may be short.
        middle = -(-len(own) // (2 * _NEIGHBOURS)) * _NEIGHBOURS
        return halves(own[:middle]) + halves(own[middle:])

    # That one is filled up with the first samples, once more: `resize` begins anew.
    order = np.concatenate(halves(np.arange(len(points))))
    return np.resize(order, (-(-len(order) // _NEIGHBOURS), _NEIGHBOURS))


def _thinned(points: Array, normals: Array, part: Ints, distance: float) -> Ints:
    """Return one sample of each part in each cube with sides of a distance, and fewer inside of flat faces.

    Of the lowest samples in a cube the one that looks down the most stays, of equal ones the farthest from the middle.
    Makers' meshes are fine where they are round or have screws, and at a corner each triangle has a sample with its own
    normal.
    """
    cube = np.column_stack([np.floor(points / distance).astype(np.int64), part])
    low, in_cube = np.round(points[:, 2] / _EVEN), _numbered(cube)
    lowest = np.full(in_cube.max(initial=-1) + 1, np.inf)
    np.minimum.at(lowest, in_cube, low)
    own = np.flatnonzero(low == lowest[in_cube])  # of millions of samples few are the lowest ones
    far = np.hypot(points[own, 0], points[own, 1])
    order = np.lexsort((-far, np.round(normals[own, 2], 1), in_cube[own]))
    _, first = np.unique(in_cube[own][order], return_index=True)
    own = own[order[first]]
    # Inside of a flat face the corner of a block is met as well by one sample in three along each side.
    flat = _inside_faces(points[own], normals[own], part[own], _NEAR * distance)
    inner = own[flat]
    wide = points[inner] / (_FLAT * distance)
    # Of those in a wider cube the one nearest to its middle stays, so that they are evenly spread.
    off_middle = np.abs(wide - np.floor(wide) - 0.5).sum(axis=1)
    order = np.argsort(off_middle, kind="stable")
    faces = np.column_stack([np.floor(wide), np.round(normals[inner]), part[inner]])
    _, first = np.unique(faces[order], axis=0, return_index=True)
    return np.append(own[~flat], inner[order[first]])


def _numbered(rows: Ints) -> Ints:
    """Return a number for each row (n, k), (n,): equal for equal rows, and in lexicographic order.

    `np.unique(rows, axis=0, return_inverse=True)` takes ten times as long for millions of rows. Its numbers have no
    gaps, these may: rows in a small box are numbered by their place in it.
    """
    if len(rows):
        low, sides = rows.min(axis=0), np.ptp(rows, axis=0) + 1
        if np.prod(sides.astype(float)) <= _PLACES * len(rows):
            return np.asarray(np.ravel_multi_index(tuple((rows - low).T), tuple(sides)))
    # Column by column: the number so far and the rank in the next column are one number, which is made small again.
    ranks = np.zeros(len(rows), np.int64)
    for column in rows.T:
        _, rank = np.unique(column, return_inverse=True)
        _, ranks = np.unique(ranks * (rank.max(initial=0) + 1) + rank, return_inverse=True)
    return ranks


def _inside_faces(points: Array, normals: Array, part: Ints, near: float) -> Mask:
    """Return which samples have near ones of their part in their plane on all sides, (n,); near: metres."""
    inside = np.zeros(len(points), bool)
    for own in (np.flatnonzero(part == of_part) for of_part in np.unique(part)):
        for begin in range(0, len(own), _ROWS):
            rows = own[begin : begin + _ROWS]
            away = points[own] - points[rows, None]
            distance = np.linalg.norm(away, axis=2)
            index, neighbour = np.nonzero((distance < near) & (distance > 0))
            away, normal = away[index, neighbour], normals[rows[index]]
            in_plane = np.abs((away * normal).sum(axis=1)) <= _EVEN
            index, away, normal = index[in_plane], away[in_plane], normal[in_plane]
            inside[rows] = _largest_gaps(index, _directions_in_planes(away, normal), len(rows)) < _GAP
    return inside


def _directions_in_planes(away: Array, normal: Array) -> Array:
    """Return the angle of each vector (n, 3) about its normal (n, 3), from an axis that each normal has of its own."""
    aside = np.where(np.abs(normal[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(normal, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normal, first)
    return np.asarray(np.arctan2((away * second).sum(axis=1), (away * first).sum(axis=1)))


def _largest_gaps(index: Ints, angle: Array, count: int) -> Array:
    """Return the largest angle between neighbouring directions of each of `count` samples; index: whose each is."""
    order = np.lexsort((angle, index))
    index, angle = index[order], angle[order]
    per_sample = np.bincount(index, minlength=count)
    end = np.cumsum(per_sample)[per_sample > 0]
    # The last direction of each sample is followed by its first one, a full turn later.
    following = np.arange(1, len(index) + 1)
    following[end - 1] = end - per_sample[per_sample > 0]
    gap = angle[following] - angle
    gap[end - 1] += 2 * pi
    largest = np.where(per_sample > 0, 0.0, 2 * pi)
    np.maximum.at(largest, index, gap)
    return np.asarray(largest)


def _hidden(points: Array, normals: Array, distance: float) -> Mask:
    """Return which samples are above a lower one of about the same x and y."""
    bins = _numbered(np.round(points[:, :2] / (_PLACE * distance)).astype(np.int64))
    lowest = np.full(bins.max() + 1, np.inf)
    np.minimum.at(lowest, bins, points[:, 2])
    allowed = np.where(normals[:, 2] < -0.9, _HIDDEN_FLAT, _HIDDEN)  # flat ones have the same height in a bin
    return np.asarray(points[:, 2] >= lowest[bins] + allowed)


def body_of_size(length: float, width: float) -> Body:
    """Return the body of a box of a length and a width [m] that lies on the ground and drives with all its underside.

    It is as high as it is long or wide, whichever is less, since nothing is known of its height.
    """
    height = min(length, width)
    at = pose_matrix((0, 0, height / 2))
    distance = max(sample_distance(length), max(length, width) / 600)  # of large ones not more than a robot is worth
    solid = sampled_box((length, width, height), distance)
    return body_of_shapes(
        [(CollisionPart("box", drives=True, mu=1.0, mu2=1.0), solid, at)],
        mass=1.0,
        centre=np.array([0.0, 0.0, height / 2]),
        speed=0.0,
        distance=distance,
        where="size",
    )
