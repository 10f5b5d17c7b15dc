"""Replacements for shapes of robots that a Gazebo lacks, or simulates wrongly.

Gazebo Classic does not open a world with a capsule, which becomes a cylinder with a ball at each end. An ellipsoid with
equal radii is a ball; it has no other ellipsoids and no cones: visuals of these kinds are left out, and a robot with
such a collision shape is refused.

In Gazebo Sim's DART the edge of a mesh holds a ball: a caster of 5 mm, or of 15, stands at a step of 2 mm, which it
climbs if the step is a box, or if the caster is a capsule. So balls that touch are capsules, of next to no length.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import deepcopy
from xml.etree.ElementTree import Element

from rsegen.errors import FileError, shown
from rsegen.geometry.poses import pose_matrix
from rsegen.robots.files.sdf_elements import numbers_text, pose_in, pose_text, put
from rsegen.robots.files.sdf_shapes import floats, matrix_of, radius_and_length

_COLLISION = re.compile(r"<collision\b.*?</collision>", re.DOTALL)
_BALL = re.compile(r"<sphere>\s*(<radius>[^<]*</radius>)\s*</sphere>")
_CAPSULE = r"<capsule>\1<length>0.00001</length></capsule>"
"""A capsule 10 micrometres long: with 10 and with 500 a burger climbs steps of up to 5 mm in Gazebo Sim 10.4, and in
MuJoCo."""


def with_capsules(text: str, simulator: str) -> str:
    """Return the text of a <model> for a simulator; in Gazebo Sim balls that touch become capsules."""
    if simulator == "classic":
        return text
    return _COLLISION.sub(lambda collision: _BALL.sub(_CAPSULE, collision[0]), text)


def use_shapes_of_classic(model: Element, where: str) -> None:
    """Put shapes that Gazebo Classic has in the place of those that it lacks; FileError for one that touches."""
    for link in model.iter("link"):
        for shape in [*link.findall("collision"), *link.findall("visual")]:
            kind = next(iter(shape.iterfind("geometry/*")), None)
            if kind is None or kind.tag not in ("capsule", "ellipsoid", "cone"):
                continue
            place = list(link).index(shape)
            link.remove(shape)
            for part in reversed(list(_parts(shape, kind, where))):
                link.insert(place, part)


def _parts(shape: Element, kind: Element, where: str) -> Iterator[Element]:
    """Yield the shapes that together replace one that Gazebo Classic lacks."""
    if kind.tag == "capsule":
        radius, length = radius_and_length(kind, where)
        if length:
            yield _shape(shape, where, "", 0, "cylinder", radius=radius, length=length)
            yield _shape(shape, where, "_top", length / 2, "sphere", radius=radius)
        yield _shape(shape, where, "_bottom", -length / 2, "sphere", radius=radius)
        return
    radii = floats(kind.findtext("radii"), 3, where) if kind.tag == "ellipsoid" else []
    if radii and len(set(radii)) == 1:
        yield _shape(shape, where, "", 0, "sphere", radius=radii[0])
    elif shape.tag == "collision":
        name = shown(shape.get("name", ""))
        raise FileError(
            f"{where}: its collision shape {name} is of the type {kind.tag}, which Gazebo Classic does not have; drive"
            " it in MuJoCo or in Gazebo Sim"
        )


def _shape(shape: Element, where: str, suffix: str, up: float, kind: str, **sizes: float) -> Element:
    """Return a copy of a shape of this kind and sizes, with a suffix to its name, this far up its axis."""
    made = deepcopy(shape)
    made.set("name", made.get("name", "") + suffix)
    pose = pose_in(made)
    pose.text = pose_text(matrix_of(pose, where) @ pose_matrix((0, 0, up)))
    for attribute in ("degrees", "rotation_format"):
        pose.attrib.pop(attribute, None)
    for geometry in made.findall("geometry"):
        geometry.clear()
    for name, size in sizes.items():
        put(made, f"geometry/{kind}/{name}", numbers_text([size]))
    return made
