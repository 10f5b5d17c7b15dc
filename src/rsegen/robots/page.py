"""A robot on a map, as pages show it: its shapes, its pose at a place, its tilts, its reach and its ways.

    document, index --> StepField --> PaddedGround of a robot's Body --> poses, reach, ways (rsegen.standing)

A page asks with every move of the mouse, so lattices are kept with their document, as drawn maps are. A request that
takes seconds runs alone for its document, and of several that wait only the newest is answered.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from math import ceil, degrees, isfinite
from typing import Literal, TypedDict
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.driving.routes import followed
from rsegen.errors import FileError, ParameterError, UserError, line_of
from rsegen.field.stepfield import Array, StepField
from rsegen.geometry.poses import pose_matrix, rotation
from rsegen.measuring.catalogue import METRICS, UNITS, custom, flattened, metrics, nested
from rsegen.page.calls import call_of_host
from rsegen.page.forms import metric_title
from rsegen.page.host import Host, Opened, Search
from rsegen.page.scenes import cached, scene_of_map
from rsegen.page.shown_map import base64_of, hex_colour
from rsegen.recipe.recipe import Recipe
from rsegen.robots.base import Robot, link_poses
from rsegen.robots.files.sdf_file import SdfRobot
from rsegen.robots.files.sdf_shapes import ModelFrames, swept_box
from rsegen.robots.links import DARK, GREY, Box, Cylinder, Sphere, posed
from rsegen.robots.lookup import DrivableRobot, robot_of
from rsegen.robots.visuals import colour_of
from rsegen.scene.colours import Colour
from rsegen.scene.scene import Scene
from rsegen.standing.body import Body
from rsegen.standing.draping import draped
from rsegen.standing.drawing import hull
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lattice import Lattice
from rsegen.standing.outlines import Spot
from rsegen.standing.planner import Planner
from rsegen.standing.reach import reach as reached
from rsegen.standing.resting import REASONS, has_stood, of_settled
from rsegen.standing.settling import centre_at, outer_radius, settle
from rsegen.standing.spots import find_spots, spot_generator
from rsegen.standing.stable import stable_at
from rsegen.standing.ways import Way as LatticeWay

_FAR = 1000.0
"""Metres from the origin up to which a place is looked at."""


def _map(host: Host, doc: str, index: int) -> tuple[Opened, Recipe, StepField]:
    """Return a document, its recipe (the last valid one while a draft is invalid), and the field of a map."""
    opened = host.opened(doc)
    return opened, opened.session.recipe, scene_of_document(host, doc, index).field


def scene_of_document(host: Host, doc: str, index: int) -> Scene:
    """Return the scene of a map of a document; while a draft is invalid, the last valid recipe makes it."""
    opened = host.opened(doc)
    return scene_of_map(opened, opened.session.recipe, opened.index_of("", index))


def robot_of_page(host: Host, robot: str) -> DrivableRobot:
    """Return a robot by its kind, or of a file in the folder of pages."""
    return robot_of(host.places.refuse_outside("robot", robot), "robot")


@call_of_host
def stop(host: Host, *, doc: str, of: Search) -> None:
    """Stop a search that is done for a page of a document."""
    host.opened(doc).stop_search(of)


class DrawnPart(TypedDict):
    """A part of a robot as it is drawn."""

    shape: Literal["box", "cylinder", "sphere"]
    size: list[float]  # box x y z; cylinder radius, length along z; sphere radius
    pose: list[float]  # 4x4, row by row, in the robot's frame
    colour: str
    wheel: bool


class RobotShapes(TypedDict):
    """A robot as it is drawn."""

    name: str
    title: str
    size: tuple[float, float, float]
    lift: float  # of the origin of its model in a simulator, above the origin of these parts
    parts: list[DrawnPart]


@call_of_host
def robot(host: Host, *, robot: str) -> RobotShapes:
    """Return a robot as it is drawn: the parts of its links; for a robot of a file, its visuals."""
    known = robot_of_page(host, robot)
    if isinstance(known, SdfRobot):
        title, lift, parts = known.kind, known.lift, iter(_parts_of_file(known))
    else:
        driven = {part.name.partition("::")[0] for part in known.body_or_box.parts if part.drives}
        title, lift, parts = known.title, known.lift, _parts_of_links(known, driven)
    return {"name": robot, "title": title, "size": known.size, "lift": lift, "parts": list(parts)}


def _parts_of_links(robot: Robot, driven: set[str]) -> Iterator[DrawnPart]:
    poses = link_poses(robot)  # flippers as they are held, as in all poses that a page shows
    for link in robot.links:
        for part in link.parts:
            shape: _Shape
            match part.solid:
                case Box(size=size):
                    shape, lengths = "box", list(size)
                case Cylinder(radius=radius, length=length):
                    shape, lengths = "cylinder", [radius, length]
                case Sphere(radius=radius):
                    shape, lengths = "sphere", [radius]
            pose = poses[link.name] @ posed(part.pose)
            yield _part(shape, lengths, pose, part.colour, wheel=link.name in driven)


def _part(shape: _Shape, size: list[float], pose: Array, colour: Colour | None, *, wheel: bool) -> DrawnPart:
    """Return a part as it is drawn; without a colour of its own, what drives is dark, and all else grey."""
    drawn = hex_colour(colour or (DARK if wheel else GREY))
    return {"shape": shape, "size": size, "pose": pose.ravel().tolist(), "colour": drawn, "wheel": wheel}


def _parts_of_file(robot: SdfRobot) -> list[DrawnPart]:
    """Return the visuals of a robot of a file: boxes, cylinders and spheres as they are, others as boxes around them.

    A link that has no visuals, or one that cannot be read, has the boxes around its collision shapes.
    """
    frames, body = robot.frames(), robot.body_or_box
    driven = {part.name.rpartition("::")[0] for part in body.parts if part.drives}
    parts: list[DrawnPart] = []
    for link, element in frames.elements.items():
        if element.tag != "link":
            continue
        try:
            visuals = [_visual(frames, link, visual) for visual in element.findall("visual")]
        except UserError:  # such as a mesh that is not here
            visuals = []
        for shape, size, pose, colour in visuals:
            pose[2, 3] += robot.lift  # a body has its origin on the ground, the model `lift` above it
            parts.append(_part(shape, size, pose, colour, wheel=link in driven))
        parts += () if visuals else _boxes(body, link)
    return parts or list(_boxes(body))


_Shape = Literal["box", "cylinder", "sphere"]

_Visual = tuple[_Shape, list[float], Array, Colour | None]
"""A shape, its size, its pose in the model, and its colour, None if it has none."""


def _visual(frames: ModelFrames, link: str, visual: Element) -> _Visual:
    """Return a visual of a link; a FileError for one of an unknown size."""
    geometry = visual.find("geometry")
    solid = swept_box(geometry, frames.where) if geometry is not None and len(geometry) else None
    if geometry is None or solid is None:
        raise FileError(f"{frames.where}: a visual of {link} is of an unknown size")
    # The box around the solid; a cylinder and a sphere are drawn as such, by half of its length and its height.
    pose, half = frames.shape(link, visual), np.add(solid.half, solid.radii)
    pose[:3, 3] += pose[:3, :3] @ solid.centre
    x, y, z = (2 * half).tolist()
    sizes: dict[_Shape, list[float]] = {"cylinder": [x / 2, z], "sphere": [x / 2]}
    shape: _Shape = next((kind for kind in sizes if kind == geometry[0].tag), "box")
    return shape, sizes.get(shape, [x, y, z]), pose, colour_of(visual, frames.where)


def _boxes(body: Body, link: str | None = None) -> Iterator[DrawnPart]:
    """Yield the boxes around the parts of a body, or only around the parts of one link."""
    for part, surface in zip(body.parts, body.by_part(body.surface), strict=True):
        if link not in (None, part.name.rpartition("::")[0]) or not len(surface):
            continue
        pose = pose_matrix((surface.min(axis=0) + surface.max(axis=0)) / 2)
        yield _part("box", np.ptp(surface, axis=0).tolist(), pose, None, wheel=part.drives)


def _refuse_unplaced(**coordinates: float) -> None:
    for name, value in coordinates.items():
        if not abs(value) <= _FAR:  # nor if it is not a number
            raise ParameterError(name, f"{value} is no place near the map")


class DrawnPose(TypedDict):
    """A robot at rest; one that does not stand is level, where it was put."""

    stands: bool
    holds: bool
    pushes: bool
    reason: str  # "" or why it is bad: "tips over", "slips", "cannot drive on", "hangs up"
    x: float
    y: float
    z: float
    roll: float
    pitch: float
    yaw: float
    tilt: float
    centre: tuple[float, float, float]  # of mass
    margin: float  # angle to tip over
    clearance: float | None
    contacts: list[tuple[float, float, float]]
    stable: int  # poses in which it may rest here, of which this is one
    polygon: list[tuple[float, float, float]]  # support polygon, in order


@call_of_host
def pose(  # noqa: PLR0913  # each is named by the page
    host: Host, *, doc: str, index: int, robot: str, x: float, y: float, heading: float
) -> DrawnPose:
    """Return how a robot rests that is put down level at x, y with a heading; also next to the map.

    One that does not stand is where it was put: level, on the highest block below it.
    """
    _refuse_unplaced(x=x, y=y, heading=heading)
    *_, field = _map(host, doc, index)
    body = robot_of_page(host, robot).body
    ground = PaddedGround.of(field, outer_radius(body))
    # All stable poses are only counted; the robot is drawn in the one that it takes if it is put down level.
    at_x, at_y, yaw = (np.array([value]) for value in (x, y, heading))
    stable = stable_at(ground, body, *centre_at(body, at_x, at_y, yaw), yaw)
    rest = of_settled(ground, body, stable.level)
    stands, clearance = bool(rest.stands[0]), float(rest.clearance[0])
    names = ("x", "y", "z", "roll", "pitch", "yaw", "tilt")
    if stands:
        at = {name: float(getattr(rest, name)[0]) for name in names}
    else:  # held level, so high that it touches the highest block below it
        c, s = np.cos(heading), np.sin(heading)
        along, across, up = body.points.T
        below = ground.below(x + c * along - s * across, y + s * along + c * across)
        at = dict(zip(names, (x, y, float((below - up).max()), 0.0, 0.0, heading, 0.0), strict=True))
    # Unused corners of the support polygon are NaN.
    turn = rotation(at["roll"], at["pitch"], at["yaw"])
    corners = rest.support[0][np.isfinite(rest.support[0]).all(axis=1)] if stands else np.empty((0, 3))
    # The corners of the hull of the contacts as they are seen from above, counterclockwise.
    polygon = [corners[np.hypot(*(corners[:, :2] - at_corner).T).argmin()] for at_corner in hull(corners[:, :2])]
    return {
        "stands": stands,
        "holds": bool(rest.holds[0]),
        "pushes": bool(rest.pushes[0]),
        "reason": REASONS[int(rest.reason[0])],
        "x": at["x"],
        "y": at["y"],
        "z": at["z"],
        "roll": at["roll"],
        "pitch": at["pitch"],
        "yaw": at["yaw"],
        "tilt": at["tilt"],
        "centre": (np.array([at["x"], at["y"], at["z"]]) + turn @ body.centre).tolist(),
        "margin": float(rest.tip_angle[0]),
        "clearance": clearance if isfinite(clearance) else None,
        "contacts": rest.contacts[0].tolist() if stands else [],
        "stable": int(stable.counts[0]),
        "polygon": [corner.tolist() for corner in polygon],
    }


_PER_BLOCK, _MOST = 3, 5000
"""Poses along the side of a block, and on a map at most: a page waits two seconds for them."""

_AT_ONCE = 500
"""Poses between two looks whether they are still wanted: a fifth of a second, and no slower than all at once."""


class PoseMap(TypedDict):
    """Poses of a robot at rest on a regular grid of nx x ny points, x first."""

    shape: tuple[int, int]
    low: tuple[float, float]
    step: float  # of points, metres
    tilt: str  # base64 of float32, NaN where it does not stand
    margin: str  # the same of the angle to tip over
    reason: str  # base64 of uint8, an index into reasons
    reasons: list[str]


@call_of_host
def tilt(host: Host, *, doc: str, index: int, robot: str, heading: float) -> PoseMap:
    """Return how a robot of one heading rests on a grid of places all over a map."""
    _refuse_unplaced(heading=heading)
    with host.opened(doc).newest_turn("tilt") as watch:
        *_, field = _map(host, doc, index)
        (along_x, along_y), body = field.extent, robot_of_page(host, robot).body
        # A third of a block, or coarser on a map that would have more than _MOST points.
        step = max(field.block_width / _PER_BLOCK, (along_x * along_y / _MOST) ** 0.5)
        counts = [max(ceil(round(side / step, 6)), 1) for side in (along_x, along_y)]
        x, y = ((np.arange(count) - (count - 1) / 2) * step for count in counts)
        every_x, every_y = (grid.ravel() for grid in np.meshgrid(x, y, indexing="ij"))
        ground = PaddedGround.of(field, outer_radius(body))
        tilt, margin = np.full((2, len(every_x)), np.nan)
        reason = np.full(len(every_x), len(REASONS) - 1)
        for first in range(0, len(every_x), _AT_ONCE):
            watch(first / len(every_x))
            part = slice(first, first + _AT_ONCE)
            rest = settle(ground, body, every_x[part], every_y[part], np.full(len(every_x[part]), heading))
            # A robot that tips over, as a small one does in most places, has nothing else to be measured.
            (standing,) = np.nonzero(has_stood(rest))
            poses, at = of_settled(ground, body, rest.some(standing)), first + standing
            tilt[at], margin[at], reason[at] = poses.tilt, poses.tip_angle, poses.reason
    return {
        "shape": (counts[0], counts[1]),
        "low": (float(x[0]), float(y[0])),
        "step": step,
        "tilt": base64_of(tilt, "<f4"),
        "margin": base64_of(margin, "<f4"),
        "reason": base64_of(reason, "u1"),
        "reasons": list(REASONS),
    }


class Across(TypedDict):
    """A way across a map, laid on the blocks."""

    points: list[tuple[float, float, float]]
    name: str
    crosses: bool


class StartOrGoal(TypedDict):
    """A spot for a start or a goal."""

    x: float
    y: float
    z: float
    yaw: float
    name: Literal["S", "G"]


class DrawnReach(TypedDict):
    """The area that a robot can reach."""

    text: str  # "crosses west to east"
    region: str  # base64 of uint8 for each cell: 1 where it gets
    ways: list[Across]
    spots: list[StartOrGoal]


_ENDS: tuple[Literal["S", "G"], ...] = ("S", "G")
"""The names of the spots of a start and of a goal."""


@call_of_host
def reach(host: Host, *, doc: str, index: int, robot: str) -> DrawnReach:
    """Return the area that a robot reaches on a map, its ways across, and a start and a goal for it."""
    with host.opened(doc).newest_turn("reach") as watch:
        _, recipe, field = _map(host, doc, index)
        body = robot_of_page(host, robot).body
        area = reached(field, body, watch)
        spots: Sequence[Spot] = ()
        with suppress(ParameterError):  # there are none
            spots = find_spots(field, body, 2, spot_generator(recipe.seed))
    crossings = {"west to east": area.west_east, "south to north": area.south_north}
    across = [name for name, way in crossings.items() if way.crosses]
    nowhere = f"does not cross; largest area {area.coverage:.0%} of the map"
    return {
        "text": f"crosses {' and '.join(across)}" if across else nowhere,
        "region": base64_of(area.region, "u1"),
        "ways": list(_ways(field, body, crossings)),
        "spots": [
            {"x": spot.x, "y": spot.y, "z": spot.z, "yaw": spot.yaw, "name": name}
            for name, spot in zip(_ENDS, spots, strict=False)
        ],
    }


def _ways(field: StepField, body: Body, crossings: Mapping[str, LatticeWay]) -> Iterator[Across]:
    """Yield the ways across on the blocks; if no way crosses, the way that `drive --route way` tries."""
    ways = {name: way.points for name, way in crossings.items() if way.crosses}
    for name, points in (ways or {"tried": followed(field, body, crossings["west to east"]).points}).items():
        yield {"points": draped(field, points).tolist(), "name": name, "crosses": name != "tried"}


class WayEvent(TypedDict):
    """An event on a way: a drop, or a slip."""

    at: int  # the number of the pose
    text: str


class DrawnWay(TypedDict):
    """A way of a robot between two places."""

    found: bool
    text: str
    poses: list[tuple[float, float, float, float, float, float]]  # x y z roll pitch yaw of the robot's origin
    events: list[WayEvent]
    length: float
    worst_tilt: float
    least_margin: float
    least_margin_at: tuple[float, float]  # x and y of the robot's origin


@call_of_host
def way(  # noqa: PLR0913  # each is named by the page
    host: Host,
    *,
    doc: str,
    index: int,
    robot: str,
    start: tuple[float, float],
    goal: tuple[float, float],
    best: Literal["safe", "length", "tilt", "margin"] = "safe",
) -> DrawnWay:
    """Return the best way of a robot between two places, pose by pose, with its falls and slides."""
    for place in (start, goal):
        _refuse_unplaced(x=place[0], y=place[1])
    with host.opened(doc).newest_turn("way") as watch:
        opened, recipe, field = _map(host, doc, index)
        known = robot_of_page(host, robot)  # as its file is now
        # A lattice takes seconds, and answers for every start and goal on the map.
        key = ("planner", recipe, index, known, best)
        planner = cached(opened, key, lambda: Planner(Lattice(field, known.body, best)))
        planner.lattice.watch = watch
        route = planner.between(start, goal)
    if route is None:
        return {
            "found": False,
            "text": f"no way for {robot} between these places",
            "poses": [],
            "events": [],
            "length": 0.0,
            "worst_tilt": 0.0,
            "least_margin": 0.0,
            "least_margin_at": (0.0, 0.0),
        }
    poses = route.poses
    worst, tips_at = float(poses.tilt.max()), int(poses.tip_angle.argmin())
    least, (x, y) = float(poses.tip_angle[tips_at]), (round(float(along[tips_at]), 5) for along in (poses.x, poses.y))
    events = [(at, "falls") for at in route.drops] + [(at, "slides") for at in route.slips]
    tips = f"{degrees(least):.0f} from tipping over at {x + 0:.2f}, {y + 0:.2f} m"
    text = f"{route.length:.2f} m, tilts up to {degrees(worst):.0f} degrees, {tips}"
    rows = np.stack([getattr(poses, name) for name in ("x", "y", "z", "roll", "pitch", "yaw")], axis=1)
    return {
        "found": True,
        "text": text,
        "poses": np.round(rows, 5).tolist(),
        "events": [{"at": at, "text": words} for at, words in sorted(events)],
        "length": route.length,
        "worst_tilt": worst,
        "least_margin": least,
        "least_margin_at": (x, y),
    }


class MetricRows(TypedDict):
    """Metrics of a map, and of a robot on it."""

    rows: list[tuple[str, str, str, str]]  # name, value, meaning, key


@call_of_host
def measure(host: Host, *, doc: str, index: int, robot: str | None = None) -> MetricRows:
    """Return all metrics of a map as rows of name, value, unit or meaning, and key; with a robot, also its own."""
    crosser = robot_of_page(host, robot) if robot else None
    with host.opened(doc).newest_turn("measure") as watch:
        *_, field = _map(host, doc, index)
        watched = crosser and crosser.watched(lambda _: watch())
        entries = nested(metrics(field, watched)) | custom(field)
    meanings = {key: {"m": "metres", "rad": "radians"}.get(unit, "") for key, unit in UNITS.items()}
    meanings |= {key: f"{metric.unit} {metric.help}".strip() for key, metric in METRICS.items()}
    rows = ((metric_title(key), _shown(value), meanings.get(key, ""), key) for key, value in flattened(entries))
    return {"rows": [row for row in rows if row[1]]}


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else "" if value is None else line_of(str(value))
