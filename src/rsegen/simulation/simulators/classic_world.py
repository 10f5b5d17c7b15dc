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
from statistics import fmean
from typing import Any

from rsegen.errors import SimulatorFailed
from rsegen.robots.drives import Command
from rsegen.simulation.simulators.classic_transport import TransportClient, transport_client
from rsegen.simulation.simulators.live_world import Clock, Contact, LiveWorld, Pose, model_name, wait_until
from rsegen.simulation.simulators.patience import Patience
from rsegen.simulation.simulators.wire import CLASSIC, is_nearer, mesh_file, parse_text, pose_message, pose_of

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

    client: TransportClient
    backend: str = "classic"
    _numbers: Iterator[int] = field(default_factory=lambda: count(randbelow(2**30)))

    @property
    def name(self) -> str:
        """The name in the topics of its server."""
        return self.client.world

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
        return [_contact(contact) for contact in message["contact"] if contact["position"]]

    def unpause(self) -> None:
        """Unpause, and wait until the server reports it."""
        self._pause(pause=False)

    def pause(self) -> None:
        """Pause, and wait until the server reports it."""
        self._pause(pause=True)

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
        if not self.client.is_subscribed(_POSES):
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

    def move(self, name: str, pose: Pose) -> None:
        """Set the pose by a modification of the model."""
        model = self._model(name)
        before = pose_of(model["pose"])
        self.client.publish("model/modify", "Model", _modified(model, pose))
        self._wait(
            f"{name} stays where it was", lambda: name in (at := self.poses()) and is_nearer(at[name], pose, before)
        )

    def spawn(self, sdf: str, pose: Pose) -> None:
        """Spawn through the factory; a model that was only hidden is moved back."""
        name = model_name(sdf)
        if name == self.client.world and name in self._models(hidden=True):
            self.move(name, pose)
            return
        self.client.publish("factory", "Factory", {"sdf": sdf, "pose": pose_message(pose)})
        self._wait(f"{name} does not appear", lambda: name in self.poses())

    def delete(self, name: str) -> None:
        """Delete by a request; the many responses about its parts are muted.

        Gazebo 11 now and then stops publishing a topic after many messages at once. For the name of its world it would
        delete everything, so a model of that name is only hidden.
        """
        if name == self.client.world:
            hidden = _modified(self._model(name), Pose(x=0, y=0, z=_HIDDEN_HEIGHT))
            self.client.publish("model/modify", "Model", hidden)
            self._wait(f"{name} is still there", lambda: name not in self._models())
            return
        with self.client.muted("response"):
            self.client.publish(
                "request", "Request", {"id": next(self._numbers), "request": "entity_delete", "data": name}
            )
            time.sleep(_RESPONSES_TIME)
        self._wait(f"{name} is still there", lambda: name not in self.poses())

    def _step(self, steps: int) -> None:
        if steps:
            self.client.publish("world_control", "WorldControl", {"multi_step": steps})

    def _wait_for(self, target: int) -> None:
        """Wait until a number of steps is done; SimulatorFailed if no further ones are done."""
        done = self.clock().steps
        while done < target:
            done = int(self._statistics(after=done)["iterations"])

    def _pause(self, *, pause: bool) -> None:
        self.client.clear("world_stats")
        self.client.publish("world_control", "WorldControl", {"pause": pause})
        self.client.wait_for_message("world_stats", lambda message: bool(message["paused"]) == pause)

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

    def _model(self, name: str) -> dict[str, Any]:
        """Return a model, hidden or not."""
        models = self._models(hidden=True)
        if name not in models:
            raise SimulatorFailed(f"Gazebo Classic: no model {name} to move")
        return models[name]

    def _models(self, *, hidden: bool = False) -> dict[str, dict[str, Any]]:
        """Return the models by name, without or with hidden ones."""
        content = self._asked("entity_list", "")["serialized_data"]
        models = CLASSIC.decode("Model_V", content).get("models", [])
        return {model["name"]: model for model in models if hidden or model["pose"]["position"]["z"] < _HIDDEN_HEIGHT}

    def _wait(self, otherwise: str, until: Callable[[], bool]) -> None:
        wait_until(until, f"Gazebo Classic: {otherwise}", self.client.patience, pause=_RESPONSES_TIME / 6)


@contextmanager
def classic_world(address: tuple[str, int], patience: Patience) -> Iterator[ClassicWorld]:
    """A connection to the world of the server whose master is at a host and port; NothingRuns if there is none."""
    with transport_client(address, patience) as opened:
        opened.subscribe("world_stats", "WorldStatistics")
        opened.subscribe("response", "Response")
        yield ClassicWorld(client=opened)


def _modified(model: Mapping[str, Any], pose: Pose) -> dict[str, Any]:
    """Return the message that sets the pose of a model."""
    return {"name": model["name"], "id": model["id"], "pose": pose_message(pose)}


def _contact(message: Mapping[str, Any]) -> Contact:
    points = [(point["x"], point["y"], point["z"]) for point in message["position"]]
    x, y, z = (fmean(along) for along in zip(*points, strict=True))
    return Contact(collisions=(message["collision1"], message["collision2"]), position=(x, y, z))


def _seconds(time_: Mapping[str, int]) -> float:
    return time_["sec"] + time_["nsec"] / 1e9
