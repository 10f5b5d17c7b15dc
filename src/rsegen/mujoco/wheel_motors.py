"""The motors of wheels: each brings its wheel to a speed, as far as its torque goes, and acts back on the chassis.

A motor is a friction of its joint that does not slow it to rest but to the speed that is commanded: MuJoCo solves it
together with the contacts, so a light wheel keeps its speed under any load, and a torque has a bound. An actuator with
a gain would be solved without the contacts: stiff enough to drive a wheel of 30 g, it shakes. Source: ODE's motors of
hinges, which Gazebo Classic's plug-ins use. Cost: one constraint per wheel. What breaks it: a sleeping tree of MuJoCo,
whose rows are left out; sleep is off by default.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from typing import Any

import numpy as np

from rsegen.mujoco.robot_model import RobotModel, weights
from rsegen.mujoco.settings import MOTOR_SOLIMP, MOTOR_SOLREF, STEP
from rsegen.robots.parameters import MOTORS

_STRONG = 1e6
"""Torque, Nm, of a motor without a limit of its own: the friction of its wheel limits it."""

_RAMP = 10.0
"""Acceleration, m/s^2, of a drive whose own is unknown: as much as friction lets a robot use. A motor that jumped to
its speed would throw the robot up by its reaction."""

_AT_LIMIT, _SLOW, _OFTEN = 0.999, 0.5, 0.2
"""Share of its torque from which on a motor is at its limit, of its speed below which a wheel is slow, and of the steps
from which on that is reported."""


class WheelMotors:
    """The motors of all wheels: the commanded speeds, and how much they may change in a step.

    motors: reaction, or classic, which writes the speed of a wheel
    owner: (wheels, 2) robot and side; dofs: degrees of freedom; react: whether motors act back; most: rad/s a step
    turns: whether the motor overcomes the friction of its joint
    """

    def __init__(self, model: Any, robots: Sequence[RobotModel], motors: str) -> None:
        wheels = [(index, robot.drive, wheel) for index, robot in enumerate(robots) for wheel in robot.wheels]
        self._robots, self._weights = robots, weights(model, robots)
        self.owner = np.array([(index, wheel.side) for index, _, wheel in wheels], dtype=int).reshape(-1, 2)
        self.dofs = np.array([model.joint(wheel.joint).dofadr[0] for *_, wheel in wheels], dtype=int)
        # Classic's drive writes the commanded speed at once: with a ramp, burgers cross 0.1 s later than there.
        self.react = motors == MOTORS[0] and bool(wheels)
        self.most = np.array(
            [
                (getattr(drive, "acceleration", None) or _RAMP) * STEP / drive.radius if self.react else inf
                for _, drive, _ in wheels
            ]
        )
        self._wanted, self._now = np.zeros(len(wheels)), np.zeros(len(wheels))
        self._has_changed = False
        self._added: list[tuple[int, float]] | None = []  # rows of the wheels, and what their speeds add to references
        # A wheel whose motor cannot overcome the friction of its joint stands still, held by the rest of that friction.
        nets = np.array([_STRONG if wheel.torque is None else wheel.torque - wheel.friction for *_, wheel in wheels])
        self._torques, self.turns = np.maximum(np.abs(nets), 1e-9), nets > 0
        self._steps, self._at_limit = 0, np.zeros(len(wheels), dtype=int)
        if self.react:
            model.dof_frictionloss[self.dofs] = self._torques
            model.dof_solref[self.dofs], model.dof_solimp[self.dofs] = MOTOR_SOLREF, MOTOR_SOLIMP
            # MuJoCo has a row of friction for each degree of freedom that has some, in their order.
            self._rows = np.searchsorted(np.flatnonzero(model.dof_frictionloss), self.dofs)
        else:  # the speed of a wheel is written, so brakes of it would act on the chassis alone, and push it back
            model.dof_damping[self.dofs[self.turns]] = model.dof_frictionloss[self.dofs[self.turns]] = 0
        self._is_limited = bool((self._torques < _STRONG).any())
        # Of each wheel: its row, degree of freedom, force at its motor's limit, and the speed below which it is slow.
        self._limits: list[tuple[int, int, float, float]] = []

    def command(self, robot: int, left: float, right: float) -> None:
        """Set the speeds of a robot's wheels, rad/s."""
        own = self.owner[:, 0] == robot
        self._wanted[own] = np.where(self.owner[own, 1] == 0, left, right)
        self._has_changed = True

    def stop(self) -> None:
        """Stop all wheels at once."""
        self._wanted[:] = self._now[:] = 0
        self._has_changed = True

    def before_step(self, data: Any) -> None:
        """Bring speeds nearer to the commanded ones; without a reaction, write them."""
        if self._has_changed:
            self._now += np.clip(self._wanted - self._now, -self.most, self.most)
            self._has_changed = not np.array_equal(self._now, self._wanted)
            if self.react:
                self._added = None
                forces = np.where(self.turns, _AT_LIMIT * self._torques, -1.0)
                columns = self._rows, self.dofs, forces, _SLOW * np.abs(self._now)
                self._limits = list(zip(*(column.tolist() for column in columns), strict=True))
        if not self.react and len(self.dofs):
            data.qvel[self.dofs] = self._now

    def turn(self, data: Any) -> None:
        """Add the speeds to the references of the friction rows, which MuJoCo has made for rest."""
        if not self.react:
            return
        first = data.ne  # rows of equalities come before those of friction
        if self._added is None:
            gains = data.efc_KBIP[first + self._rows, 1]  # the same in all steps
            self._added = list(zip(self._rows.tolist(), (gains * (self._now * self.turns)).tolist(), strict=True))
        # A robot has two or four wheels: one by one they take a quarter of the time of numpy's arrays.
        references = data.efc_aref
        for row, added in self._added:
            references[first + row] += added

    def after_step(self, data: Any) -> None:
        """Count the steps in which a motor is at its limit and its wheel is slow."""
        self._steps += 1
        if self.react and self._is_limited:
            forces, speeds, first = data.efc_force, data.qvel, data.ne
            for wheel, (row, dof, force, speed) in enumerate(self._limits):
                if abs(speeds[dof]) < speed and abs(forces[first + row]) > force:
                    self._at_limit[wheel] += 1

    def notes(self) -> Iterator[str]:
        """Yield a sentence for each robot whose motors are too weak for where it is."""
        for index, robot in enumerate(self._robots):
            own = self.owner[:, 0] == index
            share = self._at_limit[own].max(initial=0) / max(self._steps, 1)
            if share < _OFTEN:
                continue
            torque = min(wheel.torque for wheel in robot.wheels if wheel.torque is not None)
            slips = self._weights[index] * robot.drive.radius / len(robot.wheels)  # with a coefficient of 1
            rubs = max(wheel.friction for wheel in robot.wheels)
            own_friction = f", of which their joints take {rubs:.3g} Nm" if rubs else ""
            yield (
                f"{robot.name}: the motors of its wheels are too weak for {share:.0%} of the time: its model has "
                f"{torque:.3g} Nm for each{own_friction}; wheels slip on the ground from {slips:.3g} Nm on"
            )
