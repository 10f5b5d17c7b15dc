"""Turn URDF into SDF; a robot of ROS then is read, placed and driven as a robot of Gazebo is.

It becomes what Gazebo makes of it (sdformat's parser_urdf): links that hang on fixed joints become one link with the
first of them, which keeps its name, with their masses, shapes and sensors. So a base_footprint without a mass, of which
physics engines make 1 kg, or an error, is one body with what hangs on it. preserveFixedJoint keeps a joint if both of
its links have a mass. The root link is at the origin of the model. What hangs on a joint that moves, and has no mass,
is left out, with all that hangs on it. Gazebo's elements go into their link, its shapes or their joint, or into the
model. Cost: linear. What breaks it: planar joints are refused; plug-ins keep the names of links that were merged.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from math import isnan, nan
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from rsegen.errors import FileError, shown, some_of
from rsegen.field.stepfield import Array
from rsegen.geometry.poses import pose_matrix, rotation
from rsegen.robots.files.mimics import Mimic, put_mimic
from rsegen.robots.files.sdf_elements import (
    LATEST_OF_CLASSIC,
    LUMPED,
    MOMENTS,
    NO_MASS,
    Mass,
    append_inertial,
    is_true,
    moved,
    numbers_text,
    pose_text,
    put,
    put_all,
    sum_of_masses,
    unit_axis,
)
from rsegen.robots.files.sdf_shapes import floats, refuse_mass, refuse_moments, tensor_of

_WORLD = "world"
"""The root link of a robot that stands fixed in the world."""

_JOINTS = {"continuous": "revolute", "revolute": "revolute", "prismatic": "prismatic", "fixed": "fixed", "floating": ""}
"""Types of joints in URDF, and in SDF, where two links that float have no joint."""

_GEOMETRIES = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "capsule": {"radius": 1, "length": 1},
    "mesh": {"scale": 3},
}
"""Shapes, and how many numbers each of their attributes has."""

_SURFACE = {
    "mu1": "surface/friction/ode/mu",
    "mu2": "surface/friction/ode/mu2",
    "fdir1": "surface/friction/ode/fdir1",
    "kp": "surface/contact/ode/kp",
    "kd": "surface/contact/ode/kd",
    "maxVel": "surface/contact/ode/max_vel",
    "minDepth": "surface/contact/ode/min_depth",
    "maxContacts": "max_contacts",
    "laserRetro": "laser_retro",
}
"""Elements of <gazebo> for the collision shapes of a link."""

_OF_LINK = {
    "selfCollide": ("self_collide",),
    "dampingFactor": ("velocity_decay/linear", "velocity_decay/angular"),
}
_OF_JOINT = {
    "springStiffness": ("axis/dynamics/spring_stiffness",),
    "springReference": ("axis/dynamics/spring_reference",),
    "stopCfm": ("physics/ode/limit/cfm",),
    "stopErp": ("physics/ode/limit/erp",),
    "provideFeedback": ("physics/ode/provide_feedback",),
    "implicitSpringDamper": ("physics/ode/implicit_spring_damper",),
    "fudgeFactor": ("physics/ode/fudge_factor",),
}
_KEEPS = ("preserveFixedJoint", "disableFixedJointLumping")
_ELSEWHERE = {*_SURFACE, *_KEEPS, "material", "visual", "collision", "turnGravityOff"}
"""Elements of <gazebo> that go neither into a link nor into a joint as they are."""

_PLACED = ("sensor", "light", "projector")
"""Elements of a link that have a <pose> in it."""

_SCRIPTS = "file://media/materials/scripts/gazebo.material"
"""The file of Gazebo Classic's colours, such as Gazebo/Blue."""

_UNLIMITED = 1e16
"""The number that means no limit in SDF."""


class Converted(NamedTuple):
    """The <sdf> element of a robot, and its parts that differ from its file.

    left_out: names of links that were left out, as they have no mass; mimics: names of joints that should follow
    another one in a way that SDF does not have
    """

    sdf: Element
    left_out: tuple[str, ...] = ()
    mimics: tuple[str, ...] = ()


class _Joint(NamedTuple):
    """A joint of the tree, and its place in its parent link, (4, 4)."""

    name: str
    kind: str
    parent: str
    child: str
    element: Element
    place: Array


