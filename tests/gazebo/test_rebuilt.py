"""Visuals equal collisions: the field rebuilt from the visuals, and from the collisions, of the exported files.

For every look, mesh type, mesh and collision shape. A vertical line through the solid shapes of a world is as long
inside them as the block there is high, and ends at its top; five lines go through every cell.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np
import pytest

from rsegen import Recipe, compose
from rsegen.errors import ParameterError
from rsegen.gazebo import MESH_TYPES, export
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import decode
from rsegen.scene.scene import Scene

CHOICES = ("look", "mesh", "collision")
LIFT = 2e-5
"""Metres; for Gazebo Classic alone collisions are 10 micrometres higher than visuals."""
LINES = ((0.0137, -0.0071), (-0.4931, -0.4817), (-0.4779, 0.4937), (0.4873, -0.4691), (0.4949, 0.4807))
"""Places in a cell, from its middle, in block widths: odd numbers, so no line goes through an edge of two triangles."""
BOX = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
BOX_FACES = np.array([[0, 6, 4], [0, 2, 6], [1, 5, 7], [1, 7, 3]])
"""The faces below and above, which alone meet vertical lines; counter-clockwise as seen from outside."""
FRICTIONS: Mapping[str, Mapping[str, object]] = {
    "one-friction": {},
    "friction-by-level": {"frame_friction": 0.4, "level_friction": [0.9, 0.3, 0.6]},
}


def shapes() -> Iterator[tuple[str, dict[str, object]]]:
    """A name and the parameters of every combination of look, mesh type, mesh and collision that a recipe may have."""
    values = [parameters(Recipe)[choice].schema()["enum"] for choice in CHOICES]
    for mesh_type, *chosen in product(MESH_TYPES, *values):
        entries = {"mesh_type": mesh_type, **dict(zip(CHOICES, chosen, strict=True))}
        try:
            decode(entries)
        except ParameterError:
            continue
        yield "-".join(map(str, entries.values())), entries


SHAPES = dict(shapes())


def scene_of(**entries: object) -> Scene:
    """A map of 12 x 6 cells with frames of a height of their own."""
    rows = [{"kind": "random", "levels": 5}]
    usual = {"chunk_size": 4, "chunks": [2, 1], "seed": 1, "frame_height_cm": 15, "obstacles": rows}
    return compose(decode({**usual, **entries}))


@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("shape", SHAPES)
def test_visuals_and_collisions_rebuild_the_field(shape: str, friction: str) -> None:
    check_rebuilt(scene_of(**SHAPES[shape], **FRICTIONS[friction]))


@pytest.mark.parametrize("collision", parameters(Recipe)["collision"].schema()["enum"])
@pytest.mark.parametrize("other", [{"tile": 5}, {"simulator": "classic"}, {"boundary": "none"}], ids=str)
def test_tiles_and_maps_for_classic_rebuild_the_field(collision: str, other: dict[str, object]) -> None:
    check_rebuilt(scene_of(collision=collision, **other))


def test_every_mesh_type_and_look_is_among_them() -> None:
    looks = parameters(Recipe)["look"].schema()["enum"]
    assert {(shape["mesh_type"], shape["look"]) for shape in SHAPES.values()} == set(product(MESH_TYPES, looks))


def check_rebuilt(scene: Scene) -> None:
    """Both the world and the model package, if there is one, have the field's heights, seen and hit."""
    files = {str(path): b"".join(content) for path, content in export(scene).items()}
    for name in (f"{scene.name}.world", "model.sdf"):
        if name not in files:
            continue
        for tag in ("visual", "collision"):
            tops, lengths = rebuilt(scene, files, name, tag)
            heights = np.repeat(scene.field.heights[..., None], len(LINES), axis=2)
            np.testing.assert_allclose(tops, heights, atol=LIFT, err_msg=f"tops of the {tag}s of {name}")
            np.testing.assert_allclose(lengths, heights, atol=LIFT, err_msg=f"insides of the {tag}s of {name}")


def rebuilt(scene: Scene, files: Mapping[str, bytes], name: str, tag: str) -> tuple[np.ndarray, np.ndarray]:
    """Heights at which lines leave the shapes, and lengths inside; metres, (n_x, n_y, lines)."""
    triangles = np.concatenate([*world_triangles(files, name, tag), np.zeros((0, 3, 3))])
    middle_x, middle_y = ((edges[:-1] + edges[1:]) / 2 for edges in scene.field.edges())
    aside_x, aside_y = np.array(LINES).T * scene.field.block_width
    x, y = np.broadcast_arrays(middle_x[:, None, None] + aside_x, middle_y[None, :, None] + aside_y)
    a, b, c = (triangles[:, corner, :, None, None, None] for corner in range(3))
    twice_area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):  # of triangles that stand upright, which no line meets
        share_b = ((x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (y - a[:, 1]) * (c[:, 0] - a[:, 0])) / twice_area
        share_c = ((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])) / twice_area
        met = (np.abs(twice_area) > 1e-12) & (share_b >= 0) & (share_c >= 0) & (share_b + share_c <= 1)
        z = np.where(met, a[:, 2] + share_b * (b[:, 2] - a[:, 2]) + share_c * (c[:, 2] - a[:, 2]), 0)
    return z.max(axis=0, initial=0), (np.sign(twice_area) * z).sum(axis=0)


def world_triangles(files: Mapping[str, bytes], name: str, tag: str) -> Iterator[np.ndarray]:
    """The triangles of every visual or collision of a file but the ground's, in metres in the world; (n, 3, 3)."""
    for model in ET.fromstring(files[name]).iter("model"):
        if model.get("name") == "ground_plane":
            continue
        for link in model.iter("link"):
            for shape in link.findall(tag):
                yield triangles_of(shape, files) + position(model) + position(link) + position(shape)


def triangles_of(shape: ET.Element, files: Mapping[str, bytes]) -> np.ndarray:
    """The triangles of a box or of a mesh, around its own origin."""
    size, uri = shape.findtext("geometry/box/size"), shape.findtext("geometry/mesh/uri")
    if size:
        return np.asarray((BOX * [float(side) for side in size.split()])[BOX_FACES])
    assert uri
    assert shape.find("geometry/mesh/scale") is None
    return obj_triangles(files[uri[uri.index("meshes/") :]].decode())


def obj_triangles(text: str) -> np.ndarray:
    """The faces of an OBJ file, polygons cut into triangles."""
    lines = [line.split() for line in text.splitlines()]
    vertices = np.array([[float(at) for at in words[1:4]] for words in lines if words[:1] == ["v"]])
    faces = [[int(corner.split("/")[0]) - 1 for corner in words[1:]] for words in lines if words[:1] == ["f"]]
    fans = [(face[0], *face[k : k + 2]) for face in faces for k in range(1, len(face) - 1)]
    return np.asarray(vertices[np.array(fans)])


def position(element: ET.Element) -> np.ndarray:
    """Place of an element in its parent; none of ours is turned."""
    x, y, z, *turn = (float(number) for number in (element.findtext("pose") or "0 0 0 0 0 0").split())
    assert turn == [0, 0, 0]
    return np.array([x, y, z])
