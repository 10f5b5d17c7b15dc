"""Places of the links, joints and frames of a model in an SDF file, its masses, and extents of its collision shapes.

Everything is expressed in the frame of the model. A pose may be relative to any other frame (SDF 1.7), so poses are
followed up to the model, at most _DEEPEST of them: a file from anybody may have a cycle. A shape's extent is an
axis-aligned box: a box swept by an ellipsoid covers SDF's shapes, and rotates in closed form; of a mesh all corners are
turned. A mass has to be positive, and no moment of inertia negative; moments that no body has are only reported, as
Gazebo Classic takes them.
Cost: the shapes times the depth of their frames; reading meshes costs most.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from functools import cached_property
from math import radians
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError, shown
from rsegen.field.stepfield import Array
from rsegen.geometry.poses import pose_matrix, rotation
from rsegen.robots.files.meshes import INLINE, SUFFIXES, bounds, mesh_corners
from rsegen.robots.files.sdf_elements import is_true, pose_in, unit_axis

_DEEPEST = 30
"""Frames that may be given relative to each other, one after another; models of robots have up to about ten."""

_LARGEST = 1e6
"""Largest number of a file, metres or radians: a larger one is a mistake, such as a length in another unit."""

_ROUNDED = 0.01
"""Share of the largest moment of inertia up to which the triangle inequality may be violated.

A thin plate's moments meet it exactly, ixx + iyy = izz, and files round them, some to two or three digits.
"""

_SWOLLEN = 10.0
"""Share of the largest moment of inertia that fits into a link's shapes from which on a file's is a mistake: what is
seen of a link may be somewhat larger than what touches."""

_NOISE = 1e-9
"""Share of the largest moment up to which a negative one is zero, such as a rod's after rounding in the eigenvalues."""