@dataclass(frozen=True, kw_only=True, slots=True)
class _Source:
    """The robot that is read: its links, the link that each becomes a part of, its extensions and its colours.

    extensions: the elements in <gazebo> by what they are for, then by their tags; empty for the model
    """

    where: str
    links: Mapping[str, Element]
    heads: Mapping[str, str]
    extensions: Mapping[str, Mapping[str, Sequence[Element]]]
    colours: Mapping[str, str]

    def last(self, name: str, tag: str) -> Element | None:
        """Return the last element of a tag for a link or joint."""
        elements = self.extensions.get(name, {}).get(tag)
        return elements[-1] if elements else None


def converted(robot: Element, where: str, separate: Collection[str] = ()) -> Converted:
    """Return a <robot> as SDF; FileError, which begins with `where`, if its links are no tree, or a value is none.

    separate: links that remain links of their own on fixed joints, if they have a mass: tracks
    """
    links = dict(_named(robot.findall("link"), "link", where))
    joints = [_joint(name, joint, links, where) for name, joint in _named(robot.findall("joint"), "joint", where)]
    above = _above(joints, links, where)
    order = _from_the_root_on(above, links, where)
    bodies = {name: _body(link, f"{where}: link {shown(name)}") for name, link in links.items()}
    extensions = _extensions(robot)
    heads = _heads(order, above, bodies, extensions, separate)
    materials = reversed(list(robot.iter("material")))  # wherever they are; of one name, the first counts
    colours = {part.get("name", ""): rgba for part in materials if (rgba := _attribute(part, "rgba", "color"))}
    source = _Source(where=where, links=links, heads=heads, extensions=extensions, colours=colours)

    # Places of links in the model, and in the link of SDF that they become a part of.
    places: dict[str, Array] = {}
    merged: dict[str, dict[str, Array]] = {}
    for name in order:
        places[name] = places[above[name].parent] @ above[name].place if name in above else np.eye(4)
        inside = np.eye(4) if heads[name] == name else np.linalg.inv(places[heads[name]]) @ places[name]
        merged.setdefault(heads[name], {})[name] = inside
    masses = {
        head: sum_of_masses((bodies[name], place) for name, place in parts.items()) for head, parts in merged.items()
    }
    _refuse_moments_of(masses, merged, where)
    left_out = _left_out(source, above, masses)

    # Then one link of SDF for each head, with the parts of all links in it, and its joint.
    sdf = Element("sdf", version=LATEST_OF_CLASSIC)
    model = SubElement(sdf, "model", name=robot.get("name", ""))
    for head, parts in merged.items():
        if head in left_out or (head == _WORLD and head not in above):
            continue
        link = SubElement(model, "link", name=head)
        put(link, "pose", pose_text(places[head]))
        append_inertial(link, masses[head])
        counts: Counter[str] = Counter()
        for name, place in parts.items():
            _append_parts(link, name, place, counts, source)
        if head in above and _JOINTS[above[head].kind]:
            _append_joint(model, above[head], source)
    if model.find("link") is None:
        raise FileError(
            f"{where}: links {', '.join(map(shown, masses))} have no mass; a simulator needs their <inertial>"
        )
    for elements in extensions.get("", {}).values():
        model.extend(map(deepcopy, elements))
    return Converted(sdf, tuple(left_out))


def _named(elements: Iterable[Element], what: str, where: str) -> Iterator[tuple[str, Element]]:
    """Yield elements with their names, which SDF wants to be there, different, and without the :: of nested models."""
    names = set()
    for element in elements:
        name = element.get("name", "").strip()
        if not name or "::" in name:
            raise FileError(f"{where}: a <{what}> has the name {shown(name)}; it needs letters, and no ::")
        if name in names:
            raise FileError(f"{where}: two elements <{what}> have the name {shown(name)}")
        names.add(name)
        yield name, element


