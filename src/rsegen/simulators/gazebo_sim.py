"""Gazebo Sim, once Ignition: `ign gazebo` up to Fortress, `gz sim` from Garden on, and the world in a running server.

Every variable is set by both of its names, old and new. A partition of its own keeps a server apart from others. It
prints in blocks of 4096 bytes, so whether it has loaded its world is read from its own log, which is flushed by line;
its exit code is 0 whatever fails. The world is reached through its transport:

/world/NAME/control, create, remove, set_pose, scene/info    services
/world/NAME/stats                                            the clock, ten times a second
/world/NAME/pose/info                                        poses with the simulation time, sixty times a second
/model/NAME/pose                                             poses of a robot, as often as its plug-in publishes
/rsegen/contacts                                             contacts, of sensors in the links of robots

A step is done when poses of its time are published, as a service answers before it has changed anything. A server gives
contacts of collisions that a sensor names, and of no others. Its sensors publish at every step in which their link has
a contact, so a sample is what has the time of its step. The messages of a server arrive in the order in which it sends
them: after poses of a later step no more contacts of an earlier one come.

Cost, measured in Gazebo Sim 6.7 on a mesh of 80 x 80 blocks: with sensors the server takes 0.62 s of CPU per simulated
second instead of 0.40 for one Burger, and 1.9 instead of 1.1 for five, as it then collects the contacts of every step,
whether anybody subscribes or not. Messages to a subscriber are less than a fifth of the difference, names of entities,
which could be left out, less than a seventh. Trajectories stay the same to the digit. The service of the world's state
would need the sensors too, and gives all of the world at once.
"""

from __future__ import annotations

import os
import re
import secrets
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import astuple, dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar
from xml.etree import ElementTree

from rsegen.errors import NoMessage, NothingRuns, ParameterError, SimulatorFailed
from rsegen.robots.drives import POSE_RATE, PublishCommand, Tracks
from rsegen.robots.links import posed
from rsegen.robots.lookup import DrivableRobot
from rsegen.simulators.base import Installation, OpenRequest, Simulator, commands_of, register
from rsegen.simulators.live_world import Clock, LiveWorld
from rsegen.simulators.patience import Patience
from rsegen.simulators.poses import Contact, Pose, Record
from rsegen.simulators.process import command_output
from rsegen.simulators.sim_transport import TransportClient, transport_client
from rsegen.simulators.wire import SIM, contact_of, mesh_file, nanoseconds, parse_text, pose_message, pose_of
from rsegen.writing.programs import LaunchCommand
from rsegen.writing.user_state import home_folder

COMMANDS = (("gz", "sim"), ("ign", "gazebo"))
"""Program and verb. Programs of these names without the verb are Gazebo Classic's, or libsdformat's alone."""

_SETTINGS = {
    "gz sim": (Path(".gz", "sim"), "GZ_SIM_SERVER_CONFIG_PATH"),
    "ign gazebo": (Path(".ignition", "gazebo"), "IGN_GAZEBO_SERVER_CONFIG_PATH"),
}
"""The folder of its settings in the user's home, and the variable that names another file of default plug-ins."""

_LOADED = "Publishing dynamic pose messages on ["
"""The last message, of level 3, of its scene broadcaster in the first update after all entities are made."""

_NO_MESSAGE_IS_DROPPED = {"GZ_TRANSPORT_SNDHWM": "0", "IGN_TRANSPORT_SNDHWM": "0"}
"""The length of the queue of messages to send, 0 for any: with the default of 1000, which sensors of contact reach
in a fraction of a second on a busy machine, poses are missing in a record."""

_SDF_ERROR = re.compile(r"\[Server(Private)?\.cc:\d+\] Error Code \d+")
"""An error of libsdformat in the world's own file, whatever it is: the server ends, with exit code 0. (Those in models
that are spawned come from other files of its source.)"""


