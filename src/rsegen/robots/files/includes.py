"""Put included models into an SDF model, as Gazebo does, so that their links and joints are known.

<include> becomes a nested model with its name and pose, or, with merge, links and joints of the model itself. A pose of
a merged link is the product of that of the include and its own. A model is a folder with model.config, or a file: it is
found next to the file that includes it, as model://, file:// or a path (uris.py). Cost: linear in the files, of which
there are at most _MOST. What breaks it: addresses on the internet, such as those of Fuel, which are never fetched.
What is not found is left out, with the joints that hang on it, and named; but not what would be merged, such as the
chassis of a robot to which a file adds a sensor.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError, shown
from rsegen.input_files import regular_content
from rsegen.robots.files.sdf_elements import is_true, pose_text, put
from rsegen.robots.files.sdf_shapes import ModelFrames
from rsegen.robots.files.uris import found_uri, resolve_uris

_MOST = 100
"""Models that are included at most, those in others too; makers' models have up to some ten."""

NOT_INCLUDED = "put its folder next to that of the file, or into GZ_SIM_RESOURCE_PATH; rsegen fetches nothing itself"
"""Advice for a model that is not found."""

_LARGEST_CONFIG = 2**16
"""Bytes of model.config that are read; it has some hundreds."""

_CONFIGURED = re.compile(r"""<sdf(?:\s+version\s*=\s*["']1\.(\d{1,3})["'])?\s*>\s*([^<\s]+)\s*</sdf>""")
"""A file in model.config, with the version of SDF that it has."""

Read = Callable[[Path], Element]
"""Function that reads the <model> of an SDF file."""


class Includes:
    """Reads the models that are included; missing: the URIs that were not found, as they stand in the file."""

    def __init__(self, read: Read) -> None:
        self._read, self._left = read, _MOST
        self.missing: dict[str, None] = {}

    def put_into(self, model: Element, file: Path, above: tuple[Path, ...] = ()) -> None:
        """Replace every <include> of a model of a file; FileError if a model includes itself.

        above: the files that include this one
        """
        # Inner models first: a placement frame may be in what they include.
        for nested in model.findall("model"):
            self.put_into(nested, file, above)
            _place(nested, nested, str(file))
        lost: list[str] = []
        for include in model.findall("include"):
            at = list(model).index(include)
            model.remove(include)
            inner, is_merged = self._included(include, file, (*above, file)), include.get("merge", "") in ("1", "true")
            if inner is None and is_merged:
                uri = (include.findtext("uri") or "").strip()
                raise FileError(f"{file}: {uri}, of which it is a part, is not found: {NOT_INCLUDED}")
            if inner is None:
                lost.append((include.findtext("name") or "").strip() or _last(include))
            elif is_merged:
                for offset, element in enumerate(_merged(inner)):
                    model.insert(at + offset, element)
            else:
                model.insert(at, inner)
        if lost:
            _take_out_joints(model, lost)

    def _included(self, include: Element, file: Path, above: tuple[Path, ...]) -> Element | None:
        """Return the model of an <include> with its name and pose; None if it is not found."""
        uri = (include.findtext("uri") or "").strip()
        path = _sdf_file(found_uri(uri, file))
        if path is None:
            self.missing[uri] = None
            return None
        if path.absolute() in {including.absolute() for including in above}:
            raise FileError(f"{path}: includes itself")
        self._left -= 1
        if self._left < 0:
            raise FileError(f"{file}: more than {_MOST} models are included")
        inner = self._read(path)
        self.put_into(inner, path, above)
        resolve_uris(inner, path)
        if name := (include.findtext("name") or "").strip():
            inner.set("name", name)
        _place(inner, include, str(path))
        return inner


def _last(include: Element) -> str:
    """Return the last name in the URI of an <include>, which mostly is its model's."""
    return (include.findtext("uri") or "").strip().rstrip("/").rpartition("/")[2]


def _sdf_file(path: Path | None) -> Path | None:
    """Return the SDF file of a model, of several the one of the latest version; None for no model."""
    if path is None or path.is_file():
        return path
    config = (regular_content(path / "model.config", _LARGEST_CONFIG) or b"").decode("utf-8", "replace")
    files = _CONFIGURED.findall(config)
    names = [name for _, name in sorted(files, key=lambda version_and_name: -int(version_and_name[0] or 0))]
    candidates = [path / name for name in (*names, "model.sdf")]
    return next((file for file in candidates if file.is_file()), None)


