"""The world in a running Gazebo Sim, through its commands for services and topics.

    gz service -s /world/NAME/control --reqtype gz.msgs.WorldControl --reptype gz.msgs.Boolean --timeout MS --req TEXT
    gz topic -e -t /world/NAME/stats -n 1

In Fortress the same with `ign` and ignition.msgs.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import SimulatorFailed
from rsegen.simulation.robots.commands import Command, message_type
from rsegen.simulation.simulators.base import LaunchCommand
from rsegen.simulation.simulators.live_world import Clock, LiveWorld, Pose, model_name
from rsegen.simulation.simulators.pose_messages import is_nearer, pose_message, pose_of
from rsegen.simulation.simulators.process import output_of
from rsegen.simulation.simulators.sim_messages import Message, format_message, parse

TIMEOUT = 60.0
"""Seconds for an answer."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SimWorld(LiveWorld):
    """The world in a Gazebo Sim server; every call runs a command, which takes about half a second."""

    program: Path
    backend: str
    environment: Mapping[str, str]
    world: str = ""

    def send_command(self, command: Command) -> None:
        """Publish the command on its topic."""
        self.run("topic", "-t", command.topic, "-m", command.type, "-p", command.text)

    def step(self, steps: int) -> None:
        """Step, and wait as long as steps are being done."""
        target = self.clock().steps + steps
        self._order("control", "WorldControl", {"pause": True, "multi_step": steps})
        done, end = 0, time.monotonic() + TIMEOUT
        while done < target:
            before, done = done, self.clock().steps
            end = time.monotonic() + TIMEOUT if done > before else end
            if time.monotonic() > end:
                raise SimulatorFailed(f"Gazebo Sim: stopped at step {done} of {target}")

    def unpause(self) -> None:
        """Unpause, and wait until the server reports it."""
        self._order("control", "WorldControl", {"pause": False})
        self._wait("the world stays paused", lambda: not self.clock().paused)

    def pause(self) -> None:
        """Pause, and wait until the server reports it."""
        self._order("control", "WorldControl", {"pause": True})
        self._wait("the world is not paused", lambda: self.clock().paused)

    def clock(self) -> Clock:
        """The next clock that the server publishes."""
        now = self._topic("stats")
        return Clock(
            simulated=_seconds(now, "sim_time"),
            real=_seconds(now, "real_time"),
            steps=int(now.values.get("iterations", 0)),
            paused=now.values.get("paused") == "true",
        )

    def poses(self) -> Mapping[str, Pose]:
        """The scene lists the models and their first poses; a topic has their current poses."""
        moved = {pose.values["id"]: pose for pose in self._topic("pose/info").parts["pose"]}
        return {name: _pose(moved.get(model.values["id"]) or model.parts["pose"][0]) for name, model in self._models()}

    def movable(self) -> Set[str]:
        """The models in the topic of poses that are not static."""
        moving = {pose.values["id"] for pose in self._topic("dynamic_pose/info").parts["pose"]}
        return frozenset(name for name, model in self._models() if model.values["id"] in moving)

    def move(self, name: str, pose: Pose) -> None:
        """Set the pose of a model by a service."""
        before = self.poses().get(name)
        if before is None:
            raise SimulatorFailed(f"Gazebo Sim: no model {name} to move")
        self._order("set_pose", "Pose", {"name": name, **pose_message(pose)})
        self._wait(f"{name} stays where it was", lambda: is_nearer(self.poses()[name], pose, before))

    def spawn(self, sdf: str, pose: Pose) -> None:
        """Spawn by a service, under the name in the text."""
        name = model_name(sdf)
        self._order("create", "EntityFactory", {"sdf": sdf, "pose": pose_message(pose)})
        self._wait(f"{name} does not appear", lambda: name in dict(self._models()))

    def delete(self, name: str) -> None:
        """Delete by a service."""
        self._order("remove", "Entity", {"name": name, "type": 2})
        self._wait(f"{name} is still there", lambda: name not in dict(self._models()))

    def run(self, *arguments: str) -> str:
        """The output of its program."""
        command = (str(self.program), *arguments)
        return output_of(LaunchCommand(command=command, environment=self.environment, folder=Path.cwd()), TIMEOUT)

    def _models(self) -> list[tuple[str, Message]]:
        scene = self._service("scene/info", "Empty", {}, "Scene")
        return [(model.values["name"], model) for model in scene.parts["model"]]

    def _topic(self, name: str) -> Message:
        return parse(self.run("topic", "-e", "-t", f"/world/{self.world}/{name}", "-n", "1"))

    def _order(self, name: str, type_name: str, message: Mapping[str, object]) -> None:
        if self._service(name, type_name, message, "Boolean").values.get("data") != "true":
            raise SimulatorFailed(f"Gazebo Sim: /world/{self.world}/{name} refuses")

    def _service(self, name: str, asked: str, message: Mapping[str, object], answered: str) -> Message:
        types = ("--reqtype", message_type(asked, self.backend), "--reptype", message_type(answered, self.backend))
        wait = ("--timeout", f"{TIMEOUT / 2 * 1000:.0f}")
        said = self.run("service", "-s", f"/world/{self.world}/{name}", *types, *wait, "--req", format_message(message))
        if "timed out" in said:
            raise SimulatorFailed(f"Gazebo Sim: /world/{self.world}/{name} does not answer")
        return parse(said)

    def _wait(self, otherwise: str, until: Callable[[], bool]) -> None:
        end = time.monotonic() + TIMEOUT
        while not until():
            if time.monotonic() > end:
                raise SimulatorFailed(f"Gazebo Sim: {otherwise}")


@contextmanager
def sim_world(program: Path, backend: str, environment: Mapping[str, str]) -> Iterator[SimWorld]:
    """The first world that a program, `gz` or `ign`, finds with these variables."""
    asking = SimWorld(program=program, backend=backend, environment=environment)
    found = re.search(r"^/world/([^/\s]+)/control\s*$", asking.run("service", "-l"), re.MULTILINE)
    if not found:
        partition = environment.get("GZ_PARTITION") or environment.get("IGN_PARTITION")
        raise SimulatorFailed("Gazebo Sim: no world is running" + f" in GZ_PARTITION={partition}" * bool(partition))
    yield SimWorld(program=program, backend=backend, environment=environment, world=found[1])


def _seconds(now: Message, name: str) -> float:
    parts = now.parts[name]
    return int(parts[0].values.get("sec", 0)) + int(parts[0].values.get("nsec", 0)) / 1e9 if parts else 0.0


def _pose(message: Message) -> Pose:
    return pose_of({name: inner[0].values for name, inner in message.parts.items() if inner})
