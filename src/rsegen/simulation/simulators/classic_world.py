"""The world in a running Gazebo Classic, through its transport.

~/world_control, request, factory, model/modify     topics that change the world, or ask about it
~/response                                          the answer to a request, with its number
~/world_stats                                       the clock, five times a second, also of a paused server
~/pose/info, physics/contacts                       poses of what moves, and contacts, while somebody subscribes

Nothing in this protocol confirms a message, so whatever is ordered is asked about until it is done. What breaks it:
many messages at once, after which Gazebo 11 now and then stops publishing a topic, and a model of its world's name,
whose deletion would delete everything; both are avoided below.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import count
from secrets import randbelow
from typing import Any, ClassVar

from rsegen.errors import SimulatorFailed
from rsegen.robots.drives import Command
from rsegen.simulation.simulators.classic_transport import TransportClient, transport_client
from rsegen.simulation.simulators.live_world import Clock, Contact, LiveWorld, Pose
from rsegen.simulation.simulators.patience import Patience
from rsegen.simulation.simulators.wire import CLASSIC, contact_of, mesh_file, parse_text, pose_message, pose_of

_DELIVERY_TIME = 0.03
"""Seconds that a message between two programs on one machine takes at most.

With less, a world may step before a command has come, and a drive does not repeat; more is added to every command.
"""

_RESPONSES_TIME = 0.6
"""Seconds in which even a paused server has done a request and published all responses: three of its periods."""

_ASK_AGAIN = Patience(seconds=1.0)
"""Time after which a request is repeated: five periods of a paused server."""

_POSES = "pose/info"
"""The topic of the poses of models that have moved, and of their links, with the simulation time."""

_LINK = b"::"
"""Separator of names, which the names of links have and those of models have not."""

_FRAMES = {"camera": ("eye/link/camera/image", "ImageStamped"), "window": ("user_camera/pose", "Pose")}
"""The topic of each source of frames, a message a frame; the window sends at most thirty messages per second."""

_START = {"sec": 0, "nsec": 0}
"""The time of a world of which no pose has come yet."""

_HIDDEN_HEIGHT = 10_000.0
"""Height, metres, at which a model is hidden: out of sight, and above all models that are not."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ClassicWorld(LiveWorld):
    """The world in a Gazebo Classic server. A paused server answers, and publishes the time, five times a second."""

    between_looks: ClassVar[float] = _RESPONSES_TIME / 6

    client: TransportClient
    name: str
    backend: str = "classic"
    _numbers: Iterator[int] = field(default_factory=lambda: count(randbelow(2**30)))

    @property
    def is_current(self) -> bool:
        """Return whether the server's master holds its connection."""
        return self.client.is_connected

    def send_command(self, command: Command) -> None:
        """Publish the command, and wait the time that messages take."""
        self.client.publish(command.topic, command.type.rpartition(".")[2], parse_text(command.text))
        time.sleep(_DELIVERY_TIME)

    def step(self, steps: int) -> None:
        """Step, and wait as long as steps are being done."""
        target = self.clock().steps + steps
        self._step(steps)
        self._wait_for(target)

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Do the first step alone: of many in a row the server reports contacts late, and not all."""
        target = self.clock().steps + steps
        with self.client.subscribed("physics/contacts", "Contacts"):
            self._step(1)
            message = self.client.wait_for_message("physics/contacts", lambda _: True)
        self._step(steps - 1)
        self._wait_for(target)
        contacts = (
            contact_of((each["collision1"], each["collision2"]), each["position"]) for each in message["contact"]
        )
        return list(filter(None, contacts))

    def stop_recording(self) -> None:
        """Stop the record, and wait the time that messages take."""
        self.client.publish("log/control", "LogControl", {"stop": True})
        time.sleep(_DELIVERY_TIME)

    def clock(self) -> Clock:
        """Return the last clock that the server published."""
        now = self._statistics(after=-1)
        return Clock(
            simulated=_seconds(now["sim_time"]),
            real=_seconds(now["real_time"]),
            steps=int(now["iterations"]),
            paused=bool(now["paused"]),
        )

    def poses(self) -> Mapping[str, Pose]:
        """Return the poses of all models, by a request."""
        return {name: pose_of(model["pose"]) for name, model in self._models().items()}

    def last_poses(self) -> tuple[float, Mapping[str, Pose]]:
        """Return the last message of a topic that a server publishes at most sixty times a second."""
        self.client.subscribe(_POSES, "PosesStamped")
        message = self.client.last(_POSES) or {}
        poses = (CLASSIC.decode("Pose", raw) for raw in message.get("pose", []) if _LINK not in raw)
        return _seconds(message.get("time", _START)), {pose["name"]: pose_of(pose) for pose in poses}

    def frame_counter(self, source: str) -> Callable[[], int]:
        """Count pictures of the camera, or poses of the window's camera: one per frame, at most thirty a second."""
        topic, kind = _FRAMES[source]
        frames: list[None] = []
        self.client.subscribe(topic, kind, lambda _: frames.append(None))
        return lambda: len(frames)

    def mesh_files(self) -> Mapping[str, str]:
        """Return the files in the answer about poses; those of a map in a world file are relative to the world."""
        return {name: file for name, model in self._models().items() if (file := mesh_file(model))}

    def movable(self) -> Set[str]:
        """Return the models that do not say that they are static."""
        return frozenset(name for name, model in self._models().items() if not model.get("is_static"))

    def _move(self, name: str, pose: Pose) -> Pose:
        """Have the pose set by a modification of the model, hidden or not."""
        models = self._models(hidden=True)
        if name not in models:
            raise SimulatorFailed(f"Gazebo Classic: no model {name} to move")
        modified = {"name": name, "id": models[name]["id"], "pose": pose_message(pose)}
        self.client.publish("model/modify", "Model", modified)
        return pose_of(models[name]["pose"])

    def _spawn(self, name: str, sdf: str, pose: Pose) -> None:
        """Have it spawned by the factory; a model that was only hidden is moved back."""
        if name == self.name and name in self._models(hidden=True):
            self.move(name, pose)
        else:
            self.client.publish("factory", "Factory", {"sdf": sdf, "pose": pose_message(pose)})

    def _delete(self, name: str) -> None:
        """Have it deleted by a request; the many responses about its parts are muted.

        Gazebo 11 now and then stops publishing a topic after many messages at once. For the name of its world it would
        delete everything, so a model of that name is only hidden.
        """
        if name == self.name:
            self._move(name, Pose(x=0, y=0, z=_HIDDEN_HEIGHT))
            return
        with self.client.muted("response"):
            self.client.publish(
                "request", "Request", {"id": next(self._numbers), "request": "entity_delete", "data": name}
            )
            time.sleep(_RESPONSES_TIME)

    def _step(self, steps: int) -> None:
        if steps:
            self.client.publish("world_control", "WorldControl", {"multi_step": steps})

    def _wait_for(self, target: int) -> None:
        """Wait until a number of steps is done; SimulatorFailed if no further ones are done."""
        done = self.clock().steps
        while done < target:
            done = int(self._statistics(after=done)["iterations"])

    def _set_paused(self, *, paused: bool) -> None:
        self.client.clear("world_stats")
        self.client.publish("world_control", "WorldControl", {"pause": paused})
        self.client.wait_for_message("world_stats", lambda message: bool(message["paused"]) == paused)

    def _statistics(self, after: int) -> dict[str, Any]:
        """Return the first statistics with more steps than `after`."""
        return self.client.wait_for_message("world_stats", lambda message: message.get("iterations", 0) > after)

    def _asked(self, request: str, data: str) -> dict[str, Any]:
        """Return the response to a request, which is repeated: on a busy machine the server learns late who listens.

        All responses are waited for: who disconnects while one is about to be sent makes the server deaf (`close`).
        """
        request_id, wait, asked = next(self._numbers), self.client.patience.begin(), 0
        message = {"id": request_id, "request": request, "data": data}
        while not (answers := self._answers(request_id)):
            if wait.is_over or not self.is_current:
                raise SimulatorFailed(f"Gazebo Classic: no answer to {request} within {self.client.patience}")
            self.client.publish("request", "Request", message)
            asked += 1
            with suppress(SimulatorFailed):
                self.client.wait("no response", lambda: bool(self._answers(request_id)), _ASK_AGAIN)
        with suppress(SimulatorFailed):  # some got lost
            self.client.wait("no response", lambda: len(self._answers(request_id)) >= asked, _ASK_AGAIN)
        return answers[0]

    def _answers(self, request_id: int) -> list[dict[str, Any]]:
        """Return the responses to a request that have come."""
        answers = self.client.kept("response")
        return [answer for answer in answers if answer["id"] == request_id and "serialized_data" in answer]

    def _models(self, *, hidden: bool = False) -> dict[str, dict[str, Any]]:
        """Return the models by name, without or with hidden ones."""
        content = self._asked("entity_list", "")["serialized_data"]
        models = CLASSIC.decode("Model_V", content).get("models", [])
        return {model["name"]: model for model in models if hidden or model["pose"]["position"]["z"] < _HIDDEN_HEIGHT}


@contextmanager
def classic_world(address: tuple[str, int], patience: Patience) -> Iterator[ClassicWorld]:
    """A connection to the world of the server whose master is at a host and port; NothingRuns if there is none."""
    with transport_client(address, patience) as opened:
        opened.subscribe("world_stats", "WorldStatistics")
        opened.subscribe("response", "Response")
        yield ClassicWorld(client=opened, name=opened.world)


def _seconds(time_: Mapping[str, int]) -> float:
    return time_["sec"] + time_["nsec"] / 1e9
