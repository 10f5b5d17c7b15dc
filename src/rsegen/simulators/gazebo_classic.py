"""Gazebo Classic 11: gzserver, gzclient, gazebo, which starts both, and the world in a running server.

Two servers need two ports of GAZEBO_MASTER_URI, and the internet's database of models is switched off, or they wait for
it. A paused server begins its record when its world is complete, which tells that it has loaded; the record later tells
where models were, to three digits, which is all that Gazebo writes; answers have all of them. The world is reached
through Gazebo's transport:

~/world_control, request, factory, model/modify     topics that change the world, or ask about it
~/response                                          the answer to a request, with its number
~/world_stats                                       the clock, five times a second, also of a paused server
~/pose/info, physics/contacts                       poses of what moves, and contacts, while somebody subscribes

Nothing in this protocol confirms a message, so whatever is ordered is asked about until it is done. What breaks it:
many messages at once, after which Gazebo 11 now and then stops publishing a topic, and a model of its world's name,
whose deletion would delete everything; both are avoided below.
"""

from __future__ import annotations

import re
import socket
import time
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from secrets import randbelow
from types import MappingProxyType
from typing import Any, ClassVar

from rsegen.errors import ParameterError, SimulatorFailed, shown
from rsegen.robots.drives import PublishCommand
from rsegen.simulators.base import Installation, OpenRequest, Simulator, commands_of, register
from rsegen.simulators.classic_transport import TransportClient, transport_client
from rsegen.simulators.live_world import Clock, LiveWorld
from rsegen.simulators.patience import Patience
from rsegen.simulators.poses import Contact, Pose, Record
from rsegen.simulators.process import command_output
from rsegen.simulators.wire import CLASSIC, contact_of, mesh_file, parse_text, pose_message, pose_of
from rsegen.writing.programs import LaunchCommand
from rsegen.writing.user_state import home_folder

_STATE = re.compile(r"<sim_time>(\d+) (\d+)</sim_time>(.*?)</state>", re.DOTALL)
_MODEL = re.compile(r"<model name='([^']+)'>\s*<pose>([^<]+)</pose>")


SET_UP = Path(".cache", "rsegen", "gazebo-classic")
"""The folder in the user's home in which scripts/gazebo-classic sets it up."""

MASTER = "http://localhost:11345"
"""The default address of Gazebo Classic's server."""

STATE = Path("record", "state.log")
"""The record of a server, below its home."""


