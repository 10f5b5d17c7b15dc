"""MuJoCo: a map as a body of an MjSpec, and blocks whose map changes in a compiled model.

spec = mujoco.MjSpec.from_file("robot.xml")
grid = BlockGrid(recipe)
grid.add_to(spec)
model = spec.compile()
grid.write(model, rsegen.build_many(recipe, [17])[0])
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np

from rsegen.errors import ParameterError, refuse_other
from rsegen.field.stepfield import Array, Ints
from rsegen.geometry.box_merging import Column, columns
from rsegen.learning.blocks import BELOW, GROUND_COLOUR, BlockArrays
from rsegen.learning.ground import position_of
from rsegen.learning.terrain import Terrain
from rsegen.learning.tile import lowered_columns
from rsegen.recipe.recipe import Recipe, as_recipes
from rsegen.scene.contact import CONTACT, Contact
from rsegen.scene.scene import Scene

Attributes = Mapping[str, tuple[float, ...]]

_OF_A_JOINT = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)

_UPRIGHT = 1 - 1e-6
"""Cosine of the angle between an axis and z up to which it is along z: files have rounded numbers."""

_ROUNDING = 1e-9
"""Metres by which a radius may be smaller than it should."""

_BLOCKS_ALONE = 2**30
"""A bit of `conaffinity` for geoms of robots that otherwise touch nothing, or only what a <pair> names."""


def add_map(spec: Any, scene: Scene, pos: Sequence[float] = (0, 0, 0), contact: Contact = CONTACT) -> Any:
    """Add a map to an MjSpec as a static body of boxes, its middle at `pos` in metres; gives the body.

    Add it last: a robot that collides with nothing, or by pairs alone, then collides with the blocks.
    """
    refuse_other("scene", scene, Scene)
    let_touch(spec)
    body = spec.worldbody.add_body(name=scene.name, pos=position_of(pos).tolist())
    for index, column in enumerate(columns(scene.field)):
        geom = add_box(body, column, contact.attributes(scene.friction_of(column.material)))
        geom.name = f"{scene.name}_{index}"
        geom.rgba = [*scene.colour(column.material), 1.0]
    return body


def add_terrain(spec: Any, terrain: Terrain, pos: Sequence[float] = (0, 0, 0), contact: Contact = CONTACT) -> Any:
    """Add a terrain to an MjSpec as a static body of boxes, its middle at `pos` in metres; gives the body.

    Each tile has the friction of its own recipe. The boxes reach a unit below z = 0, as level ground has a friction
    too, so add no plane; and add the terrain last, as a map.
    """
    refuse_other("terrain", terrain, Terrain)
    let_touch(spec)
    body = spec.worldbody.add_body(name=terrain.name, pos=position_of(pos).tolist())
    field, frictions = terrain.field, terrain.frictions
    look = Scene(recipe=as_recipes(terrain.recipes)[0], index=0, field=field)
    # A box has one friction: those of a friction are cut from a field in which all other cells are empty.
    for friction in np.unique(frictions):
        raised = replace(field, levels=np.where(frictions == friction, field.levels + 1, 0).astype(np.int16))
        for column in lowered_columns(raised, np.array([0, 0, -field.unit])):
            geom = add_box(body, column, contact.attributes(float(friction)))
            geom.rgba = [*(look.colour(column.material) if column.material else GROUND_COLOUR), 1.0]
    return body


def add_box(body: Any, column: Column, attributes: Attributes) -> Any:
    """Add a box to a body of an MjSpec, with the attributes of a Contact; gives the geom."""
    size = [side / 2 for side in column.size]
    return _add_geom(body, {"type": mujoco.mjtGeom.mjGEOM_BOX, "pos": list(column.centre), "size": size}, attributes)


def add_height_field(
    spec: Any, body: Any, name: str, heights: Array, size: Sequence[float], attributes: Attributes
) -> tuple[Any, Any]:
    """Add a height field to a body of an MjSpec, from (0, 0) to a size in metres; return the field and its geom.

    heights: (n_x, n_y), metres, from one side to the other; attributes: of a Contact.
    """
    low, high = float(heights.min()), float(heights.max())
    # MuJoCo has samples from 0 to 1, along x first; a flat field has a height that nothing uses, as 0 is not allowed.
    rise, (n_x, n_y) = high - low or 1.0, heights.shape
    field = spec.add_hfield(
        name=name,
        size=[size[0] / 2, size[1] / 2, rise, BELOW],
        nrow=n_y,
        ncol=n_x,
        userdata=((heights.T - low) / rise).ravel().astype(np.float32),
    )
    shape = {"type": mujoco.mjtGeom.mjGEOM_HFIELD, "hfieldname": name, "pos": [size[0] / 2, size[1] / 2, low]}
    return field, _add_geom(body, shape, attributes)


def _add_geom(body: Any, shape: Mapping[str, Any], attributes: Attributes) -> Any:
    """Add a geom without mass, as it cannot move, by MuJoCo's own defaults, which the robot's file may have changed."""
    geom = body.add_geom(_empty().default, **shape, mass=0)
    for name, values in attributes.items():
        setattr(geom, name, values if len(values) > 1 else values[0])
    return geom


@cache
def _empty() -> Any:
    """Return a model that has MuJoCo's own defaults alone."""
    return mujoco.MjSpec()


