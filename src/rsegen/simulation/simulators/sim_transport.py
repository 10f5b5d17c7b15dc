r"""A client of Gazebo Sim's transport: topics over ZeroMQ's PUB and SUB, services over its ROUTER.

    rsegen SUB    <--messages--  each publisher of a topic that discovery has found
    rsegen XPUB   --messages-->  each subscriber of ours; it tells us what it has subscribed to
    rsegen ROUTER --request--->  the program that offers a service, which connects to our second ROUTER to respond

One thread owns all sockets; others hand it what is to be sent. The protocol is that of Gazebo Transport since
Fortress (version 10 of discovery), so neither Gazebo nor its Python bindings need to be installed.
"""

from __future__ import annotations

import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from queue import SimpleQueue
from typing import Any

from rsegen.errors import SimulatorFailed
from rsegen.simulation.simulators.inbox import Inbox
from rsegen.simulation.simulators.sim_discovery import (
    HEARTBEAT_PERIOD,
    SERVICES,
    TOPICS,
    Discovery,
    Event,
    interfaces,
    partition_of,
)
from rsegen.simulation.simulators.sim_messages import SIM
from rsegen.simulation.simulators.sim_sockets import Sockets
from rsegen.simulation.simulators.wire import NO_MESSAGE, Message

TIMEOUT = 20.0
"""Seconds for an answer."""

_SILENT_BEATS = 5
"""Of our heartbeats without one of a server, after which it has ended; other programs give it up after three seconds.

Ours are counted instead of seconds: on a busy machine this program stands still too, and hears nothing.
"""

_ASK_AGAIN = 0.2
"""Seconds after which a question of discovery that is not answered is asked again: a datagram may get lost."""


