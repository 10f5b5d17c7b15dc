"""Fields and robots of tests of poses."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.geometry.poses import rotation
from rsegen.robots.base import ROBOTS
from rsegen.robots.links import ALONG_Y
from rsegen.standing.body import Body, CollisionPart, body_of_shapes, sampled_ball, sampled_cylinder
from rsegen.standing.ground import PaddedGround
from rsegen.standing.settling import Settled, outer_radius, settle

BODIES = {kind: robot.body for kind, robot in ROBOTS.items()}
"""The bodies of the included robots."""


def field_of(levels: Ints | list[list[int]], unit: float = 0.01) -> StepField:
    """A field of blocks of 10 cm, without frames; levels (n_x, n_y)."""
    heights = np.asarray(levels, np.int16)
    return StepField(levels=heights, frame=np.zeros(heights.shape, bool), block_width=0.1, unit=unit, frame_height=0.1)


def settled(field: StepField, body: Body, x: float, y: float, yaw: float) -> Settled:
    """One robot at rest."""
    ground = PaddedGround.of(field, outer_radius(body))
    return settle(ground, body, *(np.array([value]) for value in (x, y, yaw)))


def cart(radius: float, *, mu: float = 1.0, base: float = 0.4, speed: float = 0.01) -> Body:
    """Two driven wheels in front and a caster without friction behind, with the mass between, low."""
    wheel, caster = sampled_cylinder(radius, 0.04, 0.001), sampled_ball(0.01, 0.001)
    shapes = [
        (CollisionPart(name="left", drives=True, mu=mu, mu2=mu), wheel, placed(0, 0.15, radius, *ALONG_Y)),
        (CollisionPart(name="right", drives=True, mu=mu, mu2=mu), wheel, placed(0, -0.15, radius, *ALONG_Y)),
        (CollisionPart(name="caster", drives=False, mu=0.0, mu2=0.0), caster, placed(-base, 0, 0.01)),
    ]
    centre = np.array([-base / 3, 0.0, radius])
    return body_of_shapes(shapes, mass=5.0, centre=centre, speed=speed, distance=0.001, where="cart")


def placed(x: float, y: float, z: float, *angles: float) -> Array:
    """A pose as a matrix, (4, 4)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(*(angles or (0.0, 0.0, 0.0))), (x, y, z)
    return pose