def _joint(name: str, joint: Element, links: Mapping[str, Element], where: str) -> _Joint:
    place = f"{where}: joint {shown(name)}"
    kind = joint.get("type", "")
    if kind not in _JOINTS:
        raise FileError(f"{place}: its type {shown(kind)} is none of {', '.join(_JOINTS)}")
    parent, child = (_attribute(joint.find(tag), "link") for tag in ("parent", "child"))
    for link in (parent, child):
        if link not in links:
            part = "if it is a part of a robot, use the file of the robot that includes it"
            raise FileError(f"{place}: there is no link {shown(link)}; {part}")
    return _Joint(name, kind, parent, child, joint, _origin(joint, place))


def _above(joints: Iterable[_Joint], links: Mapping[str, Element], where: str) -> dict[str, _Joint]:
    """Return the joint above each link but the root."""
    above: dict[str, _Joint] = {}
    for joint in joints:
        first = above.setdefault(joint.child, joint)
        if first is not joint:
            names = f"{shown(first.name)} and {shown(joint.name)}"
            raise FileError(f"{where}: link {shown(joint.child)} is the child of two joints, {names}")
    if not links:
        raise FileError(f"{where}: the robot has no <link>")
    roots = [name for name in links if name not in above]
    if len(roots) != 1:
        names = f": {', '.join(map(shown, roots[:3]))}" if roots else ""
        raise FileError(f"{where}: {len(roots)} links are the child of no joint{names}; a robot has one, its root")
    return above


def _from_the_root_on(above: Mapping[str, _Joint], links: Mapping[str, Element], where: str) -> list[str]:
    """Return the names of the links, each after its parent, by joints' names, as sdformat counts shapes."""
    below: dict[str, list[str]] = {name: [] for name in links}
    for child, joint in above.items():
        below[joint.parent].append(child)
    order: list[str] = []
    waiting = [name for name in links if name not in above]
    while waiting:
        order.append(waiting.pop())
        waiting += sorted(below[order[-1]], key=lambda name: above[name].name, reverse=True)
    lost = links.keys() - set(order)  # not reached from the root
    if lost:
        raise FileError(f"{where}: the joints above link {shown(min(lost))} form a loop")
    return order


def _heads(
    order: Sequence[str],
    above: Mapping[str, _Joint],
    bodies: Mapping[str, Mass],
    extensions: Mapping[str, Mapping[str, Sequence[Element]]],
    separate: Collection[str],
) -> dict[str, str]:
    """Return the link that each link becomes a part of: the first on this side of a joint that moves, or is kept."""
    heads: dict[str, str] = {}
    for name in order:
        joint = above.get(name)
        is_separate = joint is None or joint.kind != "fixed" or joint.parent == order[0] == _WORLD
        if joint and not is_separate and bodies[name].mass:  # one without a mass always becomes a part
            of_joint = extensions.get(joint.name, {}) if bodies[joint.parent].mass else {}
            is_separate = name in separate or any(
                is_true(_value(element)) for tag in _KEEPS for element in of_joint.get(tag, ())
            )
        heads[name] = name if joint is None or is_separate else heads[joint.parent]
    return heads


_MOST_NAMED = 5
"""Links in a message at most."""


def _refuse_moments_of(masses: Mapping[str, Mass], merged: Mapping[str, Collection[str]], where: str) -> None:
    """Raise a FileError for a link that has a negative moment of inertia with those that are fixed to it.

    Not for one of these alone, as an antenna whose moments are rounded: simulators get the sum.
    """
    for head, parts in merged.items():
        if masses[head].mass:
            fixed = " with those that are fixed to it" if len(parts) > 1 else ""
            refuse_moments(masses[head].tensor, f"{where}: link {shown(head)}{fixed}")


def _left_out(source: _Source, above: Mapping[str, _Joint], masses: Mapping[str, Mass]) -> dict[str, None]:
    """Return the links that have no mass, and those below them; FileError if this is the root."""
    left_out: dict[str, None] = {}
    for head, body in masses.items():
        if head not in above:
            if not body.mass and head != _WORLD:
                fixed = [shown(link) for link, its_head in source.heads.items() if its_head == head != link]
                nor = f", nor have those that are fixed to it: {some_of(fixed, _MOST_NAMED)}" if fixed else ""
                why = f"link {shown(head)} has no mass{nor}; a simulator needs {'an' if fixed else 'its'} <inertial>"
                raise FileError(f"{source.where}: {why}")
        elif not body.mass or source.heads[above[head].parent] in left_out:
            left_out[head] = None
    return left_out


