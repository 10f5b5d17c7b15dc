"""Commands to robots: a topic, a message type, and the message as text."""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple

from rsegen.exporters.gazebo.sdf import numbers

BACKENDS = ("classic", "sim", "fortress")
"""Gazebo Classic 11; Gazebo Sim since Garden; Gazebo Sim up to Fortress, whose names begin with ignition."""


class Command(NamedTuple):
    """One message, and the shell command that publishes it once, which in Gazebo Sim may be lost: repeat it there."""

    topic: str
    type: str
    text: str
    shell: tuple[str, ...]


def publish_command(topic: str, message: str, text: str, simulator: str) -> Command:
    """A message to a topic by the simulator's own tool; `message` is a type without its package."""
    kind = message_type(message, simulator)
    if simulator == "classic":
        return Command(topic, kind, text, ("gz", "topic", "-p", topic, "-m", text))
    return Command(topic, kind, text, (_TOOLS[simulator], "topic", "-t", topic, "-m", kind, "-p", text))


_TOOLS = {"sim": "gz", "fortress": "ign"}


def pose_text(v: float, w: float) -> str:
    """Speeds as Classic's wheeled drives take them: v as x, w as the yaw of an orientation, so |w| < pi."""
    x, half = numbers([v]), w / 2
    turned = f"x: 0 y: 0 z: {numbers([sin(half)])} w: {numbers([cos(half)])}"
    return f"position {{ x: {x} y: 0 z: 0 }} orientation {{ {turned} }}"


def twist_text(v: float, w: float) -> str:
    """Speeds as every other drive takes them."""
    return f"linear {{ x: {numbers([v])} y: 0 z: 0 }} angular {{ x: 0 y: 0 z: {numbers([w])} }}"


def message_type(message: str, simulator: str) -> str:
    """The full name of a message type, as in gazebo.msgs.Twist, gz.msgs.Twist or ignition.msgs.Twist."""
    package = {"classic": "gazebo", "sim": "gz", "fortress": "ignition"}[simulator]
    return f"{package}.msgs.{message}"
