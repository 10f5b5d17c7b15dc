"""A client of a Gazebo Classic server: topics published and subscribed, in Gazebo's own transport over TCP.

    rsegen --advertise, subscribe--> master (in the server)
    rsegen <--"sub"-- each subscriber of a topic of ours;   messages go back the same way
    rsegen --"sub"--> each publisher of a topic;            messages come back the same way

A message is preceded by its length in eight hexadecimal digits; to and from the master it is wrapped in a Packet with
its type. Source: the transport of Gazebo 11.1, and what it sends (decision 10). One client stays connected as long as
it is needed, as the server dies one time in 10 to 25 when the command `gz`, which opens and closes four connections,
starts or ends. Cost: a thread and a socket per publisher and subscriber; a paused server answers five times a second,
so each step of a drive takes 0.4 s. What breaks it: disconnecting while a publisher is about to send (see `close`).
"""

from __future__ import annotations

import re
import select
import socket
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Set
from contextlib import AbstractContextManager, closing, contextmanager, suppress
from functools import partial

from rsegen.errors import NoMessage, NothingRuns, SimulatorFailed, library_message, system_reason
from rsegen.simulators.inbox import Inbox
from rsegen.simulators.patience import Patience
from rsegen.simulators.wire import CLASSIC, Message

DISCONNECT_TIMEOUT = 2.0
"""Seconds for publishers to disconnect, ten times the period of a paused server; a client then goes without them."""

_QUIET_AFTER, _QUIET_TIME = 0.4, 0.05
"""Seconds after which all requests are answered, two periods of a paused server, and those without a message after
which none is on its way. With less, a client may disconnect while a publisher sends; more delays every command.
"""

_DONT_WAIT = getattr(socket, "MSG_DONTWAIT", 0)  # Windows has none: there a message may wait longer

_LOOK = 0.1
"""Seconds between two looks whether the wait for a server that takes no message is over."""

_HEAD = re.compile(rb"[0-9A-Fa-f]{8}")
"""The length before each message, by Gazebo's transport."""

_HEAD_SIZE = 8

_MOST = 2**26
"""Bytes of a message at most: 64 MiB, many times a picture or the poses of a large world."""