@register
class GazeboClassic(Simulator):
    """Gazebo Classic 11, the last of its line."""

    name: ClassVar[str] = "classic"
    title: ClassVar[str] = "Gazebo Classic"
    generation: ClassVar[int] = 1
    how_to_install: ClassVar[tuple[str, ...]] = (
        "Ubuntu 22.04, Debian 11: apt-get install gazebo gazebo-plugin-base",
        "Debian 12 and later, headless: scripts/gazebo-classic in a clone of rsegen (1.3 GB, as root)",
    )
    address_variables: ClassVar[tuple[str, ...]] = ("GAZEBO_MASTER_URI",)
    harmless_messages: ClassVar[tuple[str, ...]] = (
        "Can't open display",
        "Unable to open audio device",
        # What a server prints when a `gz` command has just disconnected.
        "Header is empty",
        "Data was empty, try again",
        # What a server that keeps a record prints for every model that is spawned while time runs.
        "Unable to call parseURDF on robot model",
        "parse as old deprecated model file failed",
    )
    frames: ClassVar[tuple[str, ...]] = ("camera", "window")
    digits: ClassVar[int | None] = 3
    load_failures: ClassVar[tuple[str, ...]] = ("Falling back on worlds/empty.world", "Unable to start server[bind")

    def installation(self) -> Installation | None:
        """Return the installation on PATH, else the one that scripts/gazebo-classic has set up."""
        home = home_folder() / SET_UP
        elsewhere = [home / "bin"] if (home / "complete").exists() else []
        server = next(iter(commands_of("gzserver", *elsewhere)), None)
        version = re.search(r"version (11\.\S+)", command_output([server, "--version"])) if server else None
        if not server or not version:
            return None
        names = ("gzserver", "gz", "gazebo", "gzclient")
        commands = {name: server.with_name(name) for name in names if server.with_name(name).exists()}
        return Installation(simulator=self, version=version[1], commands=MappingProxyType(commands))

    def with_gui(self, here: Installation, opening: OpenRequest) -> LaunchCommand | None:
        """Return the command `gazebo`, which starts server and window."""
        if "gazebo" not in here.commands or "gzclient" not in here.commands:
            return None
        return _launch(here.commands["gazebo"], opening, {})

    def headless(self, here: Installation, opening: OpenRequest) -> LaunchCommand:
        """Return the command `gzserver`, without a screen if it needs none."""
        blind = {} if opening.screen else {"DISPLAY": ""}
        return _launch(here.commands["gzserver"], opening, blind | opening.home_variables)

    def paused(self, here: Installation, opening: OpenRequest, home: Path) -> LaunchCommand:
        """Return the command `gzserver`, paused, with a record in its home."""
        options = ("--pause", "--record", "--record_path", str(home / STATE.parent))
        return self.headless(here, replace(opening, home=home)).with_options(*options)

    def window(self, here: Installation, server: LaunchCommand) -> LaunchCommand | None:
        """Return the command `gzclient`, with the variables of the server, but on the screen."""
        if "gzclient" not in here.commands:
            return None
        variables = {name: value for name, value in server.environment.items() if name != "DISPLAY"}
        return replace(server, command=(str(here.commands["gzclient"]),), environment=MappingProxyType(variables))

    def is_loaded(self, home: Path, log: str) -> bool:
        """Return whether the record exists: a paused server begins it when its world is complete."""
        return (home / STATE).exists()

    def backend(self, here: Installation) -> str:
        """Return the only one."""
        return "classic"

    def connect(self, environment: Mapping[str, str], patience: Patience) -> AbstractContextManager[LiveWorld]:
        """Connect through its own transport, so it may run on another machine, and need not be installed here."""
        master = environment.get("GAZEBO_MASTER_URI") or MASTER
        parts = re.fullmatch(r"(?:http://)?([^/:]+):(\d{1,5})/?", master)
        if not parts or int(parts[2]) >= 2**16:
            raise ParameterError("GAZEBO_MASTER_URI", f"{shown(master)} is not a host and a port, as in {MASTER}")
        return classic_world((parts[1], int(parts[2])), patience)

    def record_options(self, period: float) -> tuple[str, ...]:
        """Return the options of a record as text."""
        return "--record_encoding", "txt", "--record_period", f"{period:g}"

    def read_record(self, home: Path) -> Record | None:
        """Return the record, which is complete when the server has ended; SimulatorFailed if it was killed before."""
        log = (home / STATE).read_text() if (home / STATE).exists() else ""
        if not log.rstrip().endswith("</gazebo_log>"):
            raise SimulatorFailed(f"{self.title} was killed before its record was complete")
        return [
            (
                int(seconds) + int(nanos) / 1e9,
                {name: [float(value) for value in pose.split()] for name, pose in _MODEL.findall(models)},
            )
            for seconds, nanos, models in _STATE.findall(log)
        ]


