r"""A line to a Gazebo Classic server: messages sent and heard, in Gazebo's own transport over TCP.

    rsegen --advertise, subscribe--> master (in the server)
    rsegen <--"sub"-- each program that hears a topic of ours;   messages go back the same way
    rsegen --"sub"--> each program that speaks on a topic;       messages come back the same way

One line stays open as long as it is needed: Gazebo 11.1's server dies one time in 10 to 25 when the command `gz`, which
opens and closes four of them, comes or goes.
"""

from __future__ import annotations

import socket
import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import contextmanager, suppress
from typing import Any

from rsegen.errors import SimulatorFailed
from rsegen.simulation.simulators.classic_messages import Message, decoded, encoded

TIMEOUT = 20.0
"""Seconds for an answer."""

FAREWELL = 2.0
"""Seconds for those who speak to us to stop."""

_CALM, _PAUSE = 0.4, 0.05
"""Seconds until all that was asked is answered, and from a message to when surely no other is on its way."""

_KEPT = 64
"""So many messages of a topic are kept."""

_HEAD = 8
"""Hexadecimal digits before each message: how long it is."""


class TransportClient:
    """What is heard on each topic, the last message of it, and what can be said. Topics are below /gazebo/WORLD/."""

    def __init__(self, address: tuple[str, int]) -> None:
        self._told = threading.Condition()
        self._heard: dict[str, deque[dict[str, Any]]] = defaultdict(lambda: deque(maxlen=_KEPT))
        self._types: dict[str, str] = {}
        self._listeners: dict[str, list[socket.socket]] = defaultdict(list)
        self._speakers: dict[socket.socket, str] = {}
        self._sockets: list[socket.socket] = []
        self._world = ""
        self._last = 0.0
        self._master = self._joined(socket.create_connection(address, TIMEOUT))
        self._host = self._master.getsockname()[0]
        self._own = socket.create_server((self._host, 0))
        self._port = self._own.getsockname()[1]
        self._behind(self._hear_master)
        self._behind(self._welcome)
        try:
            self._wait("no world", lambda: bool(self._world))
        except SimulatorFailed:
            self.close()
            raise

    @property
    def world(self) -> str:
        """The name of the server's world."""
        return self._world

    def hear(self, topic: str, type_name: str) -> None:
        """Listen to a topic from now on."""
        full = self._full(topic)
        self._types[full] = type_name
        self._tell_master("subscribe", "Subscribe", self._subscription(full, self._host, self._port))

    def say(self, topic: str, type_name: str, message: Message) -> None:
        """Send a message to all that hear a topic; the first time, once somebody does."""
        full = self._full(topic)
        if not self._listeners[full]:
            said = {"topic": full, "msg_type": _full_type(type_name), "host": self._host, "port": self._port}
            self._tell_master("advertise", "Publish", said)
            self._wait(f"nobody listens to {full}", lambda: bool(self._listeners[full]))
        for listener in self._listeners[full]:
            _send(listener, encoded(type_name, message))

    def heard(
        self, topic: str, wanted: Callable[[Mapping[str, Any]], bool], timeout: float = TIMEOUT
    ) -> dict[str, Any]:
        """The next message on a topic that is wanted, or the last that was heard if that is."""
        full = self._full(topic)
        self._wait(f"nothing is heard on {full}", lambda: any(map(wanted, self._heard[full])), timeout)
        with self._told:
            return [message for message in self._heard[full] if wanted(message)][-1]

    def forget(self, topic: str) -> None:
        """What was heard on a topic until now."""
        self._note(self._heard[self._full(topic)].clear)

    @contextmanager
    def deaf(self, topic: str) -> Iterator[None]:
        """As long as this lasts, a topic is not heard, and its speakers have that much less to do."""
        self._leave({self._full(topic)})
        yield
        self._listen_to(self._full(topic))

    @contextmanager
    def hearing(self, topic: str, type_name: str) -> Iterator[None]:
        """As long as this lasts, and no longer, a topic is heard."""
        self._types[self._full(topic)] = type_name
        self._listen_to(self._full(topic))
        time.sleep(_PAUSE)
        yield
        self._leave({self._full(topic)})
        self.forget(topic)

    def close(self) -> None:
        """Hang up in a calm moment, once those who speak to us have done so.

        A speaker of Gazebo 11 who is about to send a message to somebody who goes says nothing more to anybody.
        """
        self._wait_for_calm()
        with suppress(SimulatorFailed):
            self._leave(set(self._speakers.values()))
        for each in (self._own, *self._sockets):
            each.close()

    def _full(self, topic: str) -> str:
        return topic if topic.startswith("/") else f"/gazebo/{self._world}/{topic.removeprefix('~/')}"

    def _listen_to(self, topic: str) -> None:
        """And wait for somebody who speaks."""
        self._tell_master("subscribe", "Subscribe", self._subscription(topic, self._host, self._port))
        self._wait(f"nobody speaks on {topic}", lambda: topic in self._speakers.values())

    def _leave(self, topics: Set[str]) -> None:
        """A speaker knows a listener by the port that it comes from, and hangs up."""
        for there, topic in list(self._speakers.items()):
            if topic in topics:
                host, port = there.getsockname()[:2]
                self._tell_master("unsubscribe", "Subscribe", self._subscription(topic, host, port))
        self._wait("a speaker goes on", lambda: not topics & set(self._speakers.values()), FAREWELL)

    def _wait_for_calm(self) -> None:
        began = time.monotonic()
        while self._speakers and (now := time.monotonic()) < began + FAREWELL:
            if now > began + _CALM and now > self._last + _PAUSE:
                return
            time.sleep(_PAUSE / 5)

    def _subscription(self, topic: str, host: str, port: int) -> Message:
        return {"topic": topic, "host": host, "port": port, "msg_type": _full_type(self._types[topic])}

    def _tell_master(self, kind: str, type_name: str, message: Message) -> None:
        _send(self._master, _packet(kind, type_name, message))

    def _hear_master(self) -> None:
        for content in _received(self._master):
            packet = decoded("Packet", content)
            kind, inside = packet["type"], packet["serialized_data"]
            if kind == "topic_namepaces_init":
                names = decoded("GzString_V", inside).get("data", [])
                self._note(lambda: setattr(self, "_world", next((name for name in names if "/" not in name), "")))  # noqa: B023
            elif kind in ("publisher_subscribe", "publisher_advertise", "publisher_add"):
                self._join(decoded("Publish", inside))

    def _join(self, speaker: Mapping[str, Any]) -> None:
        """Listen to somebody who speaks on a topic that is to be heard."""
        if speaker["topic"] in self._types and speaker["port"] != self._port:
            self._behind(lambda: self._listen(speaker))

    def _listen(self, speaker: Mapping[str, Any]) -> None:
        topic = speaker["topic"]
        there = self._joined(socket.create_connection((speaker["host"], speaker["port"]), TIMEOUT))
        self._note(lambda: self._speakers.update({there: topic}))
        _send(there, _packet("sub", "Subscribe", self._subscription(topic, self._host, self._port)))
        for content in _received(there):
            message = decoded(self._types[topic], content)
            self._note(lambda: self._heard[topic].append(message))  # noqa: B023
            self._last = time.monotonic()
        self._note(lambda: self._speakers.pop(there))

    def _welcome(self) -> None:
        """Let those in who want to hear a topic of ours."""
        while True:
            try:
                guest, _ = self._own.accept()
            except OSError:
                return
            self._behind(lambda: self._serve(self._joined(guest)))  # noqa: B023

    def _serve(self, guest: socket.socket) -> None:
        for content in _received(guest):
            packet = decoded("Packet", content)
            if packet["type"] == "sub":
                topic = decoded("Subscribe", packet["serialized_data"])["topic"]
                self._note(lambda: self._listeners[topic].append(guest))  # noqa: B023

    def _joined(self, other: socket.socket) -> socket.socket:
        other.settimeout(None)
        other.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._sockets.append(other)
        return other

    def _behind(self, run: Callable[[], None]) -> None:
        threading.Thread(target=run, daemon=True).start()

    def _note(self, change: Callable[[], object]) -> None:
        with self._told:
            change()
            self._told.notify_all()

    def _wait(self, why: str, until: Callable[[], bool], timeout: float = TIMEOUT) -> None:
        with self._told:
            if not self._told.wait_for(until, timeout):
                raise SimulatorFailed(f"Gazebo Classic: {why}")