def _place(model: Element, include: Element, where: str) -> None:
    """Give an included model the pose of its <include>, which is the pose of one of its frames if it names one."""
    pose, frame = include.find("pose"), (include.findtext("placement_frame") or "").strip()
    frame = frame or model.get("placement_frame", "").strip()
    if pose is None and not frame:
        return
    placed = Element("pose") if pose is None else pose
    if frame:
        frames = ModelFrames(model, where)
        if frame not in {*frames.elements, *frames.joints}:
            raise FileError(f"{where}: has no frame {shown(frame)} by which it is placed")
        # The pose is the frame's, so the model's own is the pose times the inverse of the frame in the model.
        outer = Element("model")
        outer.append(placed)
        moved = pose_text(frames.local(outer) @ np.linalg.inv(frames.transform(frame)))
        relative = placed.get("relative_to")
        placed = Element("pose", {} if relative is None else {"relative_to": relative})
        placed.text = moved
    for own in model.findall("pose"):
        model.remove(own)
    model.attrib.pop("placement_frame", None)
    model.insert(0, placed)


def _merged(model: Element) -> list[Element]:
    """Return the elements of a model with poses for the model that it is merged into."""
    frames, pose = ModelFrames(model, model.get("name", "")), model.find("pose")
    base, relative = frames.local(model), "" if pose is None else pose.get("relative_to", "")
    elements = [element for element in model if element.tag in ("link", "joint", "frame", "model", "plugin", "gripper")]
    for element in elements:
        # Only what is placed in the frame of its model moves with that; all else follows the frames that it names.
        own = element.find("pose")
        base_name = "" if own is None else own.get("relative_to", own.get("frame", ""))
        is_frame = element.tag == "frame" and element.get("attached_to", "") in _OF_MODEL
        if base_name not in _OF_MODEL or not (element.tag in ("link", "model") or is_frame or base_name):
            continue
        moved = pose_text(base @ frames.local(element))
        if own is not None:
            element.remove(own)
        placed = Element("pose", {"relative_to": relative or "__model__"} if relative or base_name else {})
        placed.text = moved
        element.insert(0, placed)
    return [*_own_frame(model, model.findall("joint"), pose), *elements]


_OF_MODEL = ("", "__model__")
"""Names of the frame of a model in it."""


def _own_frame(model: Element, joints: list[Element], pose: Element | None) -> list[Element]:
    """Return the frame that a merged model had, if its joints name it, and make them name that."""
    name = f"_merged__{model.get('name', '')}__model__"  # as libsdformat calls it
    axes = [axis for joint in joints for tag in ("axis", "axis2") for axis in joint.findall(tag)]
    for axis in [axis for axis in axes if is_true(axis.findtext("use_parent_model_frame"))]:
        for flag in axis.findall("use_parent_model_frame"):
            axis.remove(flag)
        put(axis, "xyz", axis.findtext("xyz") or "0 0 1")
        axis.findall("xyz")[0].set("expressed_in", "__model__")
    # After merging, __model__ would mean the outer model, so axes and ends of joints name the frame instead.
    directions = [xyz for axis in axes for xyz in axis.findall("xyz") if xyz.get("expressed_in") == "__model__"]
    ends = [end for joint in joints for end in joint if (end.text or "").strip() == "__model__"]
    for xyz in directions:
        xyz.set("expressed_in", name)
    for end in ends:
        end.text = name
    if not directions and not ends:
        return []
    first = model.find("link")
    link = model.get("canonical_link", "" if first is None else first.get("name", ""))
    frame = Element("frame", {"name": name, "attached_to": link})
    placed = Element("pose") if pose is None else deepcopy(pose)
    placed.set("relative_to", placed.get("relative_to") or "__model__")
    frame.append(placed)
    return [frame]


def _take_out_joints(model: Element, lost: list[str]) -> None:
    """Take out the joints of a model whose links are in models that are not there."""
    known = {child.get("name", "") for tag in ("link", "frame", "model", "joint") for child in model.findall(tag)}
    known = {"world", "__model__", *known}.difference(lost)
    for joint in model.findall("joint"):
        ends = ((joint.findtext(tag) or "").strip().partition("::")[0] for tag in ("parent", "child"))
        if not known.issuperset(ends):
            model.remove(joint)