def _launch(command: Path, opening: OpenRequest, more: Mapping[str, str]) -> LaunchCommand:
    """Return a command in the world's folder, where Gazebo 11.1 looks for meshes.

    Its server has no model database in the internet, and its own address unless it is to be shared.
    """
    variables = {"GAZEBO_MODEL_DATABASE_URI": "", "GAZEBO_MODEL_PATH": opening.model_path("GAZEBO_MODEL_PATH")}
    if not opening.shared:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))  # any port that is free
            master = f"http://127.0.0.1:{probe.getsockname()[1]}"
        variables |= {"GAZEBO_IP": "127.0.0.1", "GAZEBO_MASTER_URI": master}
    return LaunchCommand(
        command=(str(command), "--verbose", opening.world.name),
        environment=MappingProxyType(variables | dict(more)),
        folder=opening.folder,
    )


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

    def send_command(self, command: PublishCommand) -> None:
        """Publish the command, and wait the time that messages take."""
        self.client.publish(command.topic, command.type.rpartition(".")[2], parse_text(command.text))
        time.sleep(_DELIVERY_TIME)

    def step(self, steps: int) -> None:
        """Step, and wait as long as steps are being done."""
        target = self.clock().steps + steps
        self._step(steps)
        self.client.wait_until("world_stats", _iterations, target)

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Do the first step alone: of many in a row the server reports contacts late, and not all."""
        target = self.clock().steps + steps
        with self.client.subscribed("physics/contacts", "Contacts"):
            self._step(1)
            message = self.client.wait_for_message("physics/contacts")
        self._step(steps - 1)
        self.client.wait_until("world_stats", _iterations, target)
        touches = (contact_of((at["collision1"], at["collision2"]), at["position"]) for at in message["contact"])
        return list(filter(None, touches))

    def stop_recording(self) -> None:
        """Stop the record, and wait the time that messages take."""
        self.client.publish("log/control", "LogControl", {"stop": True})
        time.sleep(_DELIVERY_TIME)

    def clock(self) -> Clock:
        """Return the last clock that the server published."""
        now = self.client.wait_for_message("world_stats")
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
        """Return the files in the answer about poses; a map in a world file has them relative to the world."""
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

    def _set_paused(self, *, paused: bool) -> None:
        self.client.clear("world_stats")  # the last one was sent before the order
        self.client.publish("world_control", "WorldControl", {"pause": paused})
        self.client.wait_for_message("world_stats", lambda message: bool(message["paused"]) == paused)

    def _entities(self) -> dict[str, Any]:
        """Return the response to a request for all entities.

        It is repeated, as on a busy machine the server learns late who listens. All responses are waited for: who
        disconnects while one is about to be sent makes the server deaf (`close`).
        """
        request_id, wait, asked = next(self._numbers), self.client.patience.begin(), 0
        message = {"id": request_id, "request": "entity_list", "data": ""}
        while not (answers := self._answers(request_id)):
            if wait.is_over or not self.is_current:
                raise SimulatorFailed(f"Gazebo Classic: no answer to entity_list within {self.client.patience}")
            self.client.publish("request", "Request", message)
            asked += 1
            with suppress(SimulatorFailed):
                self.client.wait("no response", lambda: bool(self._answers(request_id)), _ASK_AGAIN)
        with suppress(SimulatorFailed):  # some got lost
            self.client.wait("no response", lambda: len(self._answers(request_id)) >= asked, _ASK_AGAIN)
        return answers[0]

    def _answers(self, request_id: int) -> list[dict[str, Any]]:
        """Return the responses to a request that have come."""
        answers = self.client.messages("response")
        return [answer for answer in answers if answer["id"] == request_id and "serialized_data" in answer]

    def _models(self, *, hidden: bool = False) -> dict[str, dict[str, Any]]:
        """Return the models by name, without or with hidden ones."""
        content = self._entities()["serialized_data"]
        models = CLASSIC.decode("Model_V", content).get("models", [])
        return {model["name"]: model for model in models if hidden or model["pose"]["position"]["z"] < _HIDDEN_HEIGHT}


@contextmanager
def classic_world(address: tuple[str, int], patience: Patience) -> Iterator[ClassicWorld]:
    """A connection to the world of the server whose master is at a host and port; NothingRuns without a server."""
    with transport_client(address, patience) as opened:
        opened.subscribe("world_stats", "WorldStatistics")
        opened.subscribe("response", "Response")
        yield ClassicWorld(client=opened, name=opened.world)


def _iterations(message: Mapping[str, Any]) -> int:
    return int(message["iterations"])


def _seconds(time_: Mapping[str, int]) -> float:
    return time_["sec"] + time_["nsec"] / 1e9
