"""A world in a running Gazebo Classic."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from typing import Any, cast

from rsegen.errors import SimulatorFailed
from rsegen.robots.commands import Command
from rsegen.simulators.classic_line import PATIENCE, Line, line
from rsegen.simulators.classic_messages import Message, decoded, said
from rsegen.simulators.live import Clock, LiveWorld, Pose

_SETTLE = 0.03
"""Seconds in which a message between two programs on one machine arrives."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ClassicWorld(LiveWorld):
    """Through one line. A paused server answers, and tells the time, five times a second."""

    line: Line
    _numbers: Iterator[int] = field(default_factory=lambda: count(1))

    def tell(self, command: Command) -> None:
        """A moment later it is heard."""
        self.line.say(command.topic, command.type.rpartition(".")[2], said(command.text))
        time.sleep(_SETTLE)

    def advance(self, steps: int) -> None:
        """Waits as long as steps are being done."""
        done = self.clock().steps
        target = done + steps
        self.line.say("world_control", "WorldControl", {"multi_step": steps})
        while done < target:
            before = done
            done = int(self._statistics(after=before)["iterations"])

    def go(self) -> None:
        """Not paused."""
        self.line.say("world_control", "WorldControl", {"pause": False})

    def stand(self) -> None:
        """Paused, once it says so."""
        self.line.say("world_control", "WorldControl", {"pause": True})
        self.line.heard("world_stats", lambda told: bool(told.get("paused")))

    def clock(self) -> Clock:
        """As it was told last."""
        told = self._statistics(after=-1)
        return Clock(
            simulated=_seconds(told["sim_time"]), real=_seconds(told["real_time"]), steps=int(told["iterations"])
        )

    def poses(self) -> Mapping[str, Pose]:
        """Of all its models, asked for."""
        return {model["name"]: _pose(model["pose"]) for model in self._models()}

    def links(self) -> Mapping[str, Pose]:
        """Where every link stands in its model, by its full name."""
        links = (link for model in self._models() for link in model.get("link", []))
        return {link["name"]: _pose(link["pose"]) for link in links}

    def put(self, sdf: str, pose: Pose) -> None:
        """Through the factory."""
        name = _model_name(sdf)
        self.line.say("factory", "Factory", {"sdf": sdf, "pose": _message(pose)})
        self._wait_for(name, there=True)

    def take(self, name: str) -> None:
        """By a request."""
        self.line.say("request", "Request", {"id": next(self._numbers), "request": "entity_delete", "data": name})
        self._wait_for(name, there=False)

    def _models(self) -> Sequence[Message]:
        answer = self._asked("entity_list", "")
        return cast(Sequence[Message], decoded("Model_V", answer.get("serialized_data", b"")).get("models", []))

    def _statistics(self, after: int) -> dict[str, Any]:
        """The first that tells of more steps than so many."""
        return self.line.heard("world_stats", lambda told: told.get("iterations", 0) > after)

    def _asked(self, request: str, data: str) -> dict[str, Any]:
        number = next(self._numbers)
        self.line.say("request", "Request", {"id": number, "request": request, "data": data})
        return self.line.heard("response", lambda told: told["id"] == number)

    def _wait_for(self, name: str, *, there: bool) -> None:
        end = time.monotonic() + PATIENCE
        while (name in self.poses()) != there:
            if time.monotonic() > end:
                raise SimulatorFailed(f"Gazebo Classic: {name} is still {'not ' * there}there")


@contextmanager
def classic_world(address: tuple[str, int]) -> Iterator[ClassicWorld]:
    """The world of the server whose master is at a host and port, as long as this lasts."""
    with line(address) as opened:
        opened.hear("world_stats", "WorldStatistics")
        opened.hear("response", "Response")
        yield ClassicWorld(line=opened)


def _model_name(sdf: str) -> str:
    found = re.search(r"<model\s+name=['\"]([^'\"]+)['\"]", sdf)
    if not found:
        raise SimulatorFailed("there is no model in what is to be put into the world")
    return found[1]


def _seconds(told: Mapping[str, int]) -> float:
    return told["sec"] + told["nsec"] / 1e9


def _message(pose: Pose) -> dict[str, Any]:
    """Roll, pitch and yaw as a quaternion."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (pose.roll, pose.pitch, pose.yaw))
    turned = {
        "w": cr * cp * cy + sr * sp * sy,
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
    }
    return {"position": {"x": pose.x, "y": pose.y, "z": pose.z}, "orientation": turned}


def _pose(told: Mapping[str, Mapping[str, float]]) -> Pose:
    at, q = told["position"], told["orientation"]
    x, y, z, w = q["x"], q["y"], q["z"], q["w"]
    return Pose(
        x=at["x"],
        y=at["y"],
        z=at["z"],
        roll=math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        pitch=math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))),
        yaw=math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )
