"""The picture of the end of a drive in this process, and its video, from a camera in the south-west of the map.

They are drawn by rsegen itself (`pictures/camera.py`), so they are the same on every machine, and need neither a screen
nor OpenGL. The map has the colours of its scene, and the robots their visual shapes, link by link: wheels turn and
flippers swing. A video does not change the drive: it has the same steps, in shorter pieces.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from math import hypot

import numpy as np

from rsegen.geometry.exposed_faces import surface
from rsegen.pictures.animation import Animation
from rsegen.pictures.camera import Pixels, Triangles, View, south_west_of
from rsegen.robots.lookup import DrivableRobot
from rsegen.robots.visuals import visuals
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import EmbeddedWorld, LinkPoses, PlacedRobot
from rsegen.simulators.poses import Contact, Pose, SteppedWorld

FRAME = 0.08
"""Seconds between two frames of a video: 12.5 a second, a whole number of milliseconds, in which WebP counts."""

PICTURE, VIDEO = (1280, 720), (640, 360)
"""Pixels of a picture, as of Gazebo's camera, and of a video."""

_GROUND = (0.78, 0.78, 0.78)
"""Colour of the ground."""

_AROUND = 1.0
"""Metres around the map in which there are shadows: there robots start."""


class FilmedWorld(SteppedWorld):
    """A world that passes all calls on to another one, and takes the frames of a video of it."""

    def __init__(self, world: EmbeddedWorld, scene: Scene, runs: Sequence[PlacedRobot]) -> None:
        self._world, self._steps, self._every = world, 0, round(FRAME / world.step_seconds)
        self._view = RobotView(scene, runs, VIDEO)
        self._animation = Animation(milliseconds=round(1000 * FRAME))

    def poses(self) -> Mapping[str, Pose]:
        """Return the pose of every robot's origin, by its name."""
        return self._world.poses()

    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive at v, m/s forward, and w, rad/s counterclockwise, from now on."""
        self._world.drive(name, robot, v, w)

    def step(self, steps: int) -> None:
        """Simulate this number of steps, and take every frame."""
        for piece in self._pieces(steps):
            self._world.step(piece)

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Simulate this number of steps, and return the contacts before the first step."""
        contacts = [self._world.step_with_contacts(piece) for piece in self._pieces(steps)]
        return contacts[0] if contacts else ()

    def _pieces(self, steps: int) -> Iterator[int]:
        """Yield numbers of steps, each up to the next frame or the end; a frame is taken before its steps."""
        while steps:
            if self._steps % self._every == 0:
                self._animation.add(self._view.picture(self._world.link_poses()))
            piece = min(steps, self._every - self._steps % self._every)
            yield piece
            self._steps += piece
            steps -= piece

    def video(self) -> bytes:
        """Return the video up to now, an animated WebP in real time, with the end as its last frame."""
        self._animation.add(self._view.picture(self._world.link_poses()))
        return self._animation.file()


def picture_of_end(scene: Scene, runs: Sequence[PlacedRobot], links: LinkPoses) -> bytes:
    """Return a JPEG of robots on a map whose links are at these poses."""
    from PIL import Image

    pixels, stream = RobotView(scene, runs, PICTURE).picture(links), io.BytesIO()
    Image.fromarray(pixels).save(stream, "jpeg", quality=90)
    return stream.getvalue()


class RobotView:
    """The view of a camera in the south-west on robots on a map; size: of its pictures, pixels along x and y."""

    def __init__(self, scene: Scene, runs: Sequence[PlacedRobot], size: tuple[int, int]) -> None:
        camera = south_west_of(scene.field.extent, size)
        radius = hypot(*scene.field.extent) / 2 + _AROUND
        self._view = View(camera, shapes_of_map(scene), radius, _GROUND)
        shapes = {id(run.robot): _links(run.robot) for run in runs}
        self._robots = {run.name: shapes[id(run.robot)] for run in runs}

    def picture(self, links: LinkPoses) -> Pixels:
        """Return the picture of robots whose links are at these poses, uint8, (height, width, 3)."""
        parts = (
            shape.moved(links[robot][link])
            for robot, shapes in self._robots.items()
            for link, shape in shapes.items()
            if np.isfinite(links[robot][link]).all()
        )
        return self._view.picture(Triangles.joined(parts))


def shapes_of_map(scene: Scene) -> Triangles:
    """Return the surface of a map in the colours of its scene."""
    mesh = surface(scene.field)
    colours = np.array([scene.surface_colour(int(material)) for material in mesh.materials]).reshape(-1, 3)
    return Triangles(mesh.vertices[mesh.triangles], colours.repeat(2, axis=0))


def _links(robot: DrivableRobot) -> Mapping[str, Triangles]:
    """Return the visual shapes of each link of a robot, in the frame of the link."""
    return {link: Triangles.joined(shape.triangles for shape in shapes) for link, shapes in visuals(robot).items()}
