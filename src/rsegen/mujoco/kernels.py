"""Kernels of Warp for a step of `ManyWorlds`, in addition to mujoco_warp's: for wheels, or for contacts of all worlds.

Arrays of contacts hold all worlds together, in any order; the first `count[0]` are in use.
"""

import mujoco
import warp as wp
from mujoco_warp._src.types import vec5

from rsegen.mujoco import contacts, friction

STILL, MOST_RATIO = wp.constant(friction.STILL), wp.constant(friction.MOST_RATIO)
STUCK, SHARPNESS = wp.constant(friction.STUCK), wp.constant(float(friction.SHARPNESS))
SIDE, LEAST_LEFT = wp.constant(contacts.SIDE), wp.constant(contacts.LEAST_LEFT)

FRICTION = wp.constant(int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF))


@wp.kernel(enable_backward=False)
def ramp(
    speeds: wp.array2d[wp.float32],
    side: wp.array[wp.int32],
    per_speed: wp.array[wp.float32],
    most: wp.array[wp.float32],
    is_written: bool,
    dof: wp.array[wp.int32],
    now: wp.array2d[wp.float32],
    qvel: wp.array2d[wp.float32],
) -> None:
    """Bring the speeds of wheels nearer to the commanded ones; without a reaction, write them."""
    world, wheel = wp.tid()
    commanded = speeds[world, side[wheel]] * per_speed[wheel]
    speed = now[world, wheel] + wp.clamp(commanded - now[world, wheel], -most[wheel], most[wheel])
    now[world, wheel] = speed
    if is_written:
        qvel[world, dof[wheel]] = speed


@wp.func
def held(spent: wp.float32) -> wp.float32:
    """Return the slip, m/s, that a spent share of a friction counts as."""
    return STUCK * wp.pow(wp.min(spent, 1.0), SHARPNESS)


@wp.func
def corner_ellipse(mu: wp.vec2, slip: wp.vec2, spent: wp.vec2) -> wp.vec2:
    """Return what `rsegen.mujoco.friction.corner_ellipse` does."""
    ratio = (mu[1] * wp.abs(slip[1]) + held(spent[1]) + STILL) / (mu[0] * wp.abs(slip[0]) + held(spent[0]) + STILL)
    ratio = wp.clamp(ratio, 1.0 / MOST_RATIO, MOST_RATIO)
    return wp.vec2(mu[0] * wp.sqrt(1.0 + ratio), mu[1] * wp.sqrt(1.0 + 1.0 / ratio))


@wp.func
def belt_arm(point: wp.vec3, place: wp.vec3, axis: wp.vec3, centre: wp.float32) -> wp.vec3:
    """Return what `rsegen.mujoco.contacts.BeltTurn.arm` does."""
    if wp.isinf(centre):
        return axis
    arm = point - place - centre * axis
    if wp.length(arm) == 0.0:
        return axis
    return wp.normalize(arm)


@wp.func
def own_geom(pair: wp.vec2i, body: wp.array[wp.int32]) -> wp.int32:
    """Return the shape of the robot in a contact, -1 if neither shape is of a robot."""
    own = wp.max(pair[0], pair[1])
    if body[own] < 0:
        own = wp.min(pair[0], pair[1])
    if own >= 0 and body[own] < 0:
        own = -1
    return own


