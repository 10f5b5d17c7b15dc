"""A map with robots as a model of MJCF, MuJoCo's format: the ground, blocks as few boxes, robots, settings.

Boxes may be merged, as a box that touches another one in a plane makes no bump in MuJoCo; so maps are some thousand
boxes at most, which cost little. If blocks have coefficients of friction of their own, only equal ones are merged. What
breaks it: MuJoCo's reader of models, whose time grows with the square of the boxes: 9 s for the 58,000 of 320 x 320
random blocks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.geometry import box_merging
from rsegen.mujoco.friction import MapFriction
from rsegen.mujoco.looks import add_looks
from rsegen.mujoco.robot_model import RobotModel, numbers, robot_model, servo_elements
from rsegen.mujoco.settings import MEMORY, MULTICCD, OPTION, ROLLING, SOLIMP, SOLREF, TORSIONAL
from rsegen.params.sorts import NANOMETRE_DIGITS
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import AS_DRAWN, AsBuilt, PlacedRobot

GROUND = "ground_plane"
"""The name of the ground, as in Gazebo's worlds."""


_THINNEST = 1e-4
"""Height, metres, that a block has at least, whatever its error."""


class NamedBoxes(NamedTuple):
    """Boxes in a body of their own, besides the blocks of a scene, for callers that change them in the compiled model.

    body: its name; names: of the boxes; centres, halves: (boxes, 3), metres
    """

    body: str
    names: Sequence[str]
    centres: Array
    halves: Array


class MapModel(NamedTuple):
    """The text of a model, and its robots."""

    text: str
    robots: list[RobotModel]


def map_model(
    scene: Scene,
    placed: Sequence[PlacedRobot],
    *,
    seen: bool = False,
    motors: str = MOTORS[0],
    built: AsBuilt = AS_DRAWN,
    boxes: NamedBoxes | None = None,
) -> MapModel:
    """Return the model of a scene with robots at their starts; FileError or ParameterError for what it cannot hold.

    seen: with colours and light, for a window; motors: their model; built: how the map differs from its drawing
    boxes: besides its blocks, with the friction of the scene
    """
    # Coefficients of the whole map come first, as they decide in how many layers the shapes of a robot are.
    blocks = list(_blocks(scene) if built.heights is None else _blocks_as_built(scene, built.heights))
    friction = MapFriction(sorted({scene.friction, *(mu for _, _, mu in blocks)}))
    robots = [robot_model(robot, friction, motors, alone=len(placed) == 1) for robot in placed]
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
    if boxes is not None:
        body = SubElement(world, "body", name=boxes.body)
        for name, centre, half in zip(boxes.names, boxes.centres, boxes.halves, strict=True):
            box = {"name": name, "type": "box", "pos": numbers(centre), "size": numbers(half)}
            SubElement(body, "geom", box | _touched(scene.friction, friction))
    world.extend(body for robot in robots for body in robot.bodies)
    contact = SubElement(root, "contact")
    for robot in robots:
        for first, second in robot.excluded:
            SubElement(contact, "exclude", body1=first, body2=second)
    SubElement(root, "equality").extend(joint for robot in robots for joint in robot.equalities)
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
        filled = box_merging.boxes(scene.field)
        yield from ((centre, size, scene.friction) for centre, size in zip(filled.centres, filled.sizes, strict=True))
        return
    for column in box_merging.columns(scene.field):
        mu = round(scene.friction_of(column.material), NANOMETRE_DIGITS)
        yield np.array(column.centre), np.array(column.size), mu


def _blocks_as_built(scene: Scene, errors: Array) -> Iterator[tuple[Array, Array, float]]:
    """Yield boxes as `_blocks`, but each block with an error (n_x, n_y) as its own box, higher than drawn by it."""
    field = scene.field
    (x, y), differs = field.middles(), np.isfinite(errors) & (field.heights > 0)
    drawn = replace(field, levels=np.where(differs, 0, field.levels), frame=field.frame & ~differs)
    yield from _blocks(replace(scene, field=drawn))
    for i, j in np.argwhere(differs).tolist():
        top = max(float(field.heights[i, j] + errors[i, j]), _THINNEST)
        mu = round(scene.friction_of(0 if field.frame[i, j] else int(field.levels[i, j])), NANOMETRE_DIGITS)
        yield np.array([x[i], y[j], top / 2]), np.array([field.block_width, field.block_width, top]), mu
