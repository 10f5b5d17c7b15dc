"""Turns of robots that skid on flat ground: by statics, in MuJoCo as it is, and with rsegen's sliding contacts.

python -m benchmarks.sliding    prints the table of docs/mujoco.md; two minutes

A robot that turns on the spot has to run its sides against each other faster than they would roll, as its wheels skid
to the side. By how much follows from Coulomb's law alone: the forces on all contacts, each against its slip and within
its friction, are in balance. Here these equations are solved for contacts that carry their share of the weight.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from scipy.optimize import root

from benchmarks.machine import machine
from rsegen.field.stepfield import Array
from rsegen.mujoco import world as mujoco_world
from rsegen.mujoco.contacts import slide
from rsegen.mujoco.settings import STEP
from rsegen.mujoco.turning import ROBOT, on_flat_ground, turned_within
from rsegen.robots.base import ROBOTS, Robot

RATES = (0.1, 0.3, 1.0)
"""Turn rates, rad/s; those of the crawler go up to 1.5."""


def by_statics(robot: Robot, points: Array, loads: Array, mu: float, mu2: float) -> float:
    """Return how much faster the sides of a robot run than they would roll, when it turns on the spot at any rate.

    points: of its contacts, (n, 2), metres; loads: share of the weight on each; mu, mu2: along and across
    """
    half = robot.drive.separation / 2
    sides = np.sign(points[:, 1])

    def lacking(unknown: Array) -> Array:
        """Return the force along and across and the moment, for a gain and the centre of rotation."""
        gain, x, along = unknown
        slip_x = along - points[:, 1] + sides * gain * half  # at 1 rad/s: the ground under a side that runs backward
        slip_y = points[:, 0] - x
        size = np.hypot(mu * slip_x, mu2 * slip_y) + 1e-9
        force_x, force_y = -loads * mu**2 * slip_x / size, -loads * mu2**2 * slip_y / size
        return np.array([force_x.sum(), force_y.sum(), (points[:, 0] * force_y - points[:, 1] * force_x).sum()])

    found = root(lacking, [1.2, float(points[:, 0].mean()), 0.0], method="lm")
    return float(found.x[0])


def simulated(robot: Robot, rate: float, *, slides: bool) -> tuple[float, float]:
    """Return that ratio in MuJoCo, and the least share of steps in which a part that carries it has contact."""
    if not slides:
        setattr(mujoco_world, "slide", lambda *_: None)  # noqa: B010  # as a test would
    try:
        world = on_flat_ground(robot)
        world.step(round(0.5 / STEP))
        world.drive(ROBOT, robot, 0.0, rate)
        world.step(round(0.5 / STEP))
        turned = turned_within(world, 2.0)
    finally:
        setattr(mujoco_world, "slide", slide)  # noqa: B010
    return 2.0 * rate / turned, min(world.shares()[ROBOT].values())


def contacts_of(robot: Robot) -> tuple[Array, Array]:
    """Return where a robot stands on flat ground, (n, 2), metres, and the share of its weight on each contact."""
    world = on_flat_ground(robot)
    world.step(2000)
    import mujoco

    forces = []
    for number in range(world.data.ncon):
        force = np.zeros(6)
        mujoco.mj_contactForce(world.model, world.data, number, force)
        forces.append(force[0])
    return np.array(world.data.contact.pos)[:, :2], np.array(forces) / sum(forces)


def lines() -> list[str]:
    """Return the rows of the table."""
    rows = ["| robot | by statics | MuJoCo as it is | contact | in rsegen | contact |", "|---|---|---|---|---|---|"]
    for kind in ("jackal", "crawler"):
        robot = ROBOTS[kind]
        drive: Any = robot.drive
        points, loads = contacts_of(robot)
        mu, mu2 = (drive.mu, drive.mu2) if hasattr(drive, "mu") else (1.0, 1.0)
        cells = []
        for slides in (False, True):
            found = [simulated(robot, rate, slides=slides) for rate in (*RATES, robot.turn)]
            ratios, shares = zip(*found, strict=True)
            cells += [f"{min(ratios):.2f} to {max(ratios):.2f}", f"{min(shares):.0%} to {max(shares):.0%}"]
        rows.append(f"| {kind} | {by_statics(robot, points, loads, mu, mu2):.2f} | {' | '.join(cells)} |")
    return rows


if __name__ == "__main__":
    sys.stdout.write("\n".join([machine(), *lines()]) + "\n")
