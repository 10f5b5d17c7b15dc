"""The format `mjcf`: the map as one static MuJoCo body, and a scene with light, ground and camera that includes it.

MuJoCo uses the convex hull of a mesh for collisions, so no collision geometry here is a mesh: boxes are exact, and a
height field slopes from each sample to the next.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from math import hypot
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, StepField
from rsegen.formats.base import Format, Step, register
from rsegen.formats.parts import objs
from rsegen.gazebo.obj import material_name, texture_files, texture_name
from rsegen.gazebo.sdf import numbers, utf8
from rsegen.geometry.box_merging import Column, columns
from rsegen.params.numbers import decimal
from rsegen.params.sorts import Choice, Integer, parameters
from rsegen.scene.contact import CONTACT, Contact
from rsegen.scene.scene import Scene


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Mjcf(Format):
    """A static body for MuJoCo (MJCF), of boxes, a height field, or a mesh with boxes, and a scene that includes it."""

    name: ClassVar[str] = "mjcf"
    also: ClassVar[tuple[str, ...]] = ("mujoco", "xml")
    step: ClassVar[Step] = "surface"

    shape: Annotated[
        str,
        Choice(
            ("boxes", "hfield", "mesh"),
            help="geometry: boxes; a height field, which slopes between its samples; "
            "or a visual mesh with collision boxes",
        ),
    ] = "boxes"
    pixels: Annotated[
        int, Integer(1, 100, help="samples of a height field along each side of a cell; mujoco_warp takes up to 4")
    ] = 4
    priority: Annotated[int, parameters(Contact)["priority"]] = CONTACT.priority

    @property
    def array_bytes(self) -> int:
        """Bytes of the samples of a height field, for every cell."""
        return 8 * self.pixels**2 if self.shape == "hfield" else 0

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return the map under its own name, the scene, and the mesh or height field files of the map."""
        body, contact = self._body(scene), Contact(priority=self.priority)
        return {
            f"{scene.name}.xml": utf8(_map(scene, body, contact)),
            "scene.xml": utf8(_scene(scene, contact)),
            **body.files,
        }

    def _body(self, scene: Scene) -> _BodyElements:
        if self.shape == "hfield" and not scene.recipe.is_of_one_friction:
            problem = "'hfield' has one friction coefficient, but the recipe has several; use boxes or mesh"
            raise ParameterError("shape", problem)
        if not scene.field.is_raised():
            return _BodyElements()
        if self.shape == "hfield":
            return _height_field(scene, self.pixels)
        if self.shape == "mesh" or scene.recipe.is_textured:  # only meshes have texture coordinates in MuJoCo
            return _meshes(scene)
        boxes = list(columns(scene.field))
        geoms = (_box(scene, column, f' material="{_material(scene, column.material)}"') for column in boxes)
        return _BodyElements(assets=_materials(scene, {column.material for column in boxes}), geoms=geoms)


@dataclass(frozen=True, kw_only=True, slots=True)
class _BodyElements:
    """The parts of a body: assets, <geom> elements, the files that they need, and the group of collision geoms."""

    assets: Iterable[str] = ()
    geoms: Iterable[str] = ()
    files: Mapping[str, Iterable[bytes]] = field(default_factory=dict)
    group: int = 0


def _meshes(scene: Scene) -> _BodyElements:
    """Return visual meshes, one per material and texture, and collision boxes in group 3, which viewers hide."""
    images, files = texture_files(scene), {}
    assets = [f'    <texture name="{name.removesuffix(".png")}" type="2d" file="{name}"/>\n' for name in images]
    for material, part, content in objs(scene, textured=bool(images)):
        name = _material(scene, material, part)
        texture = f' texture="{texture_name(scene, part).removesuffix(".png")}"' if part else ""
        rgba = numbers((*scene.tint(material), 1))
        assets.append(f'    <material name="{name}"{texture} rgba="{rgba}" specular="0.1"/>\n')
        files[name] = content
    # Each mesh has the material of its name.
    meshes = (f'    <mesh name="{name}" file="{name}.obj" inertia="shell"/>\n' for name in files)
    visuals = (
        f'      <geom type="mesh" mesh="{name}" material="{name}" mass="0" contype="0" conaffinity="0" group="2"/>\n'
        for name in files
    )
    return _BodyElements(
        assets=chain(assets, meshes),
        geoms=chain(visuals, (_box(scene, column) for column in columns(scene.field))),
        files={f"{name}.obj": content for name, content in files.items()} | images,
        group=3,
    )


