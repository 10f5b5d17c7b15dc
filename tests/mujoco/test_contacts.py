"""Contacts are turned and slide in Python's numbers, the map apart, as numpy and MuJoCo do it for all, bit by bit."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from rsegen.driving.recording import drive_in_steps
from rsegen.driving.robot_runs import robot_runs
from rsegen.mujoco import contacts, friction
from rsegen.mujoco import world as mujoco_world
from rsegen.mujoco.robot_model import Shape
from rsegen.recipe.codec import decode
from rsegen.robots.base import ROBOTS
from rsegen.robots.lookup import robot_of
from rsegen.scene.scene import compose
from rsegen.simulators.poses import Pose
from tests.mujoco.worlds import step_of, world_of


class InNumpy(contacts.Shapes):
    """Shapes whose contacts are turned and counted with arrays."""

    def __init__(self, model: Any, shapes: list[Shape], friction: float, turns: None) -> None:
        super().__init__(model, shapes, friction, turns)
        self._axis, self._mu = np.tile([0.0, 1.0, 0.0], (model.ngeom, 1)), np.full((2, model.ngeom), np.inf)
        for shape in shapes:
            if shape.axis is not None:
                geom = model.geom(shape.name).id
                self._axis[geom], self._mu[:, geom] = shape.axis, (shape.mu_axis, shape.mu_other)
        self._body = np.asarray(model.geom_bodyid)
        self._steps, self._counts = 0, np.zeros(len(self.parts) + 1, dtype=int)

    def count(self, contact: Any) -> None:
        self._steps += 1
        self._counts[np.unique(np.array(self._part)[contact.geom])] += 1

    def shares(self, robot: str) -> dict[str, float]:
        own = {part: self._counts[index] for (owner, part), index in self.parts.items() if owner == robot}
        return {part: round(float(count / self._steps), 3) for part, count in own.items() if count}

    def turn(self, data: Any) -> None:
        contact = data.contact
        geoms, frames, friction = contact.geom, contact.frame, contact.friction
        own = geoms.max(axis=1)
        turn, axis, (normal, _, other) = data.xmat[self._body[own]].T, self._axis[own].T, frames.T.reshape(3, 3, -1)
        axis = turn[0::3] * axis[0] + turn[1::3] * axis[1] + turn[2::3] * axis[2]
        second = _cross(normal, axis)
        length = np.sqrt((second * second).sum(axis=0))
        mu, surface = np.minimum(friction[:, 0], self._mu[:, own]), np.array(self.speed)[own]
        beside = length <= contacts.SIDE
        second[:, beside], length[beside], mu[:, beside] = other[:, beside], 1.0, friction[beside, 0]
        surface[beside] = 0.0
        second /= length
        contact.surfacevel[:, 1] = surface
        frames[:, 3:6], frames[:, 6:], friction[:, :2] = -_cross(normal, second).T, second.T, mu.T


def _cross(a: Any, b: Any) -> Any:
    return a[[1, 2, 0]] * b[[2, 0, 1]] - a[[2, 0, 1]] * b[[1, 2, 0]]


def slide_in_numpy(model: Any, data: Any, contact: Any) -> None:
    """Correct all contacts at once."""
    if data.ncon:
        change = np.empty(data.nefc)
        mujoco.mj_mulJacVec(model, data, change, data.qacc)
        at, mu, reference = contact.efc_address, contact.friction, data.efc_aref
        at, mu, left = at[at >= 0], mu[at >= 0], change - reference
        reference[at] -= np.hypot(mu[:, 0] * left[at + 1], mu[:, 1] * left[at + 2])


def first_half_with_the_map(model: Any, data: Any, shapes: Any) -> None:
    """Do the first half of a step as MuJoCo does it, which computes again where the boxes of the map are."""
    if not shapes.turned:
        mujoco.mj_step1(model, data)
        return
    for part in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_makeM, mujoco.mj_factorM, mujoco.mj_collision):
        part(model, data)
    shapes.turn(data)
    for part in (mujoco.mj_makeConstraint, mujoco.mj_island, mujoco.mj_transmission, mujoco.mj_projectConstraint):
        part(model, data)
    mujoco.mj_fwdVelocity(model, data)


@pytest.mark.parametrize("kind", ["crawler", "jackal"])
def test_a_drive_has_the_bits_that_numpy_gives_it(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    given = {"boundary": "none", "unit_cm": 3, "seed": 5, "obstacles": [{"kind": "random", "levels": 4}]}
    scene = compose(decode({"name": "field", **given}), 0)
    runs = robot_runs(scene.field, ROBOTS[kind], "straight", count=1, seed=1)
    states = []
    own = contacts.Shapes, contacts.slide, mujoco_world._make_constraints
    for shapes, sliding, first_half in (own, (InNumpy, slide_in_numpy, first_half_with_the_map)):
        monkeypatch.setattr(mujoco_world, "Shapes", shapes)
        monkeypatch.setattr(mujoco_world, "slide", sliding)
        monkeypatch.setattr(mujoco_world, "_make_constraints", first_half)
        world = mujoco_world.MujocoWorld(scene, runs)
        drive_in_steps(world, runs, 3.0, world.step_seconds)
        states.append((world.data.qpos.tobytes(), world.data.qvel.tobytes(), world.shares()))
    assert states[0] == states[1]
    assert world.poses()[runs[0].name].x > runs[0].start.x + 0.3
    assert any(states[0][2][runs[0].name].values())


def test_contacts_are_counted_where_they_are_asked_for_and_change_nothing() -> None:
    scene = compose(decode({"name": "field", "boundary": "none", "seed": 5, "obstacles": []}), 0)
    runs = robot_runs(scene.field, ROBOTS["burger"], "straight", count=1, seed=1)
    states = []
    for counted in (True, False):
        world = mujoco_world.MujocoWorld(scene, runs)
        samples = drive_in_steps(world, runs, 1.0, world.step_seconds, contacts=counted)
        assert bool(samples) == counted
        states.append((world.data.qpos.tobytes(), world.shares()[runs[0].name]))
    (with_contacts, shares), (without, none) = states
    assert with_contacts == without
    assert len([part for part, share in shares.items() if "wheel" in part and share > 0.9]) == 2
    assert none == {}


def test_slips_are_those_of_mujocos_own_constraints_whichever_shape_comes_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A crawler drives up a step; MuJoCo has cylinders before boxes, and planes before both, in a contact."""
    own, slips = friction.corner_ellipse, list[tuple[float, float]]()

    def spy(halves: Any, slip: tuple[float, float], spent: Any) -> tuple[float, float]:
        slips.append(slip)
        return own(halves, slip, spent)

    monkeypatch.setattr(contacts, "corner_ellipse", spy)
    world = world_of("crawler", step_of(0.2), Pose(x=-1.8, y=0, z=0.005), motors="classic")
    world.step(300)
    world.drive("robot", robot_of("crawler"), 0.4, 0.0)
    is_first, differences = [], []
    for _ in range(1500):
        slips.clear()
        world.step(1)
        data = world.data
        for pair, row, slip in zip(data.contact.geom.tolist(), data.contact.efc_address.tolist(), slips, strict=True):
            if row >= 0:
                is_first.append(pair[0] > pair[1])
                differences.append(np.abs(slip - data.efc_vel[row + 1 : row + 3]).max())
    assert 100 < sum(is_first) < len(is_first) - 100
    assert np.percentile(differences, 95) < 0.01  # ours are of a step before
    assert np.percentile(np.array(differences)[is_first], 95) < 0.01
