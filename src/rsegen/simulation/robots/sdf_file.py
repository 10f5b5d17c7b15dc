"""A robot from an SDF file of the user, which is parsed as untrusted input."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from rsegen.errors import FileError, ParameterError, shown
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.io.text_files import elements, text_of
from rsegen.simulation.robots.commands import Command, pose_text, publish_command, twist_text
from rsegen.simulation.robots.links import ORIGIN, PoseTuple
from rsegen.simulation.robots.plugins import pose_publisher
from rsegen.simulation.robots.solids import Vector

MAX_MIB = 4
"""The largest file that is read: a second's work for the parser."""

_CLASSIC = {"libDiffDrivePlugin": "vel_cmd", "libSkidSteerDrivePlugin": "vel_cmd"} | dict.fromkeys(
    ("libSimpleTrackedVehiclePlugin", "libWheelTrackedVehiclePlugin"), "cmd_vel_twist"
)
_SYSTEM = re.compile(r"(?:lib)?(?:gz-sim|ignition-gazebo)\d*-(?:diff-drive|tracked-vehicle)-system(?:\.so)?")


@dataclass(frozen=True, kw_only=True, slots=True)
class SdfRobot:
    """A robot from a file: its name, its <model> as text, the backend and the topic of its drive.

    backend and topic are None if no drive in it is known; then it cannot be commanded. {name} in the topic is replaced
    by its name in the world. size, speed and turn are given by the user.
    """

    kind: str
    text: str
    backend: str | None = None
    topic: str | None = None
    size: Vector = (0.5, 0.5, 0.5)
    speed: float = 0.2
    turn: float = 0.5

    def model(self, name: str, simulator: str = "classic", at: PoseTuple = ORIGIN) -> str:
        """Its <model> under a name, with its origin at a pose."""
        model = ElementTree.fromstring(self.text)  # noqa: S314  # was found to be plain elements
        model.set("name", name)
        pose = model.find("pose")
        pose = ElementTree.Element("pose") if pose is None else pose
        if pose not in list(model):
            model.insert(0, pose)
        pose.text = numbers(at)
        if simulator != "classic":
            model.append(ElementTree.fromstring(pose_publisher(simulator)))  # noqa: S314  # ours
        return _outer(model)

    def command(self, name: str, v: float, w: float, simulator: str = "classic") -> Command:
        """The command for speed v forward, m/s, and turn rate w, rad/s."""
        if self.topic is None or self.backend is None:
            raise ParameterError(self.kind, "no drive that rsegen knows, so it cannot be commanded")
        if self.backend != simulator:
            raise ParameterError(self.kind, f"its drive is for {self.backend}, not for {simulator}")
        topic = self.topic.replace("{name}", name)
        if topic.endswith("vel_cmd") and simulator == "classic":
            return publish_command(topic, "Pose", pose_text(v, w), "classic")
        return publish_command(topic, "Twist", twist_text(v, w), simulator)


def from_file(path: str | Path) -> SdfRobot:
    """The robot of the one model in an SDF file; FileError if the file has anything else."""
    return parsed(text_of(Path(path), MAX_MIB, "a robot"), str(path))


def parsed(text: str, where: str) -> SdfRobot:
    """The one model in a text of SDF; a document type and entities are refused, as bombs are made of them."""
    model = _model(elements(text, where), where)
    simulator, topic = _drive(model)
    return SdfRobot(kind=model.get("name", ""), text=_outer(model), backend=simulator, topic=topic)


def _model(root: ElementTree.Element, where: str) -> ElementTree.Element:
    found = root.findall("model")
    if root.tag != "sdf" or len(found) != 1 or root.find("world") is not None:
        raise FileError(f"{where}: not an SDF file with one <model> in <sdf>")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", found[0].get("name", "")):
        raise FileError(f"{where}: the model's name {shown(found[0].get('name'))} is not letters, digits and _")
    if found[0].find("link") is None and found[0].find("include") is None and found[0].find("model") is None:
        raise FileError(f"{where}: the model has no <link>")
    return found[0]


def _drive(model: ElementTree.Element) -> tuple[str | None, str | None]:
    """Simulator and topic of the first drive that is known."""
    for plugin in model.iter("plugin"):
        file = plugin.get("filename", "")
        if told := _CLASSIC.get(file.removesuffix(".so")):
            return "classic", f"~/{plugin.findtext('robot_namespace', '{name}').strip()}/{told}"
        if _SYSTEM.fullmatch(file):
            topic = plugin.findtext("topic", "/model/{name}/cmd_vel").strip()
            return "fortress" if "ignition" in file else "sim", topic
    return None, None


def _outer(model: ElementTree.Element) -> str:
    model.tail = "\n"
    return ElementTree.tostring(model, encoding="unicode")
