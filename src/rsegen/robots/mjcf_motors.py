"""The motors of joints in a compiled model of MuJoCo: how fast they turn them, and with which torque.

An actuator gives a force f = gain u + bias_0 + bias_1 l + bias_2 l', of its control u and the length l that it moves,
which is the joint's angle times a gear. Without a spring (bias_1) it so turns a joint with the damping d and the
friction c at most at (gear gain u - c) / (d - bias_2 gear^2): a motor runs until they take all of its torque, a
velocity servo up to its control. The speed of a servo that pulls several joints is unknown. Cost: linear in the
actuators. What breaks it: muscles and actuators of other programs, which give neither; tendons that wrap around shapes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple


class Motor(NamedTuple):
    """The motor of a joint: the speed that it reaches without a load, rad/s, and its most torque, Nm; None: unknown."""

    rate: float | None
    torque: float | None


def motors(model: Any) -> dict[int, Motor]:
    """Return the motors of hinges and slides by the numbers of their joints; of several on a joint the strongest."""
    found: dict[int, Motor] = {}
    for actuator in range(model.nu):
        for joint, gear, is_alone in _moved(model, actuator):
            motor = _motor(model, actuator, joint, gear, is_alone=is_alone)
            other = found.get(joint)
            if other is None or (motor.torque or 0) > (other.torque or 0):
                found[joint] = motor
    return found


def _moved(model: Any, actuator: int) -> Iterator[tuple[int, float, bool]]:
    """Yield the hinges and slides that an actuator moves, with its gear, and whether it moves no other."""
    import mujoco

    kind, target = mujoco.mjtTrn(int(model.actuator_trntype[actuator])), int(model.actuator_trnid[actuator, 0])
    gear = float(model.actuator_gear[actuator, 0])
    if kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
        joints = [(target, gear)]
    elif kind == mujoco.mjtTrn.mjTRN_TENDON:
        first, count = int(model.tendon_adr[target]), int(model.tendon_num[target])
        joints = [
            (int(model.wrap_objid[wrap]), gear * float(model.wrap_prm[wrap]))
            for wrap in range(first, first + count)
            if mujoco.mjtWrap(int(model.wrap_type[wrap])) == mujoco.mjtWrap.mjWRAP_JOINT
        ]
    else:
        joints = []
    turning = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    for joint, own in joints:
        if own and mujoco.mjtJoint(int(model.jnt_type[joint])) in turning:
            yield joint, own, len(joints) == 1


def _motor(model: Any, actuator: int, joint: int, gear: float, *, is_alone: bool) -> Motor:
    import mujoco

    gear = abs(gear)
    most = float(abs(model.actuator_ctrlrange[actuator]).max()) if model.actuator_ctrllimited[actuator] else None
    kind, bias = (int(kinds[actuator]) for kinds in (model.actuator_gaintype, model.actuator_biastype))
    biases = (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)
    is_linear = mujoco.mjtGain(kind) == mujoco.mjtGain.mjGAIN_FIXED and mujoco.mjtBias(bias) in biases
    gain = float(model.actuator_gainprm[actuator, 0])
    _, spring, slope = (float(value) for value in model.actuator_biasprm[actuator, :3])
    torques = []
    if model.actuator_forcelimited[actuator]:
        torques.append(gear * float(abs(model.actuator_forcerange[actuator]).max()))
    if model.jnt_actfrclimited[joint]:
        torques.append(float(abs(model.jnt_actfrcrange[joint]).max()))
    rate = None
    if most is not None and is_linear:
        if mujoco.mjtDyn(int(model.actuator_dyntype[actuator])) == mujoco.mjtDyn.mjDYN_INTEGRATOR:
            rate = most / gear
        elif not spring:
            dof = int(model.jnt_dofadr[joint])
            torques.append(gear * abs(gain) * most)
            left = torques[-1] - float(model.dof_frictionloss[dof])
            slowing = float(model.dof_damping[dof]) - slope * gear**2
            rate = left / slowing if slowing > 0 and left > 0 else None
    return Motor(rate if is_alone or not slope else None, min(torques, default=None))
