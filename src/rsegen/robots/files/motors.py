"""Limits of the push of wheels and tracks: their motors' torque, their friction, in Gazebo Classic their inertia."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree.ElementTree import Element

from rsegen.robots.drives import Drive, Wheels
from rsegen.robots.files.sdf_elements import coefficient
from rsegen.robots.files.sdf_shapes import ModelFrames, inertia_tensor, inertials, positive_number
from rsegen.standing.resting import GRAVITY


class Motor(NamedTuple):
    """The motor of a wheel: the most torque that it gives, Nm, None if nothing limits it; and what says so."""

    torque: float | None
    origin: str

    def overcomes(self, friction: float) -> bool:
        """Return whether it turns its wheel against the friction of its joint, Nm."""
        return self.torque is None or self.torque > friction


def motor(drive: Wheels, joint: str, frames: ModelFrames) -> Motor:
    """Return the motor of a wheel: the lesser of its joint's effort and its plug-in's torque, of those that limit it.

    No effort, and one of 0 or below, limits nothing: wheels of files often have 0.
    """
    effort = positive_number(frames.joints[joint], frames.where, "axis/limit/effort")
    known = [
        Motor(torque, origin)
        for torque, origin in ((effort, "the <effort> of its joint"), (drive.torque, "the torque of its plug-in"))
        if torque is not None
    ]
    return min(known, default=Motor(None, "neither an <effort> of its joint nor the torque of a plug-in"))


_SLIPPERY = 0.01
"""Friction coefficient up to which wheels do not push: makers of omnidirectional robots have 0, and slide them."""


def frictions(drive: Drive, frames: ModelFrames) -> list[float]:
    """Return the friction coefficients of the shapes that a robot drives on; FileError for what is no number."""
    return [coefficient(shape, "mu", frames.where) for shape in _driving_shapes(drive, frames)]


def _driving_shapes(drive: Drive, frames: ModelFrames) -> list[Element]:
    """Return the collision shapes that a robot drives on."""
    links = drive.links(frames.child)
    return [collision for link, collision, _ in frames.collisions() if link in links]


def slippery_wheels(drive: Drive, frames: ModelFrames) -> str:
    """Return a sentence if what a robot drives on has no friction; an empty one if it has."""
    most = max(frictions(drive, frames), default=1.0)
    if most > _SLIPPERY:
        return ""
    return (
        f"the friction of what it drives on is {most:g} (<mu>, <mu1> in URDF), so it stands still: its maker slides it"
        " by a plug-in, which is not used, as it would push it through blocks; write 1 there"
    )


def yielding_wheels(drive: Drive, frames: ModelFrames) -> str:
    """Return a sentence if what a robot drives on slips under any force in Gazebo; an empty one if not.

    The speed of that slip is <slip1> or <slip2>, in m/s per N, times the force along <fdir1> or across it.
    """
    shapes = _driving_shapes(drive, frames)
    for name in ("slip1", "slip2"):
        slips = [positive_number(shape, frames.where, f"surface/friction/ode/{name}") for shape in shapes]
        if most := max(filter(None, slips), default=0.0):
            return (
                f"what it drives on has <{name}> {most:g}, so in Gazebo it slips under any force; MuJoCo leaves that"
                " out, and may predict that it crosses where Gazebo holds it"
            )
    return ""


_STEP = 0.001
"""Seconds of a step of Gazebo Classic, in which the speed of a wheel is written once."""

_LIGHT, _HEAVY = 3.0, 10.0
"""Times the weight of a robot below which the force of its wheels is too small for steps, and that is enough: in
MuJoCo without a reaction, a robot whose wheels had a quarter to 2 times its weight did not drive on, with 25 it did."""


def light_wheels(drive: Wheels, frames: ModelFrames, speed: float) -> str:
    """Return a sentence if wheels are too light for a drive without a torque, at a speed in m/s; an empty one if not.

    Gazebo Classic's drive writes the speed of a wheel in each step, which so has the momentum I v / r to give to the
    ground: a force of I v / (r^2 t) in a step of t seconds.
    """
    # The moment of each wheel about its axis, a . T a, with its tensor T turned into the model's frame.
    moments = []
    for joint in drive.joints:
        link = frames.child(joint)
        element, place, axis = frames.elements[link], frames.transform(link), frames.axis(joint)
        inertial = element.find("inertial")
        turn = (place if inertial is None else place @ frames.local(inertial))[:3, :3]
        moments.append(float(axis @ turn @ inertia_tensor(link, element, frames) @ turn.T @ axis))
    weight = GRAVITY * sum(body.mass for body in inertials(frames).values())
    newtons = sum(moments) * speed / (drive.radius**2 * _STEP)
    if newtons >= _LIGHT * weight:
        return ""
    enough = _HEAVY * weight * drive.radius**2 * _STEP / (speed * len(moments))
    return (
        f"its wheels are light: Gazebo Classic's drive sets their speed without a torque, so with {min(moments):.2g}"
        f" kg m^2 they push with {newtons:.3g} N at {speed:g} m/s, and the robot weighs {weight:.3g} N: a caster or a"
        f" step may stop it; set the inertia of each wheel about its axis to {enough:.1g} kg m^2, which is enough on"
        " level ground, or drive it in MuJoCo, whose motors have a torque unless they act as Classic's"
    )
