"""Joints that are held at an angle: flippers and arms."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rsegen.exporters.gazebo.sdf import numbers
from rsegen.simulation.robots.commands import Command, publish_command
from rsegen.simulation.robots.plugins import classic, element, system


@dataclass(frozen=True, kw_only=True, slots=True)
class Servo:
    """A motor with a spring and a damper: gains in Nm/rad and Nm s/rad; rest: its angle at the start, radians."""

    joint: str
    stiffness: float
    damping: float
    effort: float
    rest: float = 0

    def command(self, name: str, angle: float, simulator: str) -> Command:
        """The command that turns it to an angle, radians.

        Classic 11 listens on a topic of Ignition Transport, which its own `gz joint` knows.
        """
        if simulator != "classic":
            return publish_command(topic(name, self.joint), "Double", f"data: {numbers([angle])}", simulator)
        text = f'name: "{name}::{self.joint}" position {{ target {{ data: {numbers([angle])} }} }}'
        gains = ("--pos-p", numbers([self.stiffness]), "--pos-d", numbers([self.damping]))
        shell = ("gz", "joint", "-m", name, "-j", self.joint, "--pos-t", numbers([angle]), *gains)
        return Command(f"/{name}/joint_cmd", "ignition.msgs.JointCmd", text, shell)


def topic(name: str, joint: str) -> str:
    """The topic of Gazebo Sim's JointPositionController."""
    return f"/model/{name}/joint/{joint}/0/cmd_pos"


def servo_plugins(servos: tuple[Servo, ...], simulator: str) -> str:
    """One JointControl in Classic, a JointPositionController for each in Gazebo Sim."""
    if not servos:
        return ""
    if simulator == "classic":
        return classic("JointControl", "servos", "\n" + "".join(_controllers(servos)) + "      ")
    return "".join(system("JointPositionController", simulator, _gains(servo)) for servo in servos)


def _controllers(servos: tuple[Servo, ...]) -> Iterable[str]:
    for servo in servos:
        gains = element("pid_gains", numbers([servo.stiffness, 0, servo.damping]))
        inner = element("joint", servo.joint) + element("target", servo.rest) + gains
        yield f'        <controller type="position">{inner}</controller>\n'


def _gains(servo: Servo) -> str:
    gains = element("p_gain", servo.stiffness) + element("i_gain", 0) + element("d_gain", servo.damping)
    limits = element("cmd_max", servo.effort) + element("cmd_min", -servo.effort)
    return element("joint_name", servo.joint) + gains + limits + element("initial_position", servo.rest)