class ModelFrames:
    """The links, frames, nested models and joints of a model by name; in a nested model names are NESTED::NAME.

    A joint may have the name of a link in older files.
    FileError, which begins with `where`, if a pose is not numbers or is relative to itself.
    """

    def __init__(self, model: Element, where: str) -> None:
        self.where, self._model = where, model
        elements = list(named(model))
        self.elements = {name: element for name, element in elements if element.tag != "joint"}
        self.joints = {name: element for name, element in elements if element.tag == "joint"}

    @cached_property
    def shapes(self) -> Extents:
        """The extents of the collision shapes of every link."""
        return extents(self)

    def transform(self, name: str, depth: int = 0) -> Array:
        """Return the pose of a frame in the model's, (4, 4); the model's own for a name that is none."""
        if depth > _DEEPEST:
            raise FileError(f"{self.where}: the pose of {shown(name)} is relative to itself")
        name = name.removesuffix("::__model__")
        element = self.elements.get(name, self.joints.get(name))
        return np.eye(4) if element is None else self._placed(name, element, depth)

    def joint(self, name: str) -> Array:
        """Return the pose of a joint in the model's frame, (4, 4)."""
        return self._placed(name, self.joints[name])

    def child(self, joint: str) -> str:
        """Return the link that a joint turns."""
        return self._link(joint, "child")

    def parent(self, joint: str) -> str:
        """Return the link that a joint hangs on."""
        return self._link(joint, "parent")

    def holders(self) -> dict[str, str]:
        """Return the joint on which each link hangs, by the links."""
        return {self.child(name): name for name in self.joints}

    def _link(self, joint: str, tag: str) -> str:
        return in_scope(joint.rpartition("::")[0], (self.joints[joint].findtext(tag) or "").strip())

    def attached(self, name: str) -> str:
        """Return the link that a frame, a joint or a nested model is attached to; of a link, or nothing, its name."""
        # One step per turn: from a joint to its child, from a model to its canonical link, from a frame to its base.
        for _ in range(_DEEPEST):
            scope, _, own = name.rpartition("::")
            element = self.elements.get(name)
            if name in self.joints and element is None:
                name = self.child(name)
            elif own == "__model__" or (element is not None and element.tag == "model"):
                name = self._canonical(scope if own == "__model__" else name)
            elif element is not None and element.tag == "frame":
                name = in_scope(scope, element.get("attached_to", "") or "__model__")
            else:
                return name
        raise FileError(f"{self.where}: {shown(name)} is attached to itself")

    def _canonical(self, scope: str) -> str:
        """Return the canonical link of the model, or of a nested one: by default its first."""
        model = self.elements[scope] if scope else self._model
        first = next((name for name, _ in self.links() if name.startswith(f"{scope}::" if scope else "")), "")
        own = model.get("canonical_link", "")
        return in_scope(scope, own) if own else first

    def links(self) -> Iterator[tuple[str, Element]]:
        """Yield the links with their names."""
        return ((name, element) for name, element in self.elements.items() if element.tag == "link")

    def collisions(self) -> Iterator[tuple[str, Element, Element]]:
        """Yield the collision shapes that have an end, with the names of their links, and their geometries."""
        for link, element in self.links():
            yield from ((link, *shape) for shape in geometries(element, "collision"))

    def _placed(self, name: str, element: Element, depth: int = 0) -> Array:
        """Return the pose of an element in the model's frame, (4, 4); of a shape, `name` is its link's."""
        scope, _, own = name.rpartition("::")
        pose = element.find("pose")
        base_name = "" if pose is None else pose.get("relative_to", pose.get("frame", ""))
        if not base_name:  # a joint is relative to its child, a frame to what it is attached to, a shape to its link
            child, attached = (element.findtext("child") or "").strip(), element.get("attached_to", "")
            base_name = {"joint": child, "frame": attached, "collision": own, "visual": own}.get(element.tag, "")
        base = scope if base_name in ("", "__model__") else in_scope(scope, base_name)
        return self.transform(base, depth + 1) @ self.local(element)

    def local(self, element: Element) -> Array:
        """Return the <pose> of an element as it stands, (4, 4)."""
        pose = element.find("pose")
        if pose is None:
            return np.eye(4)
        name = f" {shown(element.get('name'))}" if element.get("name") else ""
        return matrix_of(pose, f"{self.where}: the <pose> of {element.tag}{name}")

    def shape(self, link: str, shape: Element) -> Array:
        """Return the pose of a collision or visual of a link in the model's frame, (4, 4)."""
        return self._placed(link, shape)

    def axis(self, joint: str) -> Array:
        """Return the direction of a joint's axis in the model's frame, (3,)."""
        return self.direction(joint, self.joints[joint].find("axis"))

    def direction(self, joint: str, axis: Element | None) -> Array:
        """Return the direction of one of a joint's axes in the model's frame, (3,); its z for none."""
        axis = Element("axis") if axis is None else axis
        direction, scope = axis.find("xyz"), joint.rpartition("::")[0]
        xyz = [0.0, 0.0, 1.0] if direction is None else floats(direction.text, 3, self.where)
        # By default an axis is in the frame of its joint; a flag of SDF 1.5 and 1.6 puts it into the model's.
        frame = "" if direction is None else direction.get("expressed_in", "")
        if is_true(axis.findtext("use_parent_model_frame")):
            frame = "__model__"
        turned = self.transform(in_scope(scope, frame)) if frame else self.joint(joint)
        return np.asarray(turned[:3, :3] @ unit_axis(xyz, f"{self.where}: joint {shown(joint)}"))


def named(model: Element, scope: str = "") -> Iterator[tuple[str, Element]]:
    """Yield the links, joints, frames and nested models of a model, with their names in it."""
    for element in model:
        if element.tag in ("link", "joint", "frame", "model"):
            yield f"{scope}{element.get('name', '')}", element
        if element.tag == "model":
            yield from named(element, f"{scope}{element.get('name', '')}::")


def geometries(link: Element, tag: str) -> Iterator[tuple[Element, Element]]:
    """Yield the collision shapes, or visuals, of a link that have an end, and their geometries."""
    for shape in link.findall(tag):
        geometry = shape.find("geometry")
        if geometry is not None and len(geometry) and geometry[0].tag not in ("empty", "plane"):
            yield shape, geometry


def hang_on_links(frames: ModelFrames) -> None:
    """Make joints whose ends are frames, or nested models, hang on the links to which these are attached."""
    for name, joint in frames.joints.items():
        scope = name.rpartition("::")[0]
        for end in (element for tag in ("parent", "child") for element in joint.findall(tag)):
            own = (end.text or "").strip()
            link = frames.attached(in_scope(scope, own)).removeprefix(f"{scope}::" if scope else "")
            if link == own:
                continue
            if end.tag == "child":  # in whose frame the joint is, so its pose has to name that frame from now on
                pose = pose_in(joint)
                if not pose.get("relative_to", pose.get("frame", "")):
                    pose.set("relative_to", own)
            end.text = link


