"""The text of a simulator's own plug-ins."""

from __future__ import annotations

from rsegen.exporters.gazebo.sdf import numbers
from rsegen.exporters.gazebo.systems import system_name


def classic(library: str, name: str, inner: str) -> str:
    """A plug-in of Gazebo Classic."""
    return f'      <plugin filename="lib{library}Plugin.so" name="{name}">{inner}</plugin>\n'


def system(kind: str, simulator: str, inner: str = "") -> str:
    """A system of Gazebo Sim: `DiffDrive` is gz-sim-diff-drive-system, or ignition-gazebo-... in Fortress."""
    name = system_name(kind, simulator)
    return f'      <plugin filename="{name.library}" name="{name.class_name}">{inner}</plugin>\n'


POSE_RATE = 20
"""Poses of a robot in a simulated second, in Gazebo Sim."""


def pose_publisher(simulator: str) -> str:
    """The system of Gazebo Sim that publishes the pose of a model, from which drives are recorded.

    It publishes a model's pose only if that of nested models is wanted too.
    """
    wanted = element("publish_nested_model_pose", "true") + element("publish_model_pose", "true")
    what = wanted + element("publish_link_pose", "false") + element("update_frequency", POSE_RATE)
    return system("PosePublisher", simulator, what)


def element(tag: str, value: float | str) -> str:
    """<tag>value</tag>."""
    return f"<{tag}>{value if isinstance(value, str) else numbers([value])}</{tag}>"


def elements(tag: str, values: tuple[str, ...]) -> str:
    """The same tag with every value."""
    return "".join(element(tag, value) for value in values)