def _extensions(robot: Element) -> dict[str, dict[str, list[Element]]]:
    """Return the elements in <gazebo> by the link or joint that they are for, then by their tags."""
    extensions: dict[str, dict[str, list[Element]]] = {}
    for gazebo in robot.findall("gazebo"):
        for element in gazebo:
            extensions.setdefault(gazebo.get("reference", ""), {}).setdefault(element.tag, []).append(element)
    return extensions


def _body(link: Element, where: str) -> Mass:
    """Return the inertial of a link in its frame; nothing if it has none, or no mass, as in sdformat."""
    inertial = link.find("inertial")
    if inertial is None:
        return NO_MASS
    (mass,) = floats(_attribute(inertial.find("mass"), "value"), 1, f"{where}: mass")
    if mass == 0:
        return NO_MASS
    inertia = inertial.find("inertia")
    tensor = tensor_of([floats(_attribute(inertia, name), 1, f"{where}: {name}")[0] for name in MOMENTS])
    refuse_mass(mass, where)
    return moved(Mass(mass, np.zeros(3), tensor), _origin(inertial, where))


def _append_parts(link: Element, name: str, place: Array, counts: Counter[str], source: _Source) -> None:
    """Append what a link of URDF has to the link of SDF in which it is at a place, (4, 4); counts: the shapes in it."""
    for tag in ("collision", "visual"):
        for shape in source.links[name].findall(tag):
            made = _shape(shape, link.get("name", ""), name, place, source)
            # sdformat numbers the shapes of a link so, and contact sensors of models for Gazebo give these names.
            if counts[tag]:
                made.set("name", f"{made.get('name')}_{counts[tag]}")
            counts[tag] += 1
            link.append(made)
    for tag, elements in source.extensions.get(name, {}).items():
        text = _value(elements[-1])
        if tag == "turnGravityOff":
            put(link, "gravity", "false" if is_true(text) else "true")
        elif tag in _OF_LINK:
            put_all(link, _OF_LINK[tag], text)
        elif tag not in _ELSEWHERE:
            link.extend([_placed(element, place, source.where) for element in elements])


def _shape(shape: Element, head: str, name: str, place: Array, source: _Source) -> Element:
    """Return a <collision> or <visual> of a link of URDF, which is at a place, (4, 4), in the link `head` of SDF."""
    # In sdformat a shape without a name is called as its link; in a lumped link, or with a name, the head comes first.
    place_in_file = f"{source.where}: link {shown(name)}: a <{shape.tag}>"
    lump = f"{head}{LUMPED}" if name != head or shape.get("name") else ""
    made = Element(shape.tag, name=f"{lump}{shape.get('name') or name}_{shape.tag}")
    put(made, "pose", pose_text(place @ _origin(shape, place_in_file)))
    made.append(_geometry(shape.find("geometry"), place_in_file))
    more = source.last(name, shape.tag)
    if more is not None:
        made.extend(deepcopy(child) for child in more if child.tag not in ("pose", "geometry"))
    if shape.tag == "visual":
        _append_material(made, shape.find("material"), name, source)
        return made
    for tag, path in _SURFACE.items():
        element = source.last(name, tag)
        if element is not None:
            put(made, path, _value(element))
    return made


def _append_material(visual: Element, material: Element | None, name: str, source: _Source) -> None:
    """Append a colour, and the name of one of Gazebo Classic's, if the shape has none from <gazebo>."""
    if visual.find("material") is not None:
        return
    colour = _attribute(material, "rgba", "color") or source.colours.get(_attribute(material, "name"))
    if colour:
        rgba = numbers_text(floats(colour, 4, f"{source.where}: the colour of a material"))
        put_all(visual, ("material/ambient", "material/diffuse"), rgba)
    script = source.last(name, "material")
    if script is not None and _value(script):
        put(visual, "material/script/uri", _SCRIPTS)
        put(visual, "material/script/name", _value(script))


