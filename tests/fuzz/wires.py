"""Servers of both Gazebos that talk to rsegen's clients in threads, and damage a part of all that they send.

wires.py <--our client connects--  as master, publisher, service      each side of a wire is played:
wires.py --connects to our client--> as subscriber, requester         what comes may be damaged on any
"""

from __future__ import annotations

import random
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

from rsegen.errors import RsegenError
from rsegen.simulators.gazebo_classic import classic_world
from rsegen.simulators.gazebo_sim import sim_world
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.patience import Patience
from rsegen.simulators.poses import Pose
from rsegen.simulators.sim_transport import SERVICES, TOPICS, Discovery, Event
from rsegen.simulators.wire import CLASSIC, SIM, Message
from tests.fuzz.damage import EXTREMES, damaged_bytes

SHORT = Patience(seconds=0.2, sign=0.2)
DAMAGED = 0.15
"""Part of all messages that are damaged: of more, most conversations would end with the first."""


def talk_to_classic(number: int) -> None:
    """Use a world of Gazebo Classic as `rsegen spawn` and `remove` do; an error that is raised on purpose is right."""
    rng = random.Random(number)  # noqa: S311  # no secret
    with hostile_classic(rng) as address, suppress(RsegenError), classic_world(address, SHORT) as live:
        use(live)


def talk_to_sim(number: int) -> None:
    """Use a world of Gazebo Sim."""
    rng = random.Random(number)  # noqa: S311  # no secret
    with hostile_sim(rng) as address, suppress(RsegenError), sim_world(address, SHORT) as live:
        use(live)


def use(live: LiveWorld) -> None:
    """Ask for all that commands ask for."""
    asked: tuple[Callable[[], object], ...] = (
        live.clock,
        live.poses,
        live.movable,
        live.mesh_files,
        live.last_poses,
        lambda: live.move("ground", Pose(x=0, y=0, z=1)),
        lambda: live.spawn("<model name='a'/>", Pose(x=0, y=0, z=0)),
        lambda: live.delete("ground"),
    )
    for ask in asked:
        with suppress(RsegenError):
            ask()


class Damager:
    """Damages a part of what is sent."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._lock = threading.Lock()

    def __call__(self, content: bytes) -> bytes:
        """Return the content, now and then damaged."""
        with self._lock:
            return damaged_bytes(self._rng, content) if self._rng.random() < DAMAGED else content

    def framed(self, content: bytes) -> bytes:
        """Return the content behind its length in Gazebo Classic's digits, which may be wrong."""
        with self._lock:
            wrong = self._rng.random() < DAMAGED / 3
            length = self._rng.choice(EXTREMES) if wrong else len(content)
        return self(b"%08X" % (length & 0xFFFFFFFF)) + content


@contextmanager
def hostile_classic(rng: random.Random) -> Iterator[tuple[str, int]]:
    """Yield the address of a master that is also the publisher and the subscriber of all topics."""
    with ExitStack() as stack:
        peers = [stack.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(2)]
        server = _Classic(Damager(rng), *peers)
        stack.callback(server.end)
        for peer, serve in zip(peers, (server.as_master, server.as_publisher), strict=True):
            server.start(server.accept, peer, serve)
        yield peers[0].getsockname()


