"""A map with robots as a model of MJCF, MuJoCo's format: the ground, blocks as few boxes, robots, settings.

Boxes may be merged, as a box that touches another one in a plane makes no bump in MuJoCo; so maps are some thousand
boxes at most, which cost little. Where blocks have coefficients of friction of their own, boxes are of one coefficient
each. What breaks it: MuJoCo's reader of models, which takes a time that grows with the square of the boxes, 9 s for
the 58,000 of 320 x 320 random blocks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.geometry.box_merging import boxes
from rsegen.geometry.columns import columns
from rsegen.mujoco.friction import MapFriction
from rsegen.mujoco.looks import add_looks
from rsegen.mujoco.robot_model import RobotModel, numbers, robot_model, servo_elements
from rsegen.mujoco.settings import MEMORY, MULTICCD, OPTION, ROLLING, SOLIMP, SOLREF, TORSIONAL
from rsegen.params.sorts import NANOMETRE_DIGITS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import PlacedRobot

GROUND = "ground_plane"
"""The name of the ground, as in Gazebo's worlds."""


class MapModel(NamedTuple):
    """The text of a model, and what it holds of each robot."""

    text: str
    robots: list[RobotModel]


def map_model(scene: Scene, placed: Sequence[PlacedRobot], *, seen: bool = False) -> MapModel:
    """Return the model of a scene with robots at their starts; FileError or ParameterError for what it cannot hold.

    seen: with colours and light, for a window
    """
    blocks = list(_blocks(scene))
    friction = MapFriction(sorted({scene.friction, *(mu for _, _, mu in blocks)}))
    robots = [robot_model(robot, friction, alone=len(placed) == 1) for robot in placed]
    root = Element("mujoco", model=scene.name)
    SubElement(root, "compiler", angle="radian", balanceinertia="true", boundmass="1e-6", boundinertia="1e-9")
    SubElement(SubElement(root, "option", OPTION), "flag", multiccd=MULTICCD)
    SubElement(root, "size", memory=MEMORY)
    SubElement(SubElement(root, "default"), "geom", solref=SOLREF, solimp=SOLIMP)
    SubElement(root, "asset").extend(mesh for robot in robots for mesh in robot.assets)
    world = SubElement(root, "worldbody")
    ground = {"name": GROUND, "type": "plane", "size": "0 0 1"}
    SubElement(world, "geom", ground | _touched(scene.friction, friction))
    for centre, size, mu in blocks:
        box = {"type": "box", "pos": numbers(centre), "size": numbers(size / 2)}
        SubElement(world, "geom", box | _touched(mu, friction))
    world.extend(body for robot in robots for body in robot.bodies)
    contact = SubElement(root, "contact")
    for robot in robots:
        for one, other in robot.excluded:
            SubElement(contact, "exclude", body1=one, body2=other)
    actuators = SubElement(root, "actuator")
    for robot in robots:
        actuators.extend(servo_elements(robot))
    if seen:
        add_looks(root, scene, placed, robots)
    return MapModel(tostring(root, encoding="unicode"), robots)


def _touched(mu: float, friction: MapFriction) -> dict[str, str]:
    return {"friction": numbers((mu, TORSIONAL, ROLLING)), "contype": "0", "conaffinity": str(friction.bit(mu))}


def _blocks(scene: Scene) -> Iterator[tuple[Array, Array, float]]:
    """Yield centre and sides of boxes that fill the blocks and frames, metres, with their coefficient of friction."""
    if scene.recipe.is_of_one_friction:
        found = boxes(scene.field)
        yield from ((centre, size, scene.friction) for centre, size in zip(found.centres, found.sizes, strict=True))
        return
    for column in columns(scene.field):
        mu = round(scene.friction_of(column.material), NANOMETRE_DIGITS)
        yield np.array(column.centre), np.array(column.size), mu