class TransportClient(Inbox):
    """A client that publishes and subscribes topics below /gazebo/WORLD/, and keeps the last messages of each.

    world: the name of the server's world
    """

    def __init__(self, address: tuple[str, int], patience: Patience) -> None:
        # What threads learn changes inside the inbox's condition; sockets are kept to be closed at the end.
        super().__init__("Gazebo Classic", patience)
        self._subscribers: dict[str, list[socket.socket]] = defaultdict(list)
        self._publishers: dict[socket.socket, str] = {}
        self._sockets: set[socket.socket] = set()
        self._threads: set[threading.Thread] = set()
        self._is_closed = False
        self.world = ""
        self._last = 0.0
        self._master = self._registered(socket.create_connection(address, patience.sign))
        self._own = socket.create_server((self._master.getsockname()[0], 0))
        self._port = self._own.getsockname()[1]
        self._start_thread(self._read_master)
        self._start_thread(self._accept_subscribers)
        try:
            self.wait("a server is running, but reports no world", lambda: bool(self.world))
        except SimulatorFailed:
            self.close()
            raise

    def publish(self, topic: str, type_name: str, message: Message) -> None:
        """Send a message to all subscribers of a topic; the first time, wait for one."""
        full = self.full_name(topic)
        if not self._subscribers[full]:
            self._announce(self._master, "advertise", full, type_name)
            self.wait(f"no subscriber of {full}", lambda: bool(self._subscribers[full]))
        for subscriber in self._subscribers[full]:
            self._send(subscriber, CLASSIC.encode(type_name, message))

    @contextmanager
    def muted(self, topic: str) -> Iterator[None]:
        """A topic is unsubscribed inside, so that its publishers have less to do."""
        self._unsubscribe({self.full_name(topic)})
        yield
        self._subscribe(self.full_name(topic), wait=True)

    @contextmanager
    def subscribed(self, topic: str, type_name: str) -> Iterator[None]:
        """A topic is subscribed inside, and only there."""
        self._types[self.full_name(topic)] = type_name
        self._subscribe(self.full_name(topic), wait=True)
        time.sleep(_QUIET_TIME)
        yield
        self._unsubscribe({self.full_name(topic)})
        self.clear(topic)

    def close(self) -> None:
        """Disconnect in a quiet moment, after the publishers have disconnected.

        A publisher of Gazebo 11 that is about to send to a client that disconnects sends nothing more to anybody.
        """
        quiet, wait = Patience(seconds=_QUIET_AFTER).begin(), Patience(seconds=DISCONNECT_TIMEOUT).begin()
        while self._publishers and not wait.is_over:
            if quiet.is_over and time.monotonic() > self._last + _QUIET_TIME:
                break
            time.sleep(_QUIET_TIME / 5)
        with suppress(SimulatorFailed):
            self._unsubscribe(set(self._publishers.values()))
        self._is_closed = True
        with suppress(OSError):  # not every system ends a waiting accept() so
            self._own.shutdown(socket.SHUT_RDWR)
        for connection in list(self._sockets):
            _disconnect(connection)
        self._own.close()
        for thread in list(self._threads):
            thread.join(DISCONNECT_TIMEOUT)

    def full_name(self, topic: str) -> str:
        """Return the full name of a topic of the world; a full name as it is."""
        return topic if topic.startswith("/") else f"/gazebo/{self.world}/{topic.removeprefix('~/')}"

    def _subscribe(self, full: str, *, wait: bool = False) -> None:
        """Subscribe to a topic, and perhaps wait for a publisher."""
        self._announce(self._master, "subscribe", full)
        if wait:
            self.wait(f"no publisher of {full}", lambda: full in self._publishers.values())

    def _unsubscribe(self, topics: Set[str]) -> None:
        """Unsubscribe: a publisher knows a subscriber by its port, and disconnects."""
        for publisher, topic in list(self._publishers.items()):
            if topic in topics:
                self._announce(self._master, "unsubscribe", topic, address=publisher.getsockname())
        self.wait(
            "a publisher does not disconnect",
            lambda: not topics & set(self._publishers.values()),
            Patience(seconds=DISCONNECT_TIMEOUT),
        )

    def _announce(
        self, other: socket.socket, kind: str, topic: str, type_name: str = "", address: tuple[str, int] | None = None
    ) -> None:
        """Send a packet about a topic; its type is by default the one that is subscribed, the address ours."""
        host, port = address or self._own.getsockname()
        full_type = f"gazebo.msgs.{type_name or self._types[topic]}"
        message = {"topic": topic, "host": host, "port": port, "msg_type": full_type}
        inside = CLASSIC.encode("Publish" if kind == "advertise" else "Subscribe", message)
        seconds, nanoseconds = divmod(time.time_ns(), 10**9)
        stamp = {"sec": seconds, "nsec": nanoseconds}
        self._send(other, CLASSIC.encode("Packet", {"stamp": stamp, "type": kind, "serialized_data": inside}))

    def _send(self, other: socket.socket, content: bytes) -> None:
        """Send a message; a SimulatorFailed if the other is gone, or takes nothing until patience is over."""
        # As many bytes at once as it takes: each of them is progress, so the wait begins anew.
        left, wait = memoryview(b"%08X" % len(content) + content), self.patience.begin()
        try:
            while left:
                _, ready, _ = select.select((), (other,), (), _LOOK)
                if ready:
                    sent = other.send(left, _DONT_WAIT)
                    left, wait = left[sent:], self.patience.begin()
                elif wait.is_over:
                    raise SimulatorFailed(f"Gazebo Classic: the server accepted no message for {self.patience}")
        except (OSError, ValueError) as error:  # ValueError: it is closed already
            raise SimulatorFailed(f"Gazebo Classic: the server is gone ({library_message(error)})") from None

    def _read_master(self) -> None:
        """Note the world's name, which the master sends first, and connect to each publisher that it reports."""
        for content in _received(self._master):
            with suppress(NoMessage):  # what others send may be anything
                packet = CLASSIC.decode("Packet", content)
                kind, inside = packet["type"], packet["serialized_data"]
                if kind == "topic_namepaces_init":
                    names = CLASSIC.decode("GzString_V", inside).get("data", [])
                    world = next((name for name in names if "/" not in name), "")
                    self.update(partial(setattr, self, "world", world))
                elif kind in ("publisher_subscribe", "publisher_advertise", "publisher_add"):
                    publisher = CLASSIC.decode("Publish", inside)
                    topic, host, port = publisher["topic"], publisher["host"], publisher["port"]
                    if topic in self._types and port != self._port:
                        self._start_thread(partial(self._read_publisher, topic, host, port))
        self._end(self._master)
        if not self._is_closed:
            self.fail("the server has ended")

    def _read_publisher(self, topic: str, host: str, port: int) -> None:
        """Subscribe at a publisher, and keep its messages until either side disconnects."""
        try:
            publisher = self._registered(socket.create_connection((host, port), self.patience.seconds))
        except (OSError, OverflowError, UnicodeError):  # it is gone already, or this is no address
            return
        self.update(lambda: self._publishers.update({publisher: topic}))
        with suppress(SimulatorFailed):  # it goes in this moment: then nothing is received
            self._announce(publisher, "sub", topic)
        for content in _received(publisher):
            self.add(topic, partial(CLASSIC.decode, self._types[topic], content))
            self._last = time.monotonic()
        self.update(lambda: self._publishers.pop(publisher))
        self._end(publisher)

    def _accept_subscribers(self) -> None:
        """Accept subscribers of our topics, until this client is closed."""
        with suppress(OSError):
            while True:
                subscriber, _ = self._own.accept()
                self._start_thread(partial(self._read_subscriber, subscriber))

    def _read_subscriber(self, subscriber: socket.socket) -> None:
        """Note the topics that a subscriber asks for, and forget them when it disconnects."""
        topics: list[str] = []
        for content in _received(self._registered(subscriber)):
            with suppress(NoMessage):
                packet = CLASSIC.decode("Packet", content)
                if packet["type"] == "sub":
                    topics.append(CLASSIC.decode("Subscribe", packet["serialized_data"])["topic"])
                    self.update(lambda: self._subscribers[topics[-1]].append(subscriber))
        for topic in topics:
            self.update(partial(self._subscribers[topic].remove, subscriber))
        self._end(subscriber)

    def _registered(self, other: socket.socket) -> socket.socket:
        """Note a connection, to be closed with this client, or at once if that is closed already; return it."""
        other.settimeout(None)
        other.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # small messages go at once
        self._sockets.add(other)
        if self._is_closed:
            self._end(other)
        return other

    def _end(self, other: socket.socket) -> None:
        """Disconnect, and forget a connection."""
        _disconnect(other)
        self._sockets.discard(other)

    def _start_thread(self, run: Callable[[], None]) -> None:
        def until_done() -> None:
            try:
                run()
            finally:
                self._threads.discard(threading.current_thread())

        thread = threading.Thread(target=until_done, daemon=True)
        self._threads.add(thread)
        thread.start()


def transport_client(address: tuple[str, int], patience: Patience) -> AbstractContextManager[TransportClient]:
    """A client of the master at a host and port; it disconnects when this ends. NothingRuns if there is no master."""
    try:
        return closing(TransportClient(address, patience))
    except OSError as error:
        host, port = address
        raise NothingRuns(f"Gazebo Classic: no answer from {host}:{port} ({system_reason(error)})") from None


def _disconnect(other: socket.socket) -> None:
    """Disconnect and close; without the first, a thread that reads would keep the connection open."""
    with suppress(OSError):
        other.shutdown(socket.SHUT_RDWR)
    other.close()


def _received(other: socket.socket) -> Iterator[bytes]:
    """Yield the messages until either side disconnects, or the other sends no length, or one that is too large."""
    with suppress(OSError, ValueError), other.makefile("rb") as stream:
        while _HEAD.fullmatch(head := stream.read(_HEAD_SIZE)) and (size := int(head, 16)) <= _MOST:
            content = stream.read(size)
            if len(content) < size:
                return
            yield content