def _append_joint(model: Element, joint: _Joint, source: _Source) -> None:
    """Append a joint; its frame is its child's, as SDF has it by default, so it gets no pose."""
    made = SubElement(model, "joint", name=joint.name, type=_JOINTS[joint.kind])
    put(made, "parent", source.heads[joint.parent])
    put(made, "child", joint.child)
    if joint.kind != "fixed":
        _append_axis(made, joint, f"{source.where}: joint {shown(joint.name)}")
    for tag, elements in source.extensions.get(joint.name, {}).items():
        if tag in _OF_JOINT:
            put_all(made, _OF_JOINT[tag], _value(elements[-1]))
        elif tag not in _ELSEWHERE:
            made.extend(map(deepcopy, elements))


def _append_axis(made: Element, joint: _Joint, where: str) -> None:
    axis = floats(_attribute(joint.element.find("axis"), "xyz") or "1 0 0", 3, where)
    put(made, "axis/xyz", numbers_text(unit_axis(axis, where)))
    limit, dynamics = joint.element.find("limit"), joint.element.find("dynamics")
    if limit is not None and joint.kind != "continuous":
        for name in ("lower", "upper"):  # which are 0 by default
            _put_number(made, f"axis/limit/{name}", _attribute(limit, name) or "0", where)
    for name in ("effort", "velocity"):
        _put_number(made, f"axis/limit/{name}", _attribute(limit, name), where)
    for name in ("damping", "friction"):
        _put_number(made, f"axis/dynamics/{name}", _attribute(dynamics, name), where)
    if (mimic := joint.element.find("mimic")) is not None:
        defaults = {"multiplier": "1", "offset": "0"}
        numbers = (floats(_attribute(mimic, name) or default, 1, where)[0] for name, default in defaults.items())
        put_mimic(made, Mimic(_attribute(mimic, "joint"), *numbers))


def _geometry(geometry: Element | None, where: str) -> Element:
    """Return the <geometry> of SDF for a <geometry> of URDF."""
    shape = next((child for child in geometry if child.tag in _GEOMETRIES), None) if geometry is not None else None
    if shape is None:
        raise FileError(f"{where} has none of the shapes {', '.join(_GEOMETRIES)}")
    made = Element("geometry")
    solid = SubElement(made, shape.tag)
    if shape.tag == "mesh":
        put(solid, "uri", _attribute(shape, "filename"))
    for name, count in _GEOMETRIES[shape.tag].items():
        text = shape.get(name)
        if text is not None or shape.tag != "mesh":
            put(solid, name, numbers_text(floats(text, count, where)))
    return made


def _placed(extension: Element, place: Array, where: str) -> Element:
    """Return a copy of an element of a link, with its <pose> in the link that this is a part of."""
    made = deepcopy(extension)
    if made.tag in _PLACED and not np.array_equal(place, np.eye(4)):
        text = (made.findtext("pose") or "").strip() or "0 0 0 0 0 0"
        x, y, z, *turn = floats(text, 6, f"{where}: the pose of a <{made.tag}>")
        put(made, "pose", pose_text(place @ pose_matrix((x, y, z), rotation(*turn))))
    return made


def _origin(element: Element, where: str) -> Array:
    """Return the <origin> of an element, (4, 4); URDF and SDF have the same roll, pitch and yaw."""
    origin = element.find("origin")
    xyz, rpy = (floats(_attribute(origin, name) or "0 0 0", 3, where) for name in ("xyz", "rpy"))
    return pose_matrix(xyz, rotation(*rpy))


def _attribute(element: Element | None, name: str, child: str = "") -> str:
    """Return an attribute of an element, or of its child; an empty text for none."""
    owner = element.find(child) if element is not None and child else element
    return "" if owner is None else owner.get(name, "").strip()


def _put_number(element: Element, path: str, text: str, where: str) -> None:
    """Put a number into an element at a path; nothing for none, or for one so large that it is no limit."""
    try:
        value = float(text or "inf")
    except ValueError:
        value = nan
    if isnan(value):
        raise FileError(f"{where}: {shown(text)} is not a number")
    if abs(value) < _UNLIMITED:
        put(element, path, numbers_text([value]))


def _value(extension: Element) -> str:
    """Return the value of an element in <gazebo>, as <mu1>1</mu1> or <mu1 value="1"/>."""
    return extension.get("value") or (extension.text or "").strip()