@register
class GazeboSim(Simulator):
    """Gazebo Sim from Fortress on."""

    name: ClassVar[str] = "sim"
    title: ClassVar[str] = "Gazebo Sim"
    generation: ClassVar[int] = 2
    how_to_install: ClassVar[tuple[str, ...]] = (
        "Ubuntu 22.04, 24.04: apt-get install gz-harmonic from packages.osrfoundation.org",
        "macOS: brew install osrf/simulation/gz-harmonic; conda: conda install -c conda-forge gz-sim8",
        "all systems: https://gazebosim.org/docs/latest/install (Debian has its libraries only)",
    )
    address_variables: ClassVar[tuple[str, ...]] = ("GZ_PARTITION", "IGN_PARTITION")
    drives_without: ClassVar[tuple[str, ...]] = ("pictures",)
    harmless_messages: ClassVar[tuple[str, ...]] = (
        # A second server's profiler finds its port taken.
        "Error launching Remotery",
    )
    load_failures: ClassVar[tuple[str, ...]] = (
        "Failed to find world [",
        "Unable to find or download file",
        "Failed to load a world",
        "Library error: Problem running",
        "Library error for [",
        "error while loading shared libraries",
    )

    def installation(self) -> Installation | None:
        """Return the newest of all that are on PATH; each prints its versions, one per line."""
        offers = [
            (version, f"{program} {verb}", path)
            for program, verb in COMMANDS
            for path in commands_of(program)  # Gazebo Classic's `gz` may come first
            for version in re.findall(r"(?m)^\s*(\d+\.\d+\.\d+\S*)\s*$", command_output([path, verb, "--versions"]))
        ]
        if not offers:
            return None
        version, words, path = max(offers, key=lambda offer: [*map(int, re.findall(r"\d+", offer[0])[:3])])
        return Installation(simulator=self, version=version, commands=MappingProxyType({words: path}))

    def with_gui(self, here: Installation, opening: OpenRequest) -> LaunchCommand | None:
        """Return the command of server and window, which start to simulate at once."""
        return _launch(here, opening).with_options("-r")

    def headless(self, here: Installation, opening: OpenRequest) -> LaunchCommand:
        """Return the command of the server alone; in its own home with the default plug-ins of the user's."""
        launch = _launch(here, opening).with_options("-s", "-r")
        ((words, _),) = here.commands.items()
        folder, variable = _SETTINGS[words]
        file = home_folder() / folder / here.version.partition(".")[0] / "server.config"
        if not opening.home or variable in os.environ or not file.is_file():
            return launch
        return launch.with_variables({variable: str(file)})

    def paused(self, here: Installation, opening: OpenRequest, home: Path) -> LaunchCommand:
        """Return the command of a paused server, which says what it has loaded, and drops no message."""
        launch = _launch(here, replace(opening, home=home)).with_options("-s", "-v", "3")
        return launch.with_variables(_NO_MESSAGE_IS_DROPPED)

    def is_loaded(self, home: Path, log: str) -> bool:
        """Return whether it says so: at once in its own log in its home, perhaps 4096 bytes later in what it prints."""
        logs = (file for folder, _ in _SETTINGS.values() for file in (home / folder).glob("log/*/server_console.log"))
        return _LOADED in log or any(_LOADED in file.read_text(errors="replace") for file in logs)

    def load_failed(self, log: str) -> bool:
        """Return whether its log has such a message, or an error in the world's SDF."""
        return super().load_failed(log) or any(_SDF_ERROR.search(line) for line in self.error_lines(log))

    def backend(self, here: Installation) -> str:
        """Return `fortress` up to that version, whose names begin with ignition, else `sim`."""
        return "fortress" if "ign gazebo" in here.commands else "sim"

    def with_contact_sensors(self, model: str) -> str:
        """Return the model with a sensor in each link with collisions, nested models included.

        A server gives only contacts of collisions that a sensor names.
        """
        root = ElementTree.fromstring(model)  # noqa: S314  # ours, or was found to be plain elements
        for link in root.iter("link"):
            if names := [collision.get("name", "") for collision in link.findall("collision")]:
                sensor = ElementTree.SubElement(link, "sensor", {"name": "rsegen_contacts", "type": "contact"})
                ElementTree.SubElement(sensor, "always_on").text = "true"
                contact = ElementTree.SubElement(sensor, "contact")
                for name in names:
                    ElementTree.SubElement(contact, "collision").text = name
                ElementTree.SubElement(contact, "topic").text = CONTACTS
        return ElementTree.tostring(root, encoding="unicode") + "\n"

    def connect(self, environment: Mapping[str, str], patience: Patience) -> AbstractContextManager[LiveWorld]:
        """Connect through its own transport, so it may run on another machine, and need not be installed here."""
        return sim_world(environment, patience)