def let_touch(spec: Any) -> None:
    """Let robots touch blocks whose geoms collide with nothing, as Gymnasium's swimmer, or by pairs with the ground.

    MuJoCo decides by bits and by a list of pairs. These geoms have no bits, so they get one that only blocks have: what
    they touch of the rest of the model stays the same. Bodies without a joint or an actuator stay as they are.
    """
    refuse_other("spec", spec, mujoco.MjSpec)
    static = {geom.name for geom in spec.worldbody.geoms}
    on_ground = {
        partner
        for pair in spec.pairs
        for name, partner in ((pair.geomname1, pair.geomname2), (pair.geomname2, pair.geomname1))
        if name in static
    }
    of_joints = {actuator.target for actuator in spec.actuators if actuator.trntype in _OF_A_JOINT}
    is_driven_otherwise = any(actuator.trntype not in _OF_A_JOINT for actuator in spec.actuators)
    for tree in spec.worldbody.bodies:
        joints, geoms = tree.find_all("joint"), tree.find_all("geom")
        is_driven = is_driven_otherwise or any(joint.name in of_joints for joint in joints)
        is_apart = bool(joints) and is_driven and not any(geom.contype or geom.conaffinity for geom in geoms)
        by_pairs = [geom for geom in geoms if geom.name in on_ground]
        for geom in by_pairs or (geoms if is_apart else []):
            if not (geom.contype or geom.conaffinity):
                geom.conaffinity = _BLOCKS_ALONE


class Root(NamedTuple):
    """A joint by which a robot rises as a whole.

    at: the index of its height in `qpos`; upwards: 1 if the robot rises with that, -1 if it sinks
    bodies: from the joint's own up to the world; geoms: all of the robot that can touch anything
    """

    at: int
    upwards: float
    bodies: Ints
    geoms: Ints


def roots_of(model: Any) -> list[Root]:
    """Return the joints by which robots rise, one for each: a free joint, or a slide joint along the z of the world.

    Such a slide, as models of a plane have it, carries all of the robot that can touch anything, and what carries it
    slides or turns about z: the lift of an arm that stands on the world is none.
    """
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    is_along_z = np.abs(data.xaxis[:, 2]) > _UPRIGHT
    slides, turns, free = (
        model.jnt_type == kind
        for kind in (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_FREE)
    )
    tilts, roots = ~(slides | (turns & is_along_z)), dict[int, Root]()
    for joint in np.flatnonzero(free | (slides & is_along_z)):
        bodies = _way_to_world(model, model.jnt_bodyid[joint])
        geoms = np.flatnonzero(collides & (model.body_rootid[model.geom_bodyid] == bodies[-1]))
        # A joint below another one rises along z only if nothing above it tilts; it moves all only if all hangs on it.
        is_tilted = tilts[np.isin(model.jnt_bodyid, bodies[1:])].any()
        carries_all = all(bodies[0] in _way_to_world(model, body) for body in np.unique(model.geom_bodyid[geoms]))
        if len(geoms) and not is_tilted and carries_all:
            at = int(model.jnt_qposadr[joint]) + (2 if free[joint] else 0)  # a free joint has x and y before z
            upwards = 1.0 if free[joint] else float(np.sign(data.xaxis[joint, 2]))
            roots.setdefault(bodies[-1], Root(at, upwards, np.array(bodies), geoms))
    return list(roots.values())


def _way_to_world(model: Any, body: int) -> list[int]:
    """Return a body and those between it and the world, which is left out."""
    bodies = [int(body)]
    while parent := int(model.body_parentid[bodies[-1]]):
        bodies.append(parent)
    return bodies


def geom_bounds(model: Any, data: Any, geoms: Ints) -> tuple[Array, Array]:
    """Return the least and the largest x, y and z of geoms, (geoms, 3), metres.

    Half an extent is the support function along an axis, of turned half sides: for a box their sum, for an ellipsoid
    the root of the sum of their squares; a cylinder is its axis and its disc, a capsule a line and a ball. A mesh has
    the bounds of its vertices.
    """
    turn = data.geom_xmat[geoms].reshape(-1, 3, 3)
    size, kind = model.geom_size[geoms][:, None, :], model.geom_type[geoms][:, None]
    along, disc = np.abs(turn[..., 2]), np.sqrt(np.clip(1 - turn[..., 2] ** 2, 0, 1))
    radius, length = size[..., 0], size[..., 1]
    shapes = mujoco.mjtGeom
    # Half the extents along x, y and z as each kind of geom would have them, of which each geom takes its own.
    half = np.select(
        [kind == shape for shape in (shapes.mjGEOM_SPHERE, shapes.mjGEOM_CAPSULE, shapes.mjGEOM_CYLINDER)]
        + [kind == shapes.mjGEOM_ELLIPSOID],
        [
            np.broadcast_to(radius, along.shape),
            radius + length * along,
            length * along + radius * disc,
            np.sqrt(((turn * size) ** 2).sum(-1)),
        ],
        (np.abs(turn) * model.geom_aabb[geoms][:, None, 3:]).sum(-1),
    )
    centre = data.geom_xpos[geoms] + np.einsum("nij,nj->ni", turn, model.geom_aabb[geoms][:, :3])
    low, high = centre - half, centre + half
    for index in np.flatnonzero(kind[:, 0] == shapes.mjGEOM_MESH):
        mesh = model.geom_dataid[geoms[index]]
        first = model.mesh_vertadr[mesh]
        vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]] @ turn[index].T
        low[index], high[index] = (data.geom_xpos[geoms[index]] + end for end in (vertices.min(0), vertices.max(0)))
    return low, high