@wp.kernel(enable_backward=False)
def turn_planes(
    count: wp.array[wp.int32],
    geoms: wp.array[wp.vec2i],
    worlds: wp.array[wp.int32],
    xmat: wp.array2d[wp.mat33],
    body: wp.array[wp.int32],
    axis: wp.array[wp.vec3],
    mu: wp.array[wp.vec2],
    are_boxes: bool,
    belt: wp.array[wp.int32],
    speeds: wp.array2d[wp.float32],
    wedged: wp.array[wp.int32],
    base: wp.int32,
    centre: wp.array[wp.float32],
    places: wp.array2d[wp.vec3],
    points: wp.array[wp.vec3],
    twists: wp.array2d[wp.spatial_vector],
    centres: wp.array2d[wp.vec3],
    roots: wp.array[wp.int32],
    spent: wp.array3d[wp.float32],
    frames: wp.array[wp.mat33],
    friction: wp.array[vec5],
    surface: wp.array[wp.vec3],
    boxes: wp.array[wp.vec2],
) -> None:
    """Turn the plane of a contact as `rsegen.mujoco.contacts.Shapes.turn` does: its second direction along n x a.

    base: the body about which belts turn as in Gazebo Classic, -1 if they do not; boxes: halves of boxes of friction
    """
    at = wp.tid()
    if at >= wp.min(count[0], geoms.shape[0]):
        return
    pair, world = geoms[at], worlds[at]
    own = own_geom(pair, body)
    if own < 0:
        return
    frame, coefficients = frames[at], friction[at]
    normal = wp.vec3(frame[0, 0], frame[0, 1], frame[0, 2])
    axle = xmat[world, body[own]] * axis[own]
    across = wp.cross(normal, axle)
    length = wp.length(across)
    halves = wp.vec2(wp.min(coefficients[0], mu[own][0]), wp.min(coefficients[0], mu[own][1]))
    speed = wp.float32(0.0)
    if belt[own] >= 0 and wedged[world] == 0:
        speed = speeds[world, belt[own]]
    # A belt of Gazebo Classic pulls along n x arm; on the side of another shape n x a has no direction.
    if belt[own] >= 0 and base >= 0:
        along_belt = across
        across = wp.cross(normal, belt_arm(points[at], places[world, base], axle, centre[world]))
        length = wp.max(wp.length(across), LEAST_LEFT)
        speed = speed * wp.dot(along_belt, across) / length
        halves = halves * length
    elif length <= SIDE:
        across, length = wp.vec3(frame[2, 0], frame[2, 1], frame[2, 2]), wp.float32(1.0)
        halves, speed = wp.vec2(coefficients[0], coefficients[0]), wp.float32(0.0)
    across = across / length
    along = wp.cross(across, normal)
    frames[at] = wp.matrix_from_rows(normal, along, across)
    boxes[at] = halves
    # The ellipse for the slip of the shape against the other one, to which the speed of the surface is added.
    if are_boxes:
        twist, arm = twists[world, body[own]], points[at] - centres[world, roots[body[own]]]
        velocity = wp.spatial_bottom(twist) + wp.cross(wp.spatial_top(twist), arm)
        slip2 = wp.dot(velocity, across)
        if own != pair[1]:
            slip2 = -slip2
        slips = wp.vec2(wp.dot(velocity, along), slip2 + speed)
        halves = corner_ellipse(halves, slips, wp.vec2(spent[world, own, 0], spent[world, own, 1]))
    coefficients[0] = halves[0]
    coefficients[1] = halves[1]
    friction[at] = coefficients
    surface[at] = wp.vec3(0.0, speed, 0.0)


@wp.kernel(enable_backward=False)
def find_spent(
    count: wp.array[wp.int32],
    geoms: wp.array[wp.vec2i],
    worlds: wp.array[wp.int32],
    rows: wp.array2d[wp.int32],
    force: wp.array2d[wp.float32],
    body: wp.array[wp.int32],
    boxes: wp.array[wp.vec2],
    spent: wp.array3d[wp.float32],
) -> None:
    """Find how much of its box of friction each shape has spent, as `rsegen.mujoco.contacts.Shapes` does."""
    at = wp.tid()
    if at >= wp.min(count[0], geoms.shape[0]):
        return
    world, row, own = worlds[at], rows[at, 0], own_geom(geoms[at], body)
    if own < 0 or row < 0:
        return
    normal = force[world, row]
    if normal > 0.0:
        for side in range(2):
            share = wp.abs(force[world, row + 1 + side]) / (boxes[at][side] * normal)
            wp.atomic_max(spent, world, own, side, share)


