"""The format `ros2`: the map as a package for `colcon build`, with launch files for both Gazebos, Nav2 and RViz."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

from rsegen.errors import ParameterError
from rsegen.formats.base import Format, Step, register
from rsegen.formats.encoded import as_json
from rsegen.formats.occupancy import Climb, Occupancy
from rsegen.formats.urdf import urdf_files
from rsegen.gazebo import MESH_TYPES, sdf
from rsegen.params.sorts import NANOMETRE_DIGITS, Float, Json, Text
from rsegen.params.streams import generator
from rsegen.robots.base import ROBOTS
from rsegen.ros2.elevation import layer_files
from rsegen.ros2.package import common_files
from rsegen.ros2.robots import ros_files
from rsegen.scene.scene import Scene
from rsegen.standing.spots import find_spots

_DROP_HEIGHT = 0.1
"""Metres above the ground at which robots are spawned: the origin of many is at the height of their axles."""

_CLEARANCE = 0.005
"""Metres above its pose at rest at which a robot is spawned on its spot, so that no part of it is inside a block."""

_MARGIN, _MOST_CELLS = 2.0, 500
"""Metres of free ground around the map in its occupancy grid by default, and most cells of it."""


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Ros2(Format):
    """A ROS 2 package (ament_cmake) that drives: world, robots, bridge, occupancy grid, Nav2, RViz, grid_map."""

    name: ClassVar[str] = "ros2"
    step: ClassVar[Step] = "surface"

    package: Annotated[
        str | None,
        Text(
            "[a-z](_?[a-z0-9])+",
            "two or more small letters, digits and single underscores, a letter first",
            help="name of one package with all maps; default: a package for each map, named after it",
        ),
    ] = None
    robot: Annotated[
        str | None,
        Text(
            "[A-Za-z0-9_]+",
            "a kind of robot",
            help="robot that is spawned by default, on a spot of each map that has one; the others start on the ground",
        ),
    ] = None
    climb_cm: Climb = None
    margin_cm: Annotated[
        float | None,
        Float(0, 100_000, unit="cm", help="free ground around the map in its occupancy grid; default: 200"),
    ] = None
    clearance_cm: Annotated[
        float, Float(0, 100_000, unit="cm", help="distance of the start pose from the map's border, on flat ground")
    ] = 100.0

    def __post_init__(self) -> None:
        super(Ros2, self).__post_init__()  # in a class with slots, super() alone is of the class without them
        if self.robot is not None and not ros_files(ROBOTS.named(self.robot, "robot")):
            raise ParameterError("robot", f"{self.robot} has no description of links and joints; choose another kind")

    @property
    def joins(self) -> str:
        """Folder of the package of all maps, if its name is given."""
        return self.package or ""

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return the files of the package, in a folder of its name."""
        package = self.package or package_name(scene.name)
        common = common_files(package, self._robot_files(), self.robot or "none")
        contents: dict[str, Iterable[bytes]] = {path: [text.encode()] for path, text in common.items()}
        # The map's model, as of mesh type `single`; the package has its own world.
        files = MESH_TYPES["single"].files(scene)
        model = {path: content for path, content in files.items() if path != f"{scene.name}.world"}
        contents |= {f"models/{scene.name}/{path}": content for path, content in model.items()}
        contents |= urdf_files(scene, f"urdf/{scene.name}/", f"package://{package}/urdf/{scene.name}/")
        contents |= {f"maps/{scene.name}/{path}": content for path, content in self._map(scene).items()}
        contents[f"worlds/{scene.name}.world"] = sdf.utf8(sdf.world(scene, [_INCLUDE.format(name=scene.name)]))
        return {f"{package}/{path}": content for path, content in contents.items()}

    def _robot_files(self) -> dict[str, Mapping[str, str]]:
        """Return the files of rsegen's own robots, and of the one that is spawned by default, by their kinds."""
        kinds = {robot.kind for robot in ROBOTS.own()} | ({self.robot} if self.robot else set())
        return {kind: texts for kind in sorted(kinds) if (texts := ros_files(ROBOTS[kind]))}

    def _map(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return the occupancy grid, the layers of a grid_map, which have the default margin, and the start poses."""
        margin = min(_MARGIN, _MOST_CELLS * scene.field.block_width) * 100
        plain = Occupancy(climb_cm=self.climb_cm, margin_cm=margin)
        grid = plain if self.margin_cm is None else replace(plain, margin_cm=self.margin_cm)
        # On the ground west of the map, heading east.
        x = round(-scene.field.extent[0] / 2 - self.clearance_cm / 100, NANOMETRE_DIGITS)
        ground = dict(zip(_POSE, (x, 0.0, _DROP_HEIGHT, 0.0, 0.0, 0.0), strict=True))
        return {
            **grid.files(scene),
            **layer_files(scene, plain.margin(scene.field)),
            "start_poses.json": [as_json({"ground": ground, **self._on_spot(scene)})],
        }

    def _on_spot(self, scene: Scene) -> dict[str, Json]:
        """Return the pose of the robot on a spot of the map, by its kind; nothing if the map has none."""
        if self.robot is None:
            return {}
        rng = generator(scene.recipe.seed, scene.index, "start pose")
        try:
            (spot,) = find_spots(scene.field, ROBOTS[self.robot].body, 1, rng)
        except ParameterError:
            return {}
        raised = replace(spot, z=spot.z + _CLEARANCE)
        return {self.robot: {name: round(getattr(raised, name), 4) for name in _POSE}}


_POSE = ("x", "y", "z", "roll", "pitch", "yaw")


def package_name(name: str) -> str:
    """Return a map's name as a ROS package name (REP 144): lower case, digits, single underscores, a letter first."""
    plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    return plain if plain[:1].isalpha() else f"map_{plain}"


_INCLUDE = """\
    <include>
      <uri>model://{name}</uri>
    </include>
"""