class _Classic:
    """A world with a ground, in as few words as a client needs."""

    def __init__(self, damage: Damager, master: socket.socket, publisher: socket.socket) -> None:
        self._damage = damage
        self._peers = [master, publisher]
        self._here = publisher.getsockname()
        self._listening: dict[str, socket.socket] = {}

    def start(self, run: Callable[..., None], *arguments: object) -> None:
        def quietly() -> None:
            with suppress(
                OSError, ValueError, KeyError, TypeError, AttributeError, struct.error, StopIteration
            ):  # as its peer is gone, perhaps before it has said anything
                run(*arguments)

        threading.Thread(target=quietly, daemon=True).start()

    def accept(self, server: socket.socket, serve: Callable[[socket.socket], None]) -> None:
        while True:
            other, _ = server.accept()
            self._peers.append(other)
            self.start(serve, other)

    def as_master(self, client: socket.socket) -> None:
        self._tell(client, "topic_namepaces_init", "GzString_V", {"data": ["lab"]})
        for content in _packets(client):
            packet = CLASSIC.decode("Packet", content)
            if packet["type"] == "subscribe":
                asked = CLASSIC.decode("Subscribe", packet["serialized_data"])
                host, port = self._here
                publication = {"topic": asked["topic"], "msg_type": asked["msg_type"], "host": host, "port": port}
                self._tell(client, "publisher_subscribe", "Publish", publication)
            elif packet["type"] == "advertise":
                told = CLASSIC.decode("Publish", packet["serialized_data"])
                self.start(self.as_subscriber, told)
            elif packet["type"] == "unsubscribe":
                topic = CLASSIC.decode("Subscribe", packet["serialized_data"])["topic"]
                self._listening.pop(topic).shutdown(socket.SHUT_RDWR)

    def as_publisher(self, client: socket.socket) -> None:
        packet = CLASSIC.decode("Packet", next(_packets(client)))
        topic = CLASSIC.decode("Subscribe", packet["serialized_data"])["topic"]
        self._listening[topic] = client
        now, steps = {"sec": 1, "nsec": 0}, 0
        while topic.endswith("world_stats"):
            steps += 1
            clock = {"sim_time": now, "real_time": now, "paused": False, "iterations": steps}
            self._send(client, CLASSIC.encode("WorldStatistics", clock))
            time.sleep(0.02)

    def as_subscriber(self, publication: Mapping[str, Any]) -> None:
        client = socket.create_connection((publication["host"], publication["port"]), 1)
        self._peers.append(client)
        self._tell(client, "sub", "Subscribe", {"topic": publication["topic"]})
        for content in _packets(client):
            if publication["topic"].endswith("/request"):
                asked = CLASSIC.decode("Request", content)
                models = CLASSIC.encode("Model_V", {"models": [GROUND]})
                found = {
                    "id": asked["id"],
                    "response": "success",
                    "type": "Model_V",
                    "serialized_data": self._damage(models),
                }
                self._send(self._listening["/gazebo/lab/response"], CLASSIC.encode("Response", found))

    def _tell(self, other: socket.socket, kind: str, type_name: str, message: Message) -> None:
        inside = self._damage(CLASSIC.encode(type_name, message))
        self._send(
            other, CLASSIC.encode("Packet", {"stamp": {"sec": 1, "nsec": 2}, "type": kind, "serialized_data": inside})
        )

    def _send(self, other: socket.socket, content: bytes) -> None:
        other.sendall(self._damage.framed(self._damage(content)))

    def end(self) -> None:
        for peer in self._peers:
            with suppress(OSError):
                peer.shutdown(socket.SHUT_RDWR)
            peer.close()