@wp.kernel(enable_backward=False)
def add_speeds(
    equalities: wp.array[wp.int32],
    frictions: wp.array[wp.int32],
    kinds: wp.array2d[wp.int32],
    ids: wp.array2d[wp.int32],
    dof: wp.array[wp.int32],
    now: wp.array2d[wp.float32],
    damping: float,
    reference: wp.array2d[wp.float32],
) -> None:
    """Add the speed of a wheel to the reference of the friction of its joint, to rest."""
    world, wheel = wp.tid()
    first = equalities[world]
    for row in range(first, first + frictions[world]):
        if kinds[world, row] == FRICTION and ids[world, row] == dof[wheel]:
            reference[world, row] += damping * now[world, wheel]


@wp.kernel(enable_backward=False)
def slide(
    count: wp.array[wp.int32],
    worlds: wp.array[wp.int32],
    kinds: wp.array[wp.int32],
    dimensions: wp.array[wp.int32],
    rows: wp.array2d[wp.int32],
    friction: wp.array[vec5],
    jacobian: wp.array3d[wp.float32],
    acceleration: wp.array2d[wp.float32],
    degrees: int,
    reference: wp.array2d[wp.float32],
) -> None:
    """Correct the reference of a contact that slides, as `rsegen.mujoco.contacts.slide` does."""
    at = wp.tid()
    if at >= wp.min(count[0], worlds.shape[0]):
        return
    row, world = rows[at, 0], worlds[at]
    if row < 0 or dimensions[at] != 3 or (kinds[at] & 1) == 0:
        return
    left = wp.vec2(-reference[world, row + 1], -reference[world, row + 2])
    for dof in range(degrees):
        left[0] += jacobian[world, row + 1, dof] * acceleration[world, dof]
        left[1] += jacobian[world, row + 2, dof] * acceleration[world, dof]
    reference[world, row] -= wp.length(wp.vec2(friction[at][0] * left[0], friction[at][1] * left[1]))


@wp.kernel(enable_backward=False)
def find_wedged(
    count: wp.array[wp.int32],
    geoms: wp.array[wp.vec2i],
    worlds: wp.array[wp.int32],
    rows: wp.array2d[wp.int32],
    force: wp.array2d[wp.float32],
    belt: wp.array[wp.int32],
    limit: float,
    wedged: wp.array[wp.int32],
) -> None:
    """Mark the worlds in which a belt is pressed with more than the limit, N: it stalls in the next step."""
    at = wp.tid()
    if at >= wp.min(count[0], geoms.shape[0]):
        return
    pair, row, world = geoms[at], rows[at, 0], worlds[at]
    if row >= 0 and (belt[pair[0]] >= 0 or belt[pair[1]] >= 0) and force[world, row] > limit:
        wedged[world] = 1


@wp.kernel(enable_backward=False)
def count_touches(
    count: wp.array[wp.int32],
    geoms: wp.array[wp.vec2i],
    worlds: wp.array[wp.int32],
    first: int,
    end: int,
    touches: wp.array[wp.int32],
) -> None:
    """Count the contacts of each world with the geoms `first` to `end`, the last one left out."""
    at = wp.tid()
    if at >= wp.min(count[0], geoms.shape[0]):
        return
    a, b = geoms[at][0], geoms[at][1]
    if (a >= first and a < end) or (b >= first and b < end):
        wp.atomic_add(touches, worlds[at], 1)


@wp.kernel(enable_backward=False)
def find_depths(
    count: wp.array[wp.int32],
    distances: wp.array[wp.float32],
    worlds: wp.array[wp.int32],
    depths: wp.array[wp.float32],
) -> None:
    """Find the depth of the deepest contact of each world."""
    at = wp.tid()
    if at < wp.min(count[0], distances.shape[0]):
        wp.atomic_max(depths, worlds[at], -distances[at])