def _launch(here: Installation, opening: OpenRequest) -> LaunchCommand:
    """Return a command; its server is in its own partition on this machine alone, unless it is to be shared."""
    ((words, program),) = here.commands.items()
    models = {name: opening.model_path(name) for name in ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")}
    # Our client speaks ZeroMQ, and messages without statistics, whatever the user's variables say.
    own = {"PARTITION": f"rsegen-{secrets.token_hex(4)}", "IP": "127.0.0.1", "RELAY": ""}
    own |= {"TRANSPORT_IMPLEMENTATION": "zeromq", "TRANSPORT_TOPIC_STATISTICS": "0"}
    address = {f"{prefix}_{name}": value for name, value in own.items() for prefix in ("GZ", "IGN")}
    return LaunchCommand(
        command=(str(program), words.split()[1], str(opening.folder / opening.world.name)),
        environment=MappingProxyType(models | ({} if opening.shared else address) | opening.home_variables),
        folder=opening.folder,
    )


CONTACTS = "/rsegen/contacts"
"""The topic of all sensors that `GazeboSim.with_contact_sensors` adds."""


class ContactSample:
    """The contacts at one simulation time, of all messages that are received."""

    def __init__(self) -> None:
        self._time: int | None = None
        self._contacts: list[bytes] = []

    def begin(self, time: int | None) -> None:
        """Delete all, and keep the contacts at this time, nanoseconds, from now on; None: at all times."""
        self._time, self._contacts = time, []

    def add(self, message: dict[str, Any]) -> None:
        """Keep the contacts of a message if they are of the time; most are not, and are never decoded."""
        if self._time in (None, nanoseconds(message.get("header", {}).get("stamp"))):
            self._contacts += message.get("contact", [])

    def end(self) -> Sequence[Contact]:
        """Return the contacts at that time, sorted; what two robots' sensors both report is one."""
        contacts = {contact.collisions: contact for contact in map(_contact, self._contacts) if contact}
        return [contacts[names] for names in sorted(contacts)]


def _contact(content: bytes) -> Contact | None:
    """Return the contact of a message; None if it has no points, or is no message."""
    with suppress(NoMessage):
        message = SIM.decode("Contact", content)
        first, second = sorted(message[side]["name"] for side in ("collision1", "collision2"))
        return contact_of((first, second), message["position"])
    return None


WORLDS = "/gazebo/worlds"
"""The service of every server that lists its worlds."""

TOPICS = {"stats": "WorldStatistics", "pose/info": "Pose_V", "dynamic_pose/info": "Pose_V"}
"""The topics of a world that are subscribed, and the types of their messages."""

_CONNECTION_TIME = 0.1
"""Seconds in which a publisher that knows of a subscriber is connected with it; servers wait as long.

With less, a drive may miss its first poses or contacts; more is added to every drive once.
"""

_SENSORS_TIME = Patience(seconds=2.0)
"""Time in which the sensors of a loaded world are found: two heartbeats, with which publishers tell of themselves.

A world without sensors costs a drive this time once.
"""

_CLIENTS, _FIRST_RESPONSE = 5, Patience(seconds=1.0)
"""Clients that are tried, and the time within which a server must answer one (decision 16)."""

_TWO_POSES = 2 * 10**9 / POSE_RATE
"""Nanoseconds of simulation time in which a robot's plug-in has published its pose."""

_MODEL = 2
"""The type of a model in a message Entity, by gz-msgs' entity.proto."""


@dataclass(kw_only=True, slots=True)
class SimWorld(LiveWorld):
    """The world in a Gazebo Sim server. A paused server answers, and publishes its clock and poses."""

    between_looks: ClassVar[float] = 0.02  # poses are published about as often

    client: TransportClient
    name: str
    backend: str
    _names: Mapping[int, str] = field(default_factory=dict)
    _ids: Set[int] = frozenset()
    _recorded: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    _sample: ContactSample | None = None
    _stopped: tuple[int, int] | None = None
    """Steps, and nanoseconds of simulation time, at which our last step has ended; None if time ran since."""

    @property
    def is_current(self) -> bool:
        """Return whether the server answers, and nobody else offers its world's services.

        A server that was killed says nothing of its end: what it has offered before proves nothing.
        """
        with suppress(SimulatorFailed):
            self.client.wait_for_answer(WORLDS)
            return self.client.is_connected and len(self.client.all_offers(WORLDS)) == 1
        return False

    def send_command(self, command: PublishCommand) -> None:
        """Publish the command, and wait until the server has received it: it reads a message before each request."""
        self.client.publish(command.topic, command.type, parse_text(command.text))
        self.client.request(WORLDS, "Empty", {})

    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive, and wait until that is received; belts are commanded one by one.

        The plug-in of a robot on tracks passes a command on to its belts by messages within the server, which a thread
        of its own delivers while the world steps: on a busy machine some steps later, so no drive would repeat.
        """
        if isinstance(robot.drive, Tracks):
            commands = robot.drive.belt_commands(name, v, w, posed(astuple(self.poses()[name])), self.backend)
        else:
            commands = iter([robot.command(name, v, w, self.backend)])
        for command in commands:
            self.send_command(command)

    def step(self, steps: int) -> None:
        """Step, and wait until poses are published that are as late."""
        if not steps:
            return
        # All steps take equally long, so the time of the last one is known, and poses of that time are waited for.
        done, now = self._stopped or _steps_and_time(self.client.wait_for_message(self._topic("stats")))
        self._order("control", "WorldControl", {"pause": True, "multi_step": steps})
        if done:
            self._stopped = done + steps, now + steps * (now // done)
            self.client.wait_until(self._topic("pose/info"), _stamp, self._stopped[1])
        else:  # how long a step takes is known after the first
            last = self.client.wait_until(self._topic("stats"), lambda message: message.get("iterations", 0), steps)
            self._stopped = _steps_and_time(last)

    def watch_contacts(self) -> bool:
        """Subscribe to the sensors of contact, if the world has any."""
        sample = ContactSample()
        self.client.subscribe(CONTACTS, "Contacts", sample.add)
        with suppress(SimulatorFailed):
            self.client.wait_for_publisher(CONTACTS, _SENSORS_TIME)
            time.sleep(_CONNECTION_TIME)
            self._sample = sample
        return self._sample is not None

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Step, and return the contacts of the first step; sensors send the contacts of each step with its time."""
        if self._sample is None or not steps:
            self.step(steps)
            return ()
        # Contacts are known by the time of the first step; before any step it is unknown, so one step is done alone.
        done, now = self._stopped or _steps_and_time(self.client.wait_for_message(self._topic("stats")))
        self._sample.begin(now + now // done if done else None)
        first = steps if done else 1
        self.step(first)
        if first == 1:  # in its last step the server may send the poses first
            self.client.clear(self._topic("pose/info"))
            self.client.wait_for_message(self._topic("pose/info"))
        contacts = self._sample.end()
        self.step(steps - first)
        return contacts

    def clock(self) -> Clock:
        """Return the last clock that the server published, not before the end of our last step."""
        reached = self._stopped[1] if self._stopped else 0
        stats = self.client.wait_for_message(
            self._topic("stats"), lambda message: nanoseconds(message.get("sim_time")) >= reached
        )
        steps, simulated = _steps_and_time(stats)
        real, paused = nanoseconds(stats.get("real_time")), bool(stats.get("paused"))
        return Clock(simulated=simulated / 1e9, real=real / 1e9, steps=steps, paused=paused)

    def poses(self) -> Mapping[str, Pose]:
        """Return the poses of all models, not before the end of our last step."""
        poses = self._poses("pose/info")
        if poses.keys() != self._ids:  # something was spawned or deleted, so the names are asked for again
            self._names, self._ids = self._models(), poses.keys()
        return self._by_name(poses)

    def last_poses(self) -> tuple[float, Mapping[str, Pose]]:
        """Return the last message of the topic of poses, with the names that the last call of `poses` has found."""
        message = self.client.last(self._topic("pose/info")) or {}
        return _stamp(message) / 1e9, self._by_name(_by_id(message))

    def record(self, names: Sequence[str]) -> None:
        """Record the poses that the plug-ins of these robots publish from now on."""
        for name in names:
            self._recorded[name] = []
            self.client.subscribe(f"/model/{name}/pose", "Pose", self._recorded[name].append)
        for name in names:
            self.client.wait_for_publisher(f"/model/{name}/pose")
        time.sleep(_CONNECTION_TIME)

    def recorded(self) -> Record:
        """Return the record of the robots, at the times that their plug-ins choose; SimulatorFailed if one has none.

        Without it a drive would have a pose per command only, and be shorter than it was.
        """
        states: dict[int, dict[str, list[float]]] = defaultdict(dict)
        for name, messages in self._recorded.items():
            for message in messages:
                if message.get("name") == name:
                    states[_stamp(message)][name] = list(astuple(pose_of(message)))
        silent = sorted(self._recorded.keys() - {name for state in states.values() for name in state})
        if silent and self._stopped and self._stopped[1] > _TWO_POSES:
            raise SimulatorFailed(f"Gazebo Sim: no pose of {', '.join(silent)} was published")
        return [(at / 1e9, states[at]) for at in sorted(states)]

    def mesh_files(self) -> Mapping[str, str]:
        """Return the files in the scene, which are absolute."""
        return {model["name"]: file for model in self._scene() if (file := mesh_file(model))}

    def movable(self) -> Set[str]:
        """Return the models in the topic of moving poses."""
        moving = self._poses("dynamic_pose/info")
        return frozenset(name for entity, name in self._models().items() if entity in moving)

    def _move(self, name: str, pose: Pose) -> Pose:
        """Have the pose set by a service."""
        before = self.poses().get(name)
        if before is None:
            raise SimulatorFailed(f"Gazebo Sim: no model {name} to move")
        self._order("set_pose", "Pose", {"name": name, **pose_message(pose)})
        return before

    def _spawn(self, name: str, sdf: str, pose: Pose) -> None:
        """Have it spawned by a service, which finds the name in the text."""
        self._order("create", "EntityFactory", {"sdf": sdf, "pose": pose_message(pose)})

    def _delete(self, name: str) -> None:
        """Have it deleted by a service."""
        self._order("remove", "Entity", {"name": name, "type": _MODEL})

    def _set_paused(self, *, paused: bool) -> None:
        self._order("control", "WorldControl", {"pause": paused})
        self.client.clear(self._topic("stats"))
        self._stopped = None
        self.client.wait_for_message(self._topic("stats"), lambda message: bool(message.get("paused")) == paused)

    def _poses(self, topic: str) -> dict[int, bytes]:
        """Return the messages Pose in a topic by the ids of their entities, not before the end of our last step."""
        reached = self._stopped[1] if self._stopped else 0
        return _by_id(self.client.wait_for_message(self._topic(topic), lambda message: _stamp(message) >= reached))

    def _by_name(self, poses: Mapping[int, bytes]) -> dict[str, Pose]:
        """Return poses by the names of their models, of those that are known."""
        known = {name: poses[entity] for entity, name in self._names.items() if entity in poses}
        return {name: pose_of(message) for name, content in known.items() for message in _of_type("Pose", content)}

    def _models(self) -> dict[int, str]:
        """Return the names of the models in the scene by their ids."""
        return {model["id"]: model["name"] for model in self._scene()}

    def _scene(self) -> Sequence[Mapping[str, Any]]:
        """Return the models of the scene."""
        return list(self.client.request(self._topic("scene/info"), "Empty", {}).get("model", []))

    def _order(self, name: str, type_name: str, message: Mapping[str, Any]) -> None:
        if not self.client.request(self._topic(name), type_name, message).get("data"):
            raise SimulatorFailed(f"Gazebo Sim: {self._topic(name)} refuses")

    def _topic(self, name: str) -> str:
        """Return the full name of a service of the world, or of a topic, which is subscribed."""
        full = f"/world/{self.name}/{name}"
        if name in TOPICS:
            self.client.subscribe(full, TOPICS[name])
        return full


@contextmanager
def sim_world(environment: Mapping[str, str], patience: Patience) -> Iterator[SimWorld]:
    """The world of the server at the address in environment variables.

    NothingRuns if no server gives a sign, ParameterError if several do; SimulatorFailed if none answers. A client that
    is not answered is replaced: a server's response to a new program is lost if the connection takes it more than
    0.1 s; and always, if the program has the port of an earlier one, whose name the server goes on to use.
    """
    for _ in range(_CLIENTS):
        with transport_client(environment, patience) as client:
            try:
                client.offers(WORLDS, replace(patience, seconds=patience.sign))
            except SimulatorFailed:
                raise NothingRuns(f"Gazebo Sim: no server answers in the partition {client.partition}") from None
            try:
                worlds = client.request(WORLDS, "Empty", {}, _FIRST_RESPONSE).get("data", [])
            except SimulatorFailed:
                continue
            # It must be the only server, and its messages tell by their package which backend it is.
            offers = client.all_offers(WORLDS)
            if len(offers) > 1:
                problem = f"{len(offers)} servers of Gazebo Sim run in the partition {client.partition}"
                raise ParameterError("GZ_PARTITION", f"{problem}; set it to that of one server")
            if not worlds:
                raise SimulatorFailed(f"Gazebo Sim: the server in the partition {client.partition} has no world")
            client.attend(offers[0]["process_uuid"])
            backend = "fortress" if offers[0]["srv_pub"]["request_type"].startswith("ignition.") else "sim"
            yield SimWorld(client=client, name=worlds[0], backend=backend)
            return
    raise SimulatorFailed("Gazebo Sim: a server exists, but does not answer")


def _steps_and_time(stats: Mapping[str, Any]) -> tuple[int, int]:
    return stats.get("iterations", 0), nanoseconds(stats.get("sim_time"))


def _by_id(message: Mapping[str, Any]) -> dict[int, bytes]:
    """Return the messages Pose in one of many by their ids; most are of links, and never decoded."""
    entities = ((entity, raw) for raw in message.get("pose", []) for entity in _of_type("EntityPose", raw))
    return {entity["id"]: raw for entity, raw in entities if "id" in entity}


def _of_type(type_name: str, content: bytes) -> Iterator[dict[str, Any]]:
    """Yield the message of a type, or nothing if the bytes are none, as what a server sends may be anything."""
    with suppress(NoMessage):
        yield SIM.decode(type_name, content)


def _stamp(message: Mapping[str, Any]) -> int:
    return nanoseconds(message.get("header", {}).get("stamp"))