def floats(text: str | None, count: int, where: str) -> list[float]:
    """Return `count` numbers of a text, none beyond a million; FileError if it has others."""
    try:
        values = [float(word) for word in (text or "").split()]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) <= _LARGEST for value in values):
        expected = "a number" if count == 1 else f"{count} numbers"
        raise FileError(f"{where}: {shown((text or '').strip())} is not {expected} within a million")
    return values


def positive_number(element: Element, where: str, *paths: str) -> float | None:
    """Return the number in the first of these elements that exists; None without one, or if it is not positive."""
    text = next((text for path in paths if (text := element.findtext(path))), None)
    try:
        value = floats(text, 1, where)[0]
    except FileError:
        return None
    return value if value > 0 else None


def in_scope(scope: str, name: str) -> str:
    """Return the name in the model of what has a name in a nested model, its scope; empty for the model itself."""
    return f"{scope}::{name}" if scope else name


def matrix_of(pose: Element, where: str) -> Array:
    """Return the transform, (4, 4), of a <pose> in the frame that it is in; FileError if it has none."""
    if pose.get("rotation_format") == "quat_xyzw":
        *place, x, y, z, w = floats(pose.text, 7, where)
        turn = _of_quaternion(x, y, z, w, where)
    else:
        text = pose.text if (pose.text or "").strip() else "0 0 0 0 0 0"
        *place, roll, pitch, yaw = floats(text, 6, where)
        if is_true(pose.get("degrees")):
            roll, pitch, yaw = map(radians, (roll, pitch, yaw))
        turn = rotation(roll, pitch, yaw)
    return pose_matrix(place, turn)


