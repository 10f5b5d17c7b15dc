"""Models of SDF as a Gazebo reads them: led by their body, and for Gazebo Classic without elements unknown to it.

A Gazebo says where a model is by one of its links, the canonical one: the first of the model itself, or in Gazebo Sim
the one that the model names. If that is a wheel, a robot that drives seems to tip over with each turn of it. So the
link on which all others hang comes first.

Gazebo Classic has the first links of nested models behind those of the model, and overlooks degrees, quaternions and
frames of nested models, which came with SDF 1.8 and 1.9. A model with one of them becomes flat: links with poses in its
frame, and joints between them, by the names that they have in it. In Gazebo Sim the drives find joints and links of
their own model alone, so a model that drives on those of a nested one becomes flat too, with names without ::, which
SDF has for nested ones. Cost: that of all poses. What breaks it: sensors of a nested model whose poses are relative to
others.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from functools import partial
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from rsegen.errors import FileError, shown
from rsegen.field.stepfield import Array
from rsegen.robots.drives import flat_name
from rsegen.robots.files.rigid import has_fixed_links, head_of, make_one
from rsegen.robots.files.sdf_elements import ENDS, NAMES_A_PART, numbers_text, put_pose, without_plugins
from rsegen.robots.files.sdf_shapes import ModelFrames, in_scope

_OF_LATER_VERSIONS = ("degrees", "rotation_format")
"""Attributes of poses that Gazebo Classic overlooks."""


def fit(
    model: Element, frames: ModelFrames, simulator: str, driven: Collection[str] = (), *, is_for_drive: bool = False
) -> None:
    """Write a model as a Gazebo reads it, led by the link on which all others hang.

    frames: of the model; driven: links that are wheels or tracks; if there are several bodies, the first of these links
    says which one leads; is_for_drive: whether only plug-ins of a drive name its parts. Then links on fixed joints may
    become one in Gazebo Classic, and driven links of nested models come into the model in Gazebo Sim.
    """
    body, first = _body(frames, driven), next((name for name, _ in frames.links()), "")
    is_rigid = is_for_drive and simulator == "classic" and has_fixed_links(frames, driven)
    if is_rigid or (simulator == "classic" and _is_overlooked(model)):
        _make_flat(model, frames)
    if is_rigid:
        make_one(model, ModelFrames(model, frames.where), driven)
    if is_for_drive and simulator != "classic" and any("::" in link for link in driven):
        _make_flat(model, frames)
        _rename(model, frames.where)
        body, first = flat_name(body), flat_name(first)
    _lead(model, body, first)


def _body(frames: ModelFrames, driven: Iterable[str]) -> str:
    """Return the link at the top, on which the first driven link hangs; without one, the top of the first link.

    An empty text if there are no links.
    """
    links = [name for name, _ in frames.links()]
    parents = ((link, frames.parent(joint)) for link, joint in frames.holders().items())
    body = next((link for link in driven if link in links), links[0] if links else "")
    return head_of(body, {link: parent for link, parent in parents if parent in links})


def _lead(model: Element, body: str, first: str) -> None:
    """Make a link canonical. first: the first one of all, also in nested models, which counts if the model has none."""
    own = {link.get("name", ""): link for link in model.findall("link")}
    first = next(iter(own), first)
    canonical = model.get("canonical_link") or first
    if canonical == body == first:
        return
    if model.get("canonical_link") is not None or body not in own:
        _make_canonical(model, body)
    if body in own and body != first:
        at = list(model).index(own[first])
        model.remove(own[body])
        model.insert(at, own[body])


def _make_canonical(model: Element, body: str) -> None:
    """Make a link canonical, also of the nested model that has it: else Gazebo Sim says that the robot falls."""
    model.set("canonical_link", body)
    scope, _, own = body.partition("::")
    for nested in model.findall("model") if own else ():
        if nested.get("name") == scope:
            _make_canonical(nested, own)


def _make_flat(model: Element, frames: ModelFrames) -> None:
    """Make a model one of links and joints alone, all poses in its frame, and all names as they are in it."""
    # All places and directions are read first: they are relative to frames and names that change below.
    places = {link: frames.transform(link) for link, _ in frames.links()}
    joints = {joint: frames.joint(joint) for joint in frames.joints}
    axes = [
        (axis, joints[joint][:3, :3].T @ frames.direction(joint, axis))
        for joint, element in frames.joints.items()
        for tag in ("axis", "axis2")
        for axis in element.findall(tag)
    ]
    for link, element in frames.links():
        _put_poses_in(element, link, places[link], frames)
    for joint, element in frames.joints.items():
        put_pose(element, np.linalg.inv(places.get(frames.child(joint), np.eye(4))) @ joints[joint])
        _name_ends(element, partial(_in_model, joint, frames=frames))
    for axis, direction in axes:
        _put_direction(axis, direction)
    # Then all elements are taken out, nested or not, and links, joints and plug-ins put back into the model itself.
    named = [*frames.links(), *frames.joints.items()]
    plugins = [plugin for name, nested in frames.elements.items() for plugin in _plugins_of(name, nested, frames)]
    for element in [*model.findall("frame"), *model.findall("model"), *model.findall("link"), *model.findall("joint")]:
        model.remove(element)
    for name, element in named:
        element.set("name", name)
    model.extend([*(element for _, element in named), *plugins])
    model.attrib.pop("canonical_link", None)


def _rename(model: Element, where: str) -> None:
    """Give the parts of a model that was made flat the names that Gazebo Sim takes; FileError if two have one."""
    parts = [*model.findall("link"), *model.findall("joint")]
    taken: dict[str, str] = {}
    for part in parts:
        name = part.get("name", "")
        flat = flat_name(name)
        if (first := taken.setdefault(flat, name)) != name:
            raise FileError(f"{where}: in a drive in Gazebo Sim {shown(first)} and {shown(name)} are both {flat}")
        part.set("name", flat)
    for joint in model.findall("joint"):
        _name_ends(joint, flat_name)
    for plugin in model.findall("plugin"):
        _name_parts(plugin, flat_name)


def _name_ends(joint: Element, named: Callable[[str], str]) -> None:
    """Name anew what a joint names: its links, and the joint that it follows."""
    for part in joint.iter():
        if part.tag in ENDS:
            part.text = named((part.text or "").strip())
        if part.tag == "mimic":
            part.set("joint", named(part.get("joint", "").strip()))


def _name_parts(plugin: Element, named: Callable[[str], str]) -> None:
    """Name anew the parts of a model that a plug-in of it names, in elements or attributes."""
    for part in plugin.iter():
        if NAMES_A_PART.search(part.tag):
            part.text = named((part.text or "").strip())
        for attribute, value in part.attrib.items():
            if NAMES_A_PART.search(attribute):
                part.set(attribute, named(value.strip()))


def _is_overlooked(model: Element) -> bool:
    """Return whether a model has nested ones, or poses as they came after SDF 1.7."""
    return model.find("model") is not None or any(
        pose.get(attribute) is not None for pose in model.iter("pose") for attribute in _OF_LATER_VERSIONS
    )


def _put_poses_in(link: Element, name: str, place: Array, frames: ModelFrames) -> None:
    """Give a link its pose in the model, and all that it has poses in the link."""
    for element in [part for part in without_plugins(link) if part is not link and part.find("pose") is not None]:
        pose = element.find("pose")
        is_relative = pose is not None and bool(pose.get("relative_to") or pose.get("frame"))
        put_pose(element, np.linalg.inv(place) @ frames.shape(name, element) if is_relative else frames.local(element))
    put_pose(link, place)


def _put_direction(axis: Element, direction: Array) -> None:
    """Give an axis its direction in the frame of its joint."""
    for tag in ("xyz", "use_parent_model_frame"):
        for element in axis.findall(tag):
            axis.remove(element)
    SubElement(axis, "xyz").text = numbers_text(direction)


def _plugins_of(name: str, nested: Element, frames: ModelFrames) -> list[Element]:
    """Return the plug-ins of a nested model, which name its links and joints as the whole model does."""
    plugins = nested.findall("plugin") if nested.tag == "model" else []
    for plugin in plugins:
        _name_parts(plugin, partial(_in_model, f"{name}::", frames=frames))
    return plugins


def _in_model(neighbour: str, name: str, frames: ModelFrames) -> str:
    """Return the name in the whole model of a link or joint in the nested model of another; any other name as it is."""
    scoped = in_scope(neighbour.rpartition("::")[0], name)
    return scoped if scoped in frames.elements or scoped in frames.joints else name