class TransportClient:
    """A client in a partition, which publishes, subscribes, and requests services."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        self.partition = partition_of(environment)
        self._process, self._node = (str(uuid.uuid4()) for _ in range(2))
        self._inbox = Inbox("Gazebo Sim")
        self._types: dict[str, str] = {}
        self._takers: dict[str, Callable[[dict[str, Any]], None]] = {}
        self._publications: dict[str, Message] = {}
        self._subscribed: set[str] = set()
        self._connections: dict[tuple[str, str], Message] = {}
        self._services: dict[str, dict[str, Message]] = {}
        self._responses: dict[str, tuple[bytes, bool]] = {}
        self._heard: set[str] = set()
        self._attended, self._silent_beats = "", 0
        self._work: SimpleQueue[Callable[[], object]] = SimpleQueue()
        self._wake, self._woken = socket.socketpair()
        self._wake.settimeout(0)
        self._topics = Discovery(TOPICS, self._process, environment)
        self._offers = Discovery(SERVICES, self._process, environment)
        self._sockets = Sockets(interfaces(environment)[0], self._process)
        self._closing = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def attend(self, process: str) -> None:
        """Fail as soon as this program has ended."""
        self._attended, self._silent_beats = process, 0

    def subscribe(self, topic: str, type_name: str, on_message: Callable[[dict[str, Any]], None] | None = None) -> None:
        """Subscribe to a topic, if it is not subscribed yet; `on_message` takes its messages, else they are kept."""
        full = self._full_name(topic)
        if full in self._types:
            return
        self._types[full] = type_name
        self._takers[full] = on_message or partial(self._inbox.add, full)
        self._do(lambda: self._sockets.subscribe(full))
        self._ask(self._topics, full)

    def wait_for_publisher(self, topic: str, timeout: float = TIMEOUT) -> None:
        """Wait until a topic that is subscribed has a publisher, which knows of it."""
        full = self._full_name(topic)
        known = self._connections
        self._inbox.wait(f"no publisher of {topic}", lambda: any(name == full for name, _ in list(known)), timeout)

    def publish(self, topic: str, type_name: str, message: Message) -> None:
        """Send a message, of the full name of a type, to all subscribers of a topic; the first time, wait for one."""
        full = self._full_name(topic)
        if full not in self._subscribed:
            self._publications[full] = {
                "topic": full,
                "address": self._sockets.publisher_address,
                "node_uuid": self._node,
                "msg_pub": {"ctrl": "", "msg_type": type_name},
            }
            self._do(lambda: self._topics.send(Event.ADVERTISE, pub=self._publications[full]))
            self._inbox.wait(f"no subscriber of {topic}", lambda: full in self._subscribed, TIMEOUT)
        content = SIM.encode(type_name.rpartition(".")[2], message)
        parts = [part.encode() for part in (full, self._sockets.publisher_address)]
        self._do(lambda: self._sockets.publisher.send_multipart([*parts, content, type_name.encode()]))

    def offers(self, service: str, timeout: float = TIMEOUT) -> list[Message]:
        """Who offers a service: the publications of all programs that answer; SimulatorFailed if none does."""
        full, end = self._full_name(service), time.monotonic() + timeout
        while not self._services.get(full):
            if time.monotonic() > end:
                raise SimulatorFailed(f"Gazebo Sim: nobody offers {service}")
            self._ask(self._offers, full)
            with suppress(SimulatorFailed):
                self._inbox.wait("", lambda: bool(self._services.get(full)), _ASK_AGAIN)
        return list(self._services[full].values())

    def all_offers(self, service: str) -> list[Message]:
        """The same of all programs that answer within a moment, once one has answered."""
        self._ask(self._offers, self._full_name(service))
        time.sleep(_ASK_AGAIN / 2)
        return self.offers(service)

    def request(self, service: str, type_name: str, message: Message, timeout: float = TIMEOUT) -> dict[str, Any]:
        """The response of a service to a message of a type; SimulatorFailed if it refuses or does not answer."""
        offer, number = self.offers(service, timeout)[0], str(uuid.uuid4())
        found = offer["srv_pub"]
        parts = [found["socket_id"], offer["topic"], self._sockets.responder_address, self._process, self._node, number]
        types = [found["request_type"].encode(), found["response_type"].encode()]
        content = [*(part.encode() for part in parts), SIM.encode(type_name, message), *types]
        self._do(lambda: self._send_request(offer["address"], content, time.monotonic() + timeout))
        self._inbox.wait(f"{service} does not answer", lambda: number in self._responses, timeout)
        answer, is_done = self._responses.pop(number)
        if not is_done:
            raise SimulatorFailed(f"Gazebo Sim: {service} refuses")
        return SIM.decode(found["response_type"].rpartition(".")[2], answer)

    def wait_for_message(
        self, topic: str, wanted: Callable[[Mapping[str, Any]], bool], timeout: float = TIMEOUT
    ) -> dict[str, Any]:
        """The last message of a topic that `wanted` accepts; waits for one if there is none yet."""
        return self._inbox.wait_for_message(self._full_name(topic), wanted, timeout)

    def last(self, topic: str) -> dict[str, Any] | None:
        """The last message of a topic; None if there is none yet."""
        return self._inbox.last(self._full_name(topic))

    def clear(self, topic: str) -> None:
        """Delete the messages of a topic that were received until now."""
        self._inbox.clear(self._full_name(topic))

    def close(self) -> None:
        """Unsubscribe from everything, and disconnect."""
        self._do(self._end)
        self._thread.join(TIMEOUT)

    def _full_name(self, topic: str) -> str:
        return f"@/{self.partition.strip('/')}@{topic}"

    def _ask(self, where: Discovery, full: str) -> None:
        """Ask all programs who has a topic, or offers a service, of this full name."""
        self._do(lambda: where.send(Event.SUBSCRIBE, sub={"topic": full}))

    def _do(self, work: Callable[[], object]) -> None:
        """Hand work to the thread that owns the sockets."""
        self._work.put(work)
        with suppress(BlockingIOError):  # enough are waiting to wake it
            self._wake.send(b"!")

    def _run(self) -> None:
        sockets, others = self._sockets, (self._woken, self._topics.receiver, self._offers.receiver)
        readers: dict[Any, Callable[[], None]] = {
            self._woken.fileno(): self._read_work,
            self._topics.receiver.fileno(): lambda: self._read_discovery(self._topics, self._note_publisher),
            self._offers.receiver.fileno(): lambda: self._read_discovery(self._offers, self._note_service),
            sockets.subscriber: self._read_message,
            sockets.publisher: self._read_subscription,
            sockets.responder: self._read_response,
        }
        poller, beat = sockets.poller(*others), 0.0
        while not self._closing:
            if time.monotonic() >= beat:
                self._beat()
                beat = time.monotonic() + HEARTBEAT_PERIOD
            for each, _ in poller.poll(max(0, int((beat - time.monotonic()) * 1000))):
                with suppress(KeyError, ValueError, sockets.Error):  # what others send may be anything
                    readers[each]()
        for other in (sockets, self._topics, self._offers, self._wake, self._woken):
            other.close()

    def _beat(self) -> None:
        self._silent_beats = 0 if self._attended in self._heard else self._silent_beats + 1
        self._heard.clear()
        if self._attended and self._silent_beats >= _SILENT_BEATS:
            self._inbox.fail("the server does not answer any more")
        for each in (self._topics, self._offers):
            each.send(Event.HEARTBEAT)
        for publication in list(self._publications.values()):
            self._topics.send(Event.ADVERTISE, pub=publication)
        for topic in list(self._types):
            if not any(topic == known for known, _ in self._connections):
                self._topics.send(Event.SUBSCRIBE, sub={"topic": topic})

    def _read_work(self) -> None:
        """Do what was handed over until now; what that hands over, such as another try, waits for the next turn."""
        self._woken.recv(4096)
        for _ in range(self._work.qsize()):
            self._work.get_nowait()()

    def _read_discovery(self, where: Discovery, advertised: Callable[[Message], None]) -> None:
        message = where.receive()
        if not message:
            return
        self._heard.add(message["process_uuid"])
        if message.get("type") == Event.ADVERTISE and "pub" in message:
            advertised(message["pub"])
        elif message.get("type") == Event.BYE:
            self._forget(message["process_uuid"])

    def _note_publisher(self, found: Message) -> None:
        """Connect to a publisher of a topic that is subscribed, and register with it."""
        topic, process = found["topic"], found["process_uuid"]
        if topic not in self._types or (topic, process) in self._connections:
            return
        self._sockets.connect(self._sockets.subscriber, found["address"])
        kind = {"ctrl": process, "msg_type": found.get("msg_pub", {}).get("msg_type", "")}
        own = {"topic": topic, "address": found["address"], "node_uuid": self._node, "msg_pub": kind}
        self._topics.send(Event.NEW_CONNECTION, pub=own)
        self._inbox.update(lambda: self._connections.update({(topic, process): own}))

    def _note_service(self, found: Message) -> None:
        self._inbox.update(lambda: self._services.setdefault(found["topic"], {}).update({found["process_uuid"]: found}))

    def _forget(self, process: str) -> None:
        """Nothing more comes from a program that has said goodbye."""
        if process == self._attended:
            self._inbox.fail("the server has ended")
        self._inbox.update(lambda: [offers.pop(process, None) for offers in self._services.values()])
        for topic, other in list(self._connections):
            if other == process:
                del self._connections[topic, other]

    def _read_message(self) -> None:
        full, _, content, kind = self._sockets.subscriber.recv_multipart()[:4]
        topic = full.decode(errors="replace")
        name = self._types.get(topic)
        if name and kind.decode(errors="replace").rpartition(".")[2] == name:
            with suppress(*NO_MESSAGE):
                self._takers[topic](SIM.decode(name, content))

    def _read_subscription(self) -> None:
        """A first byte of 1 says that somebody has subscribed, of 0 that nobody is left."""
        content = self._sockets.publisher.recv()
        change = self._subscribed.add if content[:1] == b"\1" else self._subscribed.discard
        self._inbox.update(lambda: change(content[1:].decode(errors="replace")))

    def _read_response(self) -> None:
        *_, number, content, result = self._sockets.responder.recv_multipart()
        self._inbox.update(lambda: self._responses.update({number.decode(): (content, result == b"1")}))

    def _send_request(self, address: str, content: list[bytes], end: float) -> None:
        """Send a request; while the connection is being made, try again."""
        self._sockets.connect(self._sockets.requester, address)
        try:
            self._sockets.requester.send_multipart(content)
        except self._sockets.Error:
            if time.monotonic() < end:
                time.sleep(0.002)
                self._do(lambda: self._send_request(address, content, end))

    def _end(self) -> None:
        for topic, process in list(self._connections):
            self._topics.send(Event.END_CONNECTION, pub=self._connections[topic, process])
        for each in (self._topics, self._offers):
            each.send(Event.BYE)
        self._closing = True


@contextmanager
def transport_client(environment: Mapping[str, str]) -> Iterator[TransportClient]:
    """A client at the address in environment variables; it disconnects when this ends."""
    client = TransportClient(environment)
    try:
        yield client
    finally:
        client.close()
