"""Names and types in a model of SDF that Gazebo refuses, and the joints that hold a model in the world.

A joint of a missing link, a pose relative to a missing frame, or an unknown type would else be read as another robot,
without a word. What breaks it: names in a model of which parts are left out, as they are not found.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

from rsegen.errors import FileError, shown
from rsegen.robots.files.sdf_elements import is_true, without_plugins
from rsegen.robots.files.sdf_shapes import ModelFrames, in_scope

_TYPES = ("revolute", "continuous", "revolute2", "prismatic", "fixed", "ball", "universal", "screw", "gearbox")
"""Types of joints in SDF."""

_REFERENCES = ("relative_to", "attached_to", "expressed_in")
"""Attributes that name a frame."""

_EVERYWHERE = ("", "world", "__model__")
"""Names of frames that each model has."""


def spell_types(model: Element) -> None:
    """Write the types of joints in small letters; Gazebo Sim reads them in any."""
    for joint in model.iter("joint"):
        joint.set("type", joint.get("type", "").lower())


def refuse_unknown(frames: ModelFrames, *, is_whole: bool) -> None:
    """Raise a FileError for a joint of an unknown type, or a name of a link or frame that a model has not.

    is_whole: whether all that it includes was found
    """
    known = {*frames.elements, *frames.joints, *_EVERYWHERE}
    for name, joint in frames.joints.items():
        kind = joint.get("type", "")
        if kind not in _TYPES:
            raise FileError(
                f"{frames.where}: joint {shown(name)}: its type {shown(kind)} is none of {', '.join(_TYPES)}"
            )
        scope = name.rpartition("::")[0]
        for tag in ("parent", "child"):
            own = (joint.findtext(tag) or "").strip()
            # The world is in no nested model, so a name counts without its scope too.
            if not own or not {own, _frame(scope, own)} & known:
                problem = f"there is no link {shown(own)}" if own else f"it has no <{tag}>"
                raise FileError(f"{frames.where}: joint {shown(name)}: {problem}")
    for name, attribute, frame in _references(frames) if is_whole else ():
        scope = name.rpartition("::")[0]
        if frame not in _EVERYWHERE and _frame(scope, frame) not in known:
            raise FileError(
                f"{frames.where}: {attribute}={shown(frame)} at {shown(name)}: there is no such link, frame or joint"
            )


def _references(frames: ModelFrames) -> Iterator[tuple[str, str, str]]:
    """Yield the links, frames, models and joints that name a frame, or whose parts do, the attribute and the frame."""
    for name, element in (*frames.elements.items(), *frames.joints.items()):
        parts = [element, *element.findall("pose")] if element.tag == "model" else without_plugins(element)
        for part in parts:
            yield from ((name, attribute, part.get(attribute, "")) for attribute in _REFERENCES)


def _frame(scope: str, name: str) -> str:
    """Return the name of a frame in the whole model; the __model__ of a nested model is called as that model."""
    return in_scope(scope, name).removesuffix("::__model__")


def ties_to_world(model: Element) -> list[str]:
    """Return what holds a model, or a nested one, in the world: "<static>", and joints by name."""
    is_static = any(is_true(static.text) for _, static in _statics(model))
    pins = (f"joint {joint.get('name')}" for _, joint in _to_the_world(model))
    return [*(["<static>"] if is_static else []), *pins]


def let_go(model: Element) -> None:
    """Take out of a model what holds it in the world, as a robot that drives moves freely.

    A frame stays where a joint was, if its name is used: poses may be relative to the joint.
    """
    for holder, static in _statics(model):
        holder.remove(static)
    for holder, joint in _to_the_world(model):
        name, child = joint.get("name", ""), (joint.findtext("child") or "").strip()
        at = list(holder).index(joint)
        holder.remove(joint)
        if name in _used(model):
            frame = Element("frame", {"name": name} | ({"attached_to": child} if child != "world" else {}))
            frame.extend(joint.findall("pose"))
            holder.insert(at, frame)


def _statics(model: Element) -> list[tuple[Element, Element]]:
    """Return the elements that hold models in the world, each after the model that has it."""
    return [(holder, static) for holder in model.iter("model") for static in holder.findall("static")]


def _to_the_world(model: Element) -> list[tuple[Element, Element]]:
    """Return the joints that hang on the world, or hold it, each after the model that has it."""
    return [
        (holder, joint)
        for holder in model.iter("model")
        for joint in holder.findall("joint")
        if "world" in [(joint.findtext(tag) or "").strip() for tag in ("parent", "child")]
    ]


def _used(model: Element) -> set[str]:
    """Return the last parts of all names of frames that a model refers to."""
    return {part.get(name, "").rpartition("::")[2] for part in model.iter() for name in (*_REFERENCES, "frame")}
