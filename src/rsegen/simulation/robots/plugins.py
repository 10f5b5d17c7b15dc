"""The text of a simulator's own plug-ins."""

from __future__ import annotations

from rsegen.exporters.gazebo.sdf import numbers


def classic(library: str, name: str, inner: str) -> str:
    """A plug-in of Gazebo Classic."""
    return f'      <plugin filename="lib{library}Plugin.so" name="{name}">{inner}</plugin>\n'


def system(kind: str, simulator: str, inner: str = "") -> str:
    """A system of Gazebo Sim: `DiffDrive` is gz-sim-diff-drive-system, or ignition-gazebo-... in Fortress."""
    file, space = ("gz-sim", "gz::sim") if simulator == "sim" else ("ignition-gazebo", "ignition::gazebo")
    words = "".join(f"-{letter.lower()}" if letter.isupper() else letter for letter in kind)
    return f'      <plugin filename="{file}{words}-system" name="{space}::systems::{kind}">{inner}</plugin>\n'


def element(tag: str, value: float | str) -> str:
    """<tag>value</tag>."""
    return f"<{tag}>{value if isinstance(value, str) else numbers([value])}</{tag}>"


def elements(tag: str, values: tuple[str, ...]) -> str:
    """The same tag with every value."""
    return "".join(element(tag, value) for value in values)