GROUND: Mapping[str, Any] = {
    "name": "ground",
    "id": 3,
    "is_static": True,
    "pose": {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
}


def _packets(other: socket.socket) -> Iterator[bytes]:
    with other.makefile("rb") as stream:
        while head := stream.read(8):
            yield stream.read(int(head, 16))


@contextmanager
def hostile_sim(rng: random.Random) -> Iterator[Mapping[str, str]]:
    """Yield the variables of a server with a world; its discovery has ports of its own, which nobody else hears."""
    first = 20_000 + 2 * rng.randrange(10_000)
    address = {"GZ_PARTITION": "fuzz", "GZ_IP": "127.0.0.1"}
    address |= {f"GZ_DISCOVERY_{sort}_PORT": str(first + at) for at, sort in enumerate((TOPICS, SERVICES))}
    server = _Sim(Damager(rng), address)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    try:
        yield address
    finally:
        server.is_over = True
        thread.join(10)


class _Sim:
    """A world that answers each request with the message that is asked for, and publishes its clock and poses."""

    ANSWERS: Mapping[str, tuple[str, Message]] = {
        "/gazebo/worlds": ("StringMsg_V", {"data": ["lab"]}),
        "/world/lab/scene/info": ("Scene", {"name": "lab", "model": [{"name": "ground", "id": 7}]}),
    }
    TOPICS: Mapping[str, tuple[str, Message]] = {
        "/world/lab/stats": ("WorldStatistics", {"sim_time": {"sec": 1}, "real_time": {"sec": 2}, "iterations": 3}),
        "/world/lab/pose/info": ("Pose_V", {"header": {"stamp": {"sec": 1}}, "pose": [{"name": "ground", "id": 7}]}),
        "/world/lab/dynamic_pose/info": ("Pose_V", {"header": {"stamp": {"sec": 1}}}),
    }

    def __init__(self, damage: Damager, address: Mapping[str, str]) -> None:
        import zmq

        self._damage = damage
        self._context = zmq.Context()
        self._topics = Discovery(TOPICS, "hostile", address)
        self._services = Discovery(SERVICES, "hostile", address)
        self._publisher, self._replier = self._context.socket(zmq.PUB), self._context.socket(zmq.ROUTER)
        self._replier.setsockopt(zmq.ROUTING_ID, b"hostile")
        self._ends = [_bound(own) for own in (self._publisher, self._replier)]
        self._poller = zmq.Poller()
        for own in (self._replier, self._topics.receiver, self._services.receiver):
            self._poller.register(own, zmq.POLLIN)
        self._dealer = zmq.DEALER
        self.is_over = False

    def run(self) -> None:
        """Serve until it is over; what goes wrong here, as its damage meets itself, is no failure of a client."""
        while not self.is_over:
            with suppress(Exception):
                self._serve()
        for own in (self._publisher, self._replier):
            own.close(linger=0)
        for discovery in (self._topics, self._services):
            discovery.close()
        self._context.destroy(linger=0)

    def _serve(self) -> None:
        for ready, _ in self._poller.poll(20):
            if ready is self._replier:
                self._reply()
            else:
                self._tell_where(self._topics if ready == self._topics.receiver.fileno() else self._services)
        for topic, (kind, message) in self.TOPICS.items():
            name = f"@/fuzz@{topic}".encode()
            parts = [name, self._ends[0].encode(), SIM.encode(kind, message), f"gz.msgs.{kind}".encode()]
            damaged = [parts[0], *map(self._damage, parts[1:])]
            self._publisher.send_multipart(damaged[: len(damaged) if self._damage(b"all") == b"all" else 2])

    def _tell_where(self, discovery: Discovery) -> None:
        message = discovery.receive()
        if not message or message.get("type") != Event.SUBSCRIBE:
            return
        topic, is_topic = message["sub"]["topic"], discovery is self._topics
        kinds = self.TOPICS if is_topic else self.ANSWERS
        kind = kinds.get(topic.rpartition("@")[2], ("Boolean", {}))[0]
        own: Message = {
            "topic": topic,
            "address": self._ends[not is_topic],
            "process_uuid": "hostile",
            "node_uuid": "node",
        }
        types = {"request_type": "gz.msgs.Empty", "response_type": f"gz.msgs.{kind}", "socket_id": "hostile"}
        own = {**own, "msg_pub": {"msg_type": f"gz.msgs.{kind}"}} if is_topic else {**own, "srv_pub": types}
        told = {"version": 10, "process_uuid": "hostile", "type": Event.ADVERTISE, "pub": own}
        content = self._damage(SIM.encode("Discovery", told))
        for sender in discovery._senders:
            for whole in (struct.pack("<H", len(content) & 0xFFFF) + content, self._damage(b"\0\0" + content)):
                sender.sendto(whole[:60_000], (discovery._group, discovery._port))

    def _reply(self) -> None:
        _, topic, back, _, _, request, *_ = self._replier.recv_multipart()
        service = topic.decode().rpartition("@")[2]
        kind, message = self.ANSWERS.get(service, ("Boolean", {"data": True}))
        other = self._context.socket(self._dealer)
        with suppress(Exception):  # what we were told is no address: the client's own mistake would be found elsewhere
            other.connect(back.decode())
            parts = [topic, b"node", request, SIM.encode(kind, message), b"1"]
            other.send_multipart(list(map(self._damage, parts)))
        other.close(linger=100)


def _bound(own: Any) -> str:
    own.bind("tcp://127.0.0.1:*")
    return str(own.LAST_ENDPOINT.decode().rstrip("\0"))