class BlockGrid(BlockArrays):
    """A box for each block of a map, whose heights change in place: a new map without compiling the model anew.

    The arrays of a map, or of many (..., n_x, n_y) at once, have an axis of blocks, x first, in the order of the geoms.
    """

    def __init__(
        self, recipe: Recipe, name: str = "block", pos: Sequence[float] = (0, 0, 0), contact: Contact = CONTACT
    ) -> None:
        super().__init__(recipe, name, pos)
        refuse_other("contact", contact, Contact)
        self.contact = contact

    def add_to(self, spec: Any) -> Any:
        """Add the blocks to an MjSpec as a static body, all as high as the highest; gives the body.

        What the compiler makes of their size, the bounds in which it looks for contacts, then holds for every map. Add
        them last: a robot that collides with nothing, or by pairs alone, then collides with the blocks.
        """
        let_touch(spec)
        # The body is at the origin, as the compiler may fuse it with the world (`fusestatic`, as for URDF), where the
        # places of geoms are those in the world.
        body = spec.worldbody.add_body(name=self.name)
        arrays = (part(self.highest) for part in (self.pos, self.size, self.rgba, self.sliding))
        for name, pos, size, rgba, friction in zip(self.names, *arrays, strict=True):
            shape = {"type": mujoco.mjtGeom.mjGEOM_BOX, "pos": pos, "size": size}
            geom = _add_geom(body, shape, self.contact.attributes(float(friction)))
            geom.name, geom.rgba = name, rgba
        return body

    def write(self, model: Any, levels: Ints) -> None:
        """Put the map of these levels (n_x, n_y) into a compiled model, in place."""
        if np.ndim(levels) != 2:
            raise ParameterError(
                "levels", f"of shape {np.shape(levels)}; expected {self.shape}, as a model has one map"
            )
        part, position, size = self.geoms(model), self.pos(levels), self.size(levels)
        self._widen_bounds(model, part)
        model.geom_pos[part], model.geom_size[part] = position, size
        model.geom_rgba[part], model.geom_friction[part] = self.rgba(levels), self.friction(levels)

    def _widen_bounds(self, model: Any, part: slice) -> None:
        """Let MuJoCo look for contacts as high as the highest map, even after `mj_setConst` of a lower one (4.0)."""
        half = self.size(self.highest)[0]
        radius = float(np.linalg.norm(half))
        if model.geom_rbound[part].min() > radius - _ROUNDING:
            return
        model.geom_rbound[part], model.geom_aabb[part] = radius, [0, 0, 0, *half]
        body = model.geom_bodyid[part.start]
        first = model.body_bvhadr[body]
        boxes = model.bvh_aabb[first : first + model.body_bvhnum[body]]  # centres and half sides; of z both change
        ground = self.position[2] - model.body_ipos[body, 2]  # boxes are in the frame of the body's inertia
        low = np.minimum(boxes[:, 2] - boxes[:, 5], ground - BELOW)
        high = np.maximum(boxes[:, 2] + boxes[:, 5], ground - BELOW + 2 * half[2])
        boxes[:, 2], boxes[:, 5] = (low + high) / 2, (high - low) / 2

    def geoms(self, model: Any) -> slice:
        """Return the indices of the blocks among the geoms of a compiled model; ParameterError if it has none."""
        first, last = (mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, self.names[at]) for at in (0, -1))
        if first < 0 or last - first != len(self.names) - 1:
            missing = self.names[0] if first < 0 else f"{self.names[-1]} where this grid has its last block"
            raise ParameterError("model", f"has no geom {missing}; add the blocks by grid.add_to")
        return slice(first, last + 1)

    def friction(self, levels: Ints) -> Array:
        """The friction coefficients of the blocks by their levels, (..., blocks, 3): sliding, torsional, rolling."""
        sliding = self.sliding(levels)[..., None]
        others = self.contact.torsional, self.contact.rolling
        return np.concatenate([sliding, np.broadcast_to(others, (*sliding.shape[:-1], 2))], axis=-1)
