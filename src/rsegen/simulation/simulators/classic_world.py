"""A world in a running Gazebo Classic."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from secrets import randbelow
from statistics import fmean
from typing import Any

from rsegen.errors import SimulatorFailed
from rsegen.simulation.robots.commands import Command
from rsegen.simulation.simulators.classic_messages import decoded, said
from rsegen.simulation.simulators.classic_transport import TIMEOUT, TransportClient, line
from rsegen.simulation.simulators.live_world import Clock, Contact, LiveWorld, Pose, model_name
from rsegen.simulation.simulators.pose_messages import heard, is_nearer, told

_SETTLE = 0.03
"""Seconds in which a message between two programs on one machine arrives."""

_FLOOD = 0.6
"""Seconds in which even a paused server has done what it was told, and said so."""

_AWAY = 10_000.0
"""Metres above the ground: out of sight."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ClassicWorld(LiveWorld):
    """Through one line. A paused server answers, and tells the time, five times a second."""

    line: TransportClient
    backend: str = "classic"
    _numbers: Iterator[int] = field(default_factory=lambda: count(randbelow(2**30)))

    def send_command(self, command: Command) -> None:
        """A moment later it is heard."""
        self.line.say(command.topic, command.type.rpartition(".")[2], said(command.text))
        time.sleep(_SETTLE)

    def step(self, steps: int) -> None:
        """Waits as long as steps are being done."""
        target = self.clock().steps + steps
        self._step(steps)
        self._wait_for(target)

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """The first step is done by itself: of many in a row the server tells late, and not of all."""
        target = self.clock().steps + steps
        with self.line.hearing("physics/contacts", "Contacts"):
            self._step(1)
            told = self.line.heard("physics/contacts", lambda _: True)
        self._step(steps - 1)
        self._wait_for(target)
        return [_contact(one) for one in told.get("contact", [])]

    def unpause(self) -> None:
        """Not paused, once it says so."""
        self._pause(pause=False)

    def pause(self) -> None:
        """Paused, once it says so."""
        self._pause(pause=True)

    def stop_recording(self) -> None:
        """A moment later it has heard."""
        self.line.say("log/control", "LogControl", {"stop": True})
        time.sleep(_SETTLE)

    def clock(self) -> Clock:
        """As it was told last."""
        now = self._statistics(after=-1)
        return Clock(
            simulated=_seconds(now["sim_time"]),
            real=_seconds(now["real_time"]),
            steps=int(now["iterations"]),
            paused=bool(now["paused"]),
        )

    def poses(self) -> Mapping[str, Pose]:
        """Of all its models, asked for."""
        return {name: heard(model["pose"]) for name, model in self._models().items()}

    def links(self) -> Mapping[str, Pose]:
        """Where every link stands in its model, by its full name."""
        links = (link for model in self._models().values() for link in model.get("link", []))
        return {link["name"]: heard(link["pose"]) for link in links}

    def movable(self) -> Set[str]:
        """Each model says whether it is static."""
        return frozenset(name for name, model in self._models().items() if not model.get("is_static"))

    def move(self, name: str, pose: Pose) -> None:
        """By its name and number."""
        message = self._modified(name, pose)
        before = heard(self._models(hidden=True)[name]["pose"])
        self.line.say("model/modify", "Model", message)
        self._wait(
            f"{name} stays where it was", lambda: name in (at := self.poses()) and is_nearer(at[name], pose, before)
        )

    def spawn(self, sdf: str, pose: Pose) -> None:
        """Through the factory; the one that was only out of sight comes back."""
        name = model_name(sdf)
        if name == self.line.world and name in self._models(hidden=True):
            self.move(name, pose)
            return
        self.line.say("factory", "Factory", {"sdf": sdf, "pose": told(pose)})
        self._wait(f"{name} does not appear", lambda: name in self.poses())

    def delete(self, name: str) -> None:
        """By a request; that each of its parts is gone too is told in a flood of responses, which are not listened to.

        Gazebo 11 now and then falls silent on a topic where it says much at once. It would delete all there is for the
        name of its world, so a model of that name is only put out of sight.
        """
        if name == self.line.world:
            self.line.say("model/modify", "Model", self._modified(name, Pose(x=0, y=0, z=_AWAY)))
            self._wait(f"{name} is still there", lambda: name not in self._models())
            return
        with self.line.deaf("response"):
            self.line.say("request", "Request", {"id": next(self._numbers), "request": "entity_delete", "data": name})
            time.sleep(_FLOOD)
        self._wait(f"{name} is still there", lambda: name not in self.poses())

    def _step(self, steps: int) -> None:
        if steps:
            self.line.say("world_control", "WorldControl", {"multi_step": steps})

    def _wait_for(self, target: int) -> None:
        """As long as steps are being done."""
        done = self.clock().steps
        while done < target:
            done = int(self._statistics(after=done)["iterations"])

    def _pause(self, *, pause: bool) -> None:
        self.line.forget("world_stats")
        self.line.say("world_control", "WorldControl", {"pause": pause})
        self.line.heard("world_stats", lambda told: bool(told["paused"]) == pause)

    def _statistics(self, after: int) -> dict[str, Any]:
        """The first that tells of more steps than so many."""
        return self.line.heard("world_stats", lambda told: told.get("iterations", 0) > after)

    def _asked(self, request: str, data: str) -> dict[str, Any]:
        number = next(self._numbers)
        self.line.say("request", "Request", {"id": number, "request": request, "data": data})
        return self.line.heard("response", lambda told: told["id"] == number and "serialized_data" in told)

    def _modified(self, name: str, pose: Pose) -> dict[str, Any]:
        """A model as it is to be."""
        models = self._models(hidden=True)
        if name not in models:
            raise SimulatorFailed(f"Gazebo Classic: no {name} to be moved")
        return {"name": name, "id": models[name]["id"], "pose": told(pose)}

    def _models(self, *, hidden: bool = False) -> dict[str, dict[str, Any]]:
        """All that are not out of sight, or these too."""
        content = self._asked("entity_list", "")["serialized_data"]
        models = decoded("Model_V", content).get("models", [])
        return {model["name"]: model for model in models if hidden or model["pose"]["position"]["z"] < _AWAY}

    def _wait(self, otherwise: str, until: Callable[[], bool]) -> None:
        end = time.monotonic() + TIMEOUT
        while not until():
            if time.monotonic() > end:
                raise SimulatorFailed(f"Gazebo Classic: {otherwise}")
            time.sleep(_FLOOD / 6)


@contextmanager
def classic_world(address: tuple[str, int]) -> Iterator[ClassicWorld]:
    """The world of the server whose master is at a host and port, as long as this lasts."""
    with line(address) as opened:
        opened.hear("world_stats", "WorldStatistics")
        opened.hear("response", "Response")
        yield ClassicWorld(line=opened)


def _contact(message: Mapping[str, Any]) -> Contact:
    points = [(point["x"], point["y"], point["z"]) for point in message["position"]]
    x, y, z = (fmean(along) for along in zip(*points, strict=True))
    return Contact(collisions=(message["collision1"], message["collision2"]), position=(x, y, z))


def _seconds(time_: Mapping[str, int]) -> float:
    return time_["sec"] + time_["nsec"] / 1e9