@contextmanager
def line(address: tuple[str, int]) -> Iterator[TransportClient]:
    """A line to the master at a host and port, as long as this lasts."""
    try:
        opened = TransportClient(address)
    except OSError as error:
        raise SimulatorFailed(
            f"Gazebo Classic: nobody answers at {address[0]}:{address[1]} ({error.strerror or error})"
        ) from None
    try:
        yield opened
    finally:
        opened.close()


def _full_type(name: str) -> str:
    return f"gazebo.msgs.{name}"


def _packet(kind: str, type_name: str, message: Message) -> bytes:
    now = time.time_ns()
    stamp = {"sec": now // 10**9, "nsec": now % 10**9}
    return encoded("Packet", {"stamp": stamp, "type": kind, "serialized_data": encoded(type_name, message)})


def _send(other: socket.socket, content: bytes) -> None:
    try:
        other.sendall(b"%08X" % len(content) + content)
    except OSError as error:
        raise SimulatorFailed(f"Gazebo Classic: the server is gone ({error.strerror})") from None


def _received(other: socket.socket) -> Iterator[bytes]:
    """Message after message, until either side hangs up."""
    try:
        with other.makefile("rb") as stream:
            while len(head := stream.read(_HEAD)) == _HEAD:
                yield stream.read(int(head, 16))
    except (OSError, ValueError):
        return