def _height_field(scene: Scene, pixels: int) -> _BodyElements:
    """Return a height field with samples at the centres of small squares, `pixels` per side of a cell.

    MuJoCo scales samples to 0..1, so the position of the geom is the lowest one. It puts the first and the last sample
    of a row on the sides of the field, which so ends half a small square inside the map.
    """
    # From lowest to highest sample; a flat map has an extent of 1 m that nothing uses, as 0 is not allowed.
    heights = _sampled(scene.field, pixels)
    low, high = float(heights.min()), float(heights.max())
    sides = ((extent - extent / count) / 2 for extent, count in zip(scene.field.extent, heights.shape, strict=True))
    size = numbers((*sides, high - low or 1.0, low or _BASE))  # the base reaches down to z = 0
    return _BodyElements(
        assets=[
            *_materials(scene, {scene.recipe.top_level}),
            f'    <hfield name="{scene.name}" file="{scene.name}.hfield" size="{size}"/>\n',
        ],
        geoms=[
            f'      <geom type="hfield" hfield="{scene.name}" pos="0 0 {decimal(low)}" '
            f'material="{_material(scene, scene.recipe.top_level)}"/>\n'
        ],
        # Rows and columns, then rows of single precision from the smallest y on.
        files={
            f"{scene.name}.hfield": [
                np.array(heights.shape[::-1], dtype="<i4").tobytes(),
                ((heights - low) / (high - low or 1.0)).T.astype("<f4").tobytes(),
            ]
        },
    )


_BASE = 0.01
"""Thickness in metres of the base of a height field, which MuJoCo requires."""


def _sampled(field: StepField, pixels: int) -> Array:
    """Return the heights of small squares; at least two along each axis, the minimum of MuJoCo."""
    heights = field.heights
    for axis, cells in enumerate(field.shape):
        heights = heights.repeat(max(pixels, 3 - cells), axis=axis)
    return heights


def _map(scene: Scene, body: _BodyElements, contact: Contact) -> Iterator[str]:
    """Yield the file of the body alone, to be included or attached."""
    # In pieces, as a large map has many geoms; names have the map's name, so that two maps can be in a scene. The class
    # has all that decides a contact, as it would inherit the rest from the defaults of a model that includes the file.
    name = scene.name
    yield f"""\
<!-- made by rsegen: metres, z up, the middle of the map at 0 0 0, the ground at z = 0 -->
<mujoco model="{name}">
  <default>
    <default class="{name}">
      <geom type="box" mass="0" quat="1 0 0 0" group="{body.group}" {_contact(contact, scene.friction)}/>
    </default>
  </default>
  <asset>
"""
    yield from body.assets
    yield f"""\
  </asset>
  <worldbody>
    <body name="{name}" childclass="{name}">
"""
    yield from body.geoms
    yield "    </body>\n  </worldbody>\n</mujoco>\n"


def _scene(scene: Scene, contact: Contact) -> Iterator[str]:
    """Yield the scene with light, a ground plane and a camera; the free camera of viewers sees the whole map."""
    # Viewers put the free camera at 1.5 times `extent` from the centre.
    across = hypot(*scene.field.extent)
    top = float(scene.field.heights.max())
    shadows = "true" if scene.recipe.shadows else "false"
    yield f"""\
<!-- made by rsegen -->
<mujoco model="{scene.name} scene">
  <include file="{scene.name}.xml"/>
  <statistic center="0 0 {decimal(top / 2)}" extent="{decimal(0.8 * across)}"/>
  <visual>
    <headlight ambient="0.3 0.3 0.3" diffuse="0.4 0.4 0.4" specular="0 0 0"/>
    <global azimuth="60" elevation="-35"/>
  </visual>
{_SKY if scene.recipe.sky else ""}  <worldbody>
    <light name="sun" directional="true" castshadow="{shadows}" dir="-0.4 0.3 -0.86" diffuse="0.6 0.6 0.6"/>
    <camera name="overview" pos="0 {decimal(-across)} {decimal(across)}" xyaxes="1 0 0 0 1 1"/>
    <geom name="ground" type="plane" size="0 0 1" pos="0 0 0" quat="1 0 0 0" group="0" rgba="0.6 0.6 0.6 1"
      {_contact(contact, scene.friction)}/>
  </worldbody>
</mujoco>
"""


_SKY = """\
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.95 0.97 1" rgb2="0.45 0.62 0.85" width="256" height="1536"/>
  </asset>
"""


def _materials(scene: Scene, materials: Iterable[int]) -> Iterator[str]:
    for material in sorted(materials):
        rgba = numbers((*scene.colour(material), 1))
        yield f'    <material name="{_material(scene, material)}" rgba="{rgba}" specular="0.1"/>\n'


def _material(scene: Scene, material: int, part: str = "") -> str:
    """Return the name of a material with the map's name, so that two maps can be in one scene."""
    return f"{scene.name}_{material_name(material, part)}"


def _box(scene: Scene, column: Column, material: str = "") -> str:
    """Return the <geom> of a box; its friction is only written if it is not the map's."""
    friction = scene.friction_of(column.material)
    own = "" if friction == scene.friction else f' friction="{decimal(friction)}"'
    place = f'pos="{numbers(column.centre)}" size="{numbers(side / 2 for side in column.size)}"'
    return f"      <geom {place}{own}{material}/>\n"


def _contact(contact: Contact, sliding: float) -> str:
    """Return the attributes of a <geom> that decide its contacts."""
    return " ".join(f'{name}="{numbers(values)}"' for name, values in contact.attributes(sliding).items())