def _of_quaternion(x: float, y: float, z: float, w: float, where: str) -> Array:
    length = float(np.linalg.norm([x, y, z, w]))
    if not length:
        raise FileError(f"{where}: the quaternion 0 0 0 0 is no rotation")
    x, y, z, w = (part / length for part in (x, y, z, w))
    return np.array(  # the rotation matrix of a unit quaternion
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


class Inertial(NamedTuple):
    """The mass of a link, kg, and its centre, (3,), in the model's frame, metres."""

    mass: float
    centre: Array


def inertials(frames: ModelFrames) -> dict[str, Inertial]:
    """Return the inertial of every link of a model: by SDF's default 1 kg at the origin of the link.

    FileError for a mass that is not positive, and a moment of inertia that is negative.
    """
    by_link = {}
    for link, element in frames.links():
        mass, place, inertial = 1.0, frames.transform(link), element.find("inertial")
        if inertial is not None:
            where = f"{frames.where}: link {shown(link)}"
            (mass,) = floats(inertial.findtext("mass", "1"), 1, where)
            refuse_mass(mass, where)
            refuse_moments(inertia_tensor(link, element, frames), where)
            place = place @ frames.local(inertial)
        by_link[link] = Inertial(mass, place[:3, 3])
    return by_link


def impossible_inertias(frames: ModelFrames) -> list[str]:
    """Return the links whose moments of inertia no body has: the largest exceeds the sum of the others."""
    return [link for link, element in frames.links() if is_impossible(inertia_tensor(link, element, frames))]


def links_by_default(frames: ModelFrames) -> list[str]:
    """Return the links without a mass, of which SDF, and so every simulator, takes 1 kg and 1 kg m^2 each."""
    return [link for link, element in frames.links() if element.find("inertial/mass") is None]


def swollen_inertias(frames: ModelFrames, but: Collection[str]) -> list[str]:
    """Return the links whose moments of inertia are far beyond what fits into their shapes, without some of them.

    A body within half a diagonal R of its centre has at most m R^2. Files have thousands of times that, by a mistake in
    units or by a default, and such a robot takes seconds to tip by a degree.
    """
    masses, shapes, swollen = inertials(frames), frames.shapes, []
    left_out = {*but, *links_by_default(frames)}
    for link, element in frames.links():
        extent = shapes.of(link)
        if extent is not None and link not in left_out:
            size, largest = extent.high - extent.low, np.linalg.eigvalsh(inertia_tensor(link, element, frames))[2]
            if largest > _SWOLLEN * masses[link].mass * (size @ size) / 4:
                swollen.append(link)
    return swollen


def is_impossible(tensor: Array) -> bool:
    """Return whether no body has this tensor of inertia, (3, 3), by more than the rounding of its numbers."""
    a, b, largest = np.linalg.eigvalsh(tensor)
    return bool(largest - (a + b) > _ROUNDED * largest)


def refuse_mass(mass: float, where: str) -> None:
    """Raise a FileError for a mass that is not positive."""
    if not mass > 0:
        raise FileError(f"{where}: a mass of {mass:g} kg is not above 0")


def refuse_moments(tensor: Array, where: str) -> None:
    """Raise a FileError for a tensor of inertia, (3, 3), with a negative moment."""
    moments = np.linalg.eigvalsh(tensor)
    if moments[0] < -_NOISE * moments[2]:
        raise FileError(f"{where}: a principal moment of inertia of {moments[0]:g} kg m^2 is negative")


def tensor_of(values: Sequence[float]) -> Array:
    """Return the tensor of inertia, (3, 3), of ixx, ixy, ixz, iyy, iyz and izz."""
    xx, xy, xz, yy, yz, zz = values
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def inertia_tensor(link: str, element: Element, frames: ModelFrames) -> Array:
    """Return the tensor of inertia, (3, 3), kg m^2, of a link in the frame of its <inertial>; by default the unit."""
    where = f"{frames.where}: link {shown(link)}"
    defaults = {"ixx": "1", "ixy": "0", "ixz": "0", "iyy": "1", "iyz": "0", "izz": "1"}
    texts = (element.findtext(f"inertial/inertia/{name}", default) for name, default in defaults.items())
    return tensor_of([floats(text, 1, where)[0] for text in texts])


class Extent(NamedTuple):
    """The axis-aligned box of collision shapes, in the model's frame: low and high, (3,), metres."""

    low: Array
    high: Array


class Extents(NamedTuple):
    """Boxes of the collision shapes whose size is known, by link; `unknown`: links with a shape of unknown size.

    whole: the box of all shapes of known size, None without any
    """

    known: Mapping[str, Extent]
    unknown: Collection[str]
    whole: Extent | None

    def of(self, link: str) -> Extent | None:
        """Return the box of all shapes of one link; None without shapes, or if the size of one is unknown."""
        return None if link in self.unknown else self.known.get(link)


class SweptBox(NamedTuple):
    """A box of half sides, swept by an ellipsoid of these radii, around a centre; metres."""

    half: tuple[float, float, float]
    radii: tuple[float, float, float] = (0, 0, 0)
    centre: tuple[float, float, float] = (0, 0, 0)


def extents(frames: ModelFrames) -> Extents:
    """Return the extents of the collision shapes of every link of a model."""
    known: dict[str, Extent] = {}
    unknown = set()
    solids: dict[Hashable, SweptBox | Array | None] = {}
    for link, collision, geometry in frames.collisions():
        if geometry[0].find("submesh") is not None:
            part = f"link {shown(link)}: collision shape {shown(collision.get('name', ''))}"
            problem = "is a <submesh>, which is not read; write it into a file of its own"
            raise FileError(f"{frames.where}: {part} {problem}")
        key = form_of(geometry)
        solid = solids[key] = solids[key] if key in solids else _solid(geometry, frames.where)  # a file is read once
        if solid is None:
            unknown.add(link)
            continue
        low, high = _placed(solid, frames.shape(link, collision))
        box = known.get(link, Extent(low, high))
        known[link] = Extent(np.minimum(box.low, low), np.maximum(box.high, high))
    lows, highs = [box.low for box in known.values()], [box.high for box in known.values()]
    return Extents(known, unknown, Extent(np.min(lows, axis=0), np.max(highs, axis=0)) if known else None)


def _placed(solid: SweptBox | Array, pose: Array) -> Extent:
    """Return the extent of a solid at a pose, (4, 4)."""
    turn, place = pose[:3, :3], pose[:3, 3]
    if not isinstance(solid, SweptBox):
        reached = [solid @ axis for axis in turn]  # a fifth of the time of all axes at once
        return Extent(
            place + [float(along.min()) for along in reached], place + [float(along.max()) for along in reached]
        )
    # Half the extent of a rotated box is |R| half, that of a rotated ellipsoid sqrt(R^2 radii^2).
    half = np.abs(turn) @ solid.half + np.sqrt((turn**2) @ np.square(solid.radii))
    middle = turn @ solid.centre + place
    return Extent(middle - half, middle + half)


def form_of(geometry: Element) -> Hashable:
    """Return what the surface of a geometry depends on: equal for shapes of one file, which then is read once."""
    return tuple((part.tag, part.text) for part in geometry.iter())


_SIZES = {"box": "size", "ellipsoid": "radii", "sphere": "radius", "cylinder": "radius length", "cone": "radius length"}
"""Elements of a shape whose numbers are above 0; the cylinder of a capsule may have no length."""


def take_out_flat(model: Element, where: str) -> list[str]:
    """Take the collision shapes out of a model that have no size, which simulators load, and return their names.

    Visuals too. FileError for a size below 0.
    """
    flat = []
    for link in model.iter("link"):
        for shape in [*link.findall("collision"), *link.findall("visual")]:
            kind = next(iter(shape.iterfind("geometry/*")), None)
            if kind is None or not _is_flat(kind, f"{where}: link {shown(link.get('name', ''))}: a <{shape.tag}>"):
                continue
            link.remove(shape)
            flat += [f"{link.get('name', '')}::{shape.get('name', '')}"] if shape.tag == "collision" else []
    return flat


def _is_flat(kind: Element, where: str) -> bool:
    tags = _SIZES.get(kind.tag, "radius" if kind.tag == "capsule" else "").split()
    sizes = [(tag, value) for tag in tags for value in floats(kind.findtext(tag), _COUNTS.get(tag, 1), where)]
    for tag, value in sizes:
        if value < 0:
            raise FileError(f"{where}: the {tag} {value:g} m of its {kind.tag} is below 0")
    return any(value == 0 for _, value in sizes)


_COUNTS = {"size": 3, "radii": 3}
"""Numbers of a size; of the others one."""


ROUND = ("sphere", "cylinder", "capsule", "cone")
"""Shapes that have a radius, and a length along z; a sphere has none."""


def radius_and_length(kind: Element, where: str) -> tuple[float, float]:
    """Return the radius and the length of a round shape, metres; a sphere has the length 0."""
    (radius,) = floats(kind.findtext("radius"), 1, where)
    return radius, 0.0 if kind.tag == "sphere" else floats(kind.findtext("length"), 1, where)[0]


def swept_box(geometry: Element, where: str) -> SweptBox | None:
    """Return the swept box of a geometry, of a mesh the box around it; None for an unknown one."""
    solid = _solid(geometry, where)
    if solid is None or isinstance(solid, SweptBox):
        return solid
    low, high = bounds(solid)
    half, centre = np.abs(high - low) / 2, (low + high) / 2
    return SweptBox(tuple(half.tolist()), centre=tuple(centre.tolist()))


def _solid(geometry: Element, where: str) -> SweptBox | Array | None:
    """Return the swept box of a geometry, or the corners of a mesh, (n, 3); None for an unknown one."""
    kind = geometry[0]
    if kind.tag == "box":
        x, y, z = (side / 2 for side in floats(kind.findtext("size"), 3, where))
        return SweptBox((x, y, z))
    if kind.tag == "ellipsoid":
        x, y, z = floats(kind.findtext("radii"), 3, where)
        return SweptBox((0, 0, 0), (x, y, z))
    if kind.tag in ROUND:
        r, length = radius_and_length(kind, where)
        return SweptBox((0, 0, length / 2), (r, r, 0 if kind.tag in ("cylinder", "cone") else r))
    return _corners(kind, where) if kind.tag == "mesh" else None


def _corners(mesh: Element, where: str) -> Array | None:
    """Return the corners of a mesh in a file, (n, 3); None for one that cannot be read here."""
    path, scale = file_and_scale(mesh, where)
    if path.suffix.lower() not in SUFFIXES and not str(path).startswith(INLINE):
        return None
    try:
        return mesh_corners(path) * scale
    except ImportError:
        return None


def file_and_scale(mesh: Element, where: str) -> tuple[Path, Array]:
    """Return the path of the file of a <mesh>, and its scale along x, y and z."""
    scale = np.array(floats(mesh.findtext("scale") or "1 1 1", 3, where))
    return Path((mesh.findtext("uri") or "").strip().removeprefix("file://")), scale
