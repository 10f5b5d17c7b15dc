"""A client of Gazebo Sim's transport: topics over ZeroMQ's PUB and SUB, services over its ROUTER.

Discovery finds by UDP multicast who publishes a topic or offers a service; each message has its length in two bytes
before it, and topics and services have a port each:

    rsegen --SUBSCRIBE topic--> all programs        a program that has the topic answers ADVERTISE, with its address
    rsegen --ADVERTISE topic--> all programs        a program that wants the topic connects to our address
    rsegen --NEW_CONNECTION---> the publisher       only then it sends its messages to others than itself
    all    --HEARTBEAT--------> all programs        each second; who is silent for three is gone

Messages then go over TCP, by ZeroMQ:

    rsegen SUB    <--messages--  each publisher of a topic that discovery has found
    rsegen XPUB   --messages-->  each subscriber of ours; it tells us what it has subscribed to
    rsegen ROUTER --request--->  the program that offers a service, which connects to our second ROUTER to respond

One thread owns all sockets; others hand it what is to be sent. Source: Gazebo Transport since Fortress, whose discovery
has wire version 10 up to Jetty; neither Gazebo nor its Python bindings need to be installed (decision 16). Cost: 0.4 to
0.9 ms per request. What breaks it: an interface without multicast, GZ_TRANSPORT_IMPLEMENTATION=zenoh, topic statistics
(wire version 110), and a response that a server drops, for which another client is tried (`gazebo_sim`).
"""

from __future__ import annotations

import re
import socket
import struct
import sys
import threading
import time
import uuid
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, closing, suppress
from enum import IntEnum
from functools import partial
from queue import SimpleQueue
from typing import Any

from rsegen.errors import NoMessage, ParameterError, SimulatorFailed, shown, system_reason
from rsegen.simulators.inbox import Inbox
from rsegen.simulators.patience import Patience, Wait, share
from rsegen.simulators.wire import SIM, Message
from rsegen.writing.user_state import user_name


class Sockets:
    """Sockets for topics (subscriber, publisher) and services (requester, responder), bound at a host's free ports."""

    def __init__(self, host: str, process: str) -> None:
        import zmq

        self._context = zmq.Context()
        self._context.setsockopt(zmq.LINGER, 0)  # of all its sockets
        self._connected: set[str] = set()
        self.Error, self.poller, self.receives = zmq.ZMQError, zmq.Poller(), zmq.POLLIN
        self.subscriber = self._context.socket(zmq.SUB)
        self.subscriber.setsockopt(zmq.RCVHWM, 0)  # any number of messages may wait: none is dropped
        self.publisher = self._context.socket(zmq.XPUB)
        self.requester, self.responder = (self._context.socket(zmq.ROUTER) for _ in range(2))
        self.requester.setsockopt(zmq.ROUTER_MANDATORY, 1)  # an error, not silence, while there is no connection
        self.responder.setsockopt(zmq.ROUTING_ID, process.encode())
        for own in (self.publisher, self.responder):
            own.bind(f"tcp://{host}:*")
        self.publisher_address, self.responder_address = (
            own.getsockopt_string(zmq.LAST_ENDPOINT).rstrip("\0") for own in (self.publisher, self.responder)
        )

    def connect(self, own: Any, address: str) -> None:
        """Connect one of them to an address, once."""
        if address not in self._connected:
            self._connected.add(address)
            own.connect(address)

    def close(self) -> None:
        """Close them."""
        self._context.destroy()


HEARTBEAT_PERIOD = 1.0
"""Seconds between two heartbeats, as in Gazebo Transport itself, which gives a program up after three."""

TOPICS, SERVICES = "MSG", "SRV"
"""The two sorts of what is discovered, as in the names of variables."""

# Gazebo Transport's own defaults and numbers, the same from Fortress to Jetty.
_PORTS = {TOPICS: 10317, SERVICES: 10318}
_GROUP = "239.255.0.7"
_WIRE_VERSION = 10
_IP_MULTICAST_ALL = 49
"""Linux's option that gives a socket what comes to groups that others joined; Python has no name for it."""

_EVERYWHERE = 2
"""The scope of a topic that all computers may know."""


class Event(IntEnum):
    """The types of a discovery message."""

    ADVERTISE = 1
    SUBSCRIBE = 2
    UNADVERTISE = 3
    HEARTBEAT = 4
    BYE = 5
    NEW_CONNECTION = 6
    END_CONNECTION = 7


class Discovery:
    """The sockets of discovery of topics or of services, at the addresses that a user's environment variables give."""

    def __init__(self, sort: str, process: str, environment: Mapping[str, str]) -> None:
        self._process = process
        self._group = _variable(environment, "DISCOVERY_MULTICAST_IP") or _GROUP
        try:
            socket.inet_aton(self._group)
        except OSError:
            problem = f"{shown(self._group)} is not an address, as in {_GROUP}"
            raise ParameterError("GZ_DISCOVERY_MULTICAST_IP", problem) from None
        port = _variable(environment, f"DISCOVERY_{sort}_PORT")
        self._port = int(port) if re.fullmatch("[0-9]{1,5}", port) and int(port) < 2**16 else _PORTS[sort]
        self._relays = [relay for relay in _variable(environment, "RELAY").split(":") if relay]
        self._senders: list[socket.socket] = []
        self.receiver = _udp()
        try:
            self._join(interfaces(environment), is_chosen=bool(_variable(environment, "IP")))
        except OSError as error:
            self.close()
            raise SimulatorFailed(f"Gazebo Sim: no multicast on this computer ({system_reason(error)})") from None

    def send(self, event: Event, **content: Message) -> None:
        """Send a message to all programs; `content`: sub or pub."""
        fields = {"version": _WIRE_VERSION, "process_uuid": self._process, "type": event, **content}
        if "pub" in fields:
            fields["pub"] = {"process_uuid": self._process, "scope": _EVERYWHERE, **content["pub"]}
        message = SIM.encode("Discovery", fields)
        for sender in self._senders:
            for host in (self._group, *self._relays):
                with suppress(OSError):  # an interface that is down
                    sender.sendto(struct.pack("<H", len(message)) + message, (host, self._port))

    def receive(self) -> dict[str, Any] | None:
        """Return the next message of another program of our version; None if it is something else."""
        with suppress(OSError, KeyError, struct.error, NoMessage):
            content = self.receiver.recv(2**16)  # more than a datagram of UDP can have
            if struct.unpack_from("<H", content)[0] == len(content) - 2:
                message = SIM.decode("Discovery", content[2:])
                if message.get("version") == _WIRE_VERSION and message["process_uuid"] != self._process:
                    return message
        return None

    def close(self) -> None:
        """Close the sockets."""
        for own in (self.receiver, *self._senders):
            own.close()

    def _join(self, addresses: list[str], *, is_chosen: bool) -> None:
        for option in (socket.SO_REUSEADDR, getattr(socket, "SO_REUSEPORT", socket.SO_REUSEADDR)):
            self.receiver.setsockopt(socket.SOL_SOCKET, option, 1)
        # On Linux only what comes to the group, and on the interfaces that the user chose; relays send to our address.
        only_group = sys.platform == "linux" and is_chosen and not self._relays
        if only_group:
            self.receiver.setsockopt(socket.IPPROTO_IP, _IP_MULTICAST_ALL, 0)
        self.receiver.bind((self._group if only_group else "", self._port))
        self.receiver.settimeout(0)
        for address in addresses:
            membership = socket.inet_aton(self._group) + socket.inet_aton(address)
            with suppress(OSError):  # an interface without multicast
                self.receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
                sender = _udp()
                self._senders.append(sender)
                sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(address))


def interfaces(environment: Mapping[str, str]) -> list[str]:
    """Return the addresses of this computer for messages: the one in GZ_IP or IGN_IP, else all, 127.0.0.1 last.

    An address that is not this computer's counts as 127.0.0.1, as in Gazebo Transport.
    """
    import psutil

    interfaces_here = (address for addresses in psutil.net_if_addrs().values() for address in addresses)
    own = {address.address for address in interfaces_here if address.family == socket.AF_INET}
    if chosen := _variable(environment, "IP"):
        return [chosen if chosen in own or chosen.startswith("127.") else "127.0.0.1"]
    return sorted(own | {"127.0.0.1"}, key=lambda address: address.startswith("127."))


def _variable(environment: Mapping[str, str], name: str) -> str:
    """Return a variable by its name since Garden, else by its older name."""
    return environment.get(f"GZ_{name}") or environment.get(f"IGN_{name}") or ""


def _udp() -> socket.socket:
    return socket.socket(socket.AF_INET, socket.SOCK_DGRAM)


_SILENT_BEATS = 5
"""Heartbeats of ours without one of a server, after which it has ended; other programs give it up after three seconds.

Ours are counted instead of seconds: on a busy machine this program stands still too, and hears nothing.
"""

_ASK_AGAIN = 0.2
"""Seconds after which a question of discovery that is not answered is asked again: a datagram may get lost.

A program on the same machine answers in milliseconds; asking more often only loads the network.
"""

_RETRY = 0.002
"""Seconds between two tries to send a request while the connection is being made, which takes a few milliseconds."""


class TransportClient(Inbox):
    """A client for topics and services in a partition, by default the one of the computer and the user."""

    def __init__(self, environment: Mapping[str, str], patience: Patience) -> None:
        # The thread alone touches the sockets; what it learns changes inside the inbox's condition.
        super().__init__("Gazebo Sim", patience)
        self.partition = _variable(environment, "PARTITION")
        if not self.partition:
            self.partition = f"{socket.gethostname()}:{user_name()}"  # as NetUtils.cc of gz-transport, not by USER
        self._process, self._node = (str(uuid.uuid4()) for _ in range(2))
        self._publications: dict[str, Message] = {}
        self._subscribed: set[str] = set()
        self._connections: dict[tuple[str, str], Message] = {}
        self._services: dict[str, dict[str, Message]] = {}
        self._responses: dict[str, tuple[bytes, bool]] = {}
        self._heard: set[str] = set()
        self._attended, self._silent_beats = "", 0.0
        self._work: SimpleQueue[Callable[[], object]] = SimpleQueue()
        # Before all other sockets, as these may fail by the user's variables.
        self._topics = Discovery(TOPICS, self._process, environment)
        self._offers = Discovery(SERVICES, self._process, environment)
        self._wake, self._woken = socket.socketpair()
        self._wake.settimeout(0)
        self._sockets = Sockets(interfaces(environment)[0], self._process)
        self._closing = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def attend(self, process: str) -> None:
        """Fail as soon as this program has ended."""
        self._attended, self._silent_beats = process, 0.0

    def _subscribe(self, full: str) -> None:
        self._do(lambda: self._sockets.subscriber.subscribe(full))
        self._ask(self._topics, full)

    def wait_for_publisher(self, topic: str, patience: Patience | None = None) -> None:
        """Wait until a topic that is subscribed has a publisher, which knows of it."""
        full = self.full_name(topic)
        known = self._connections
        self.wait(f"no publisher of {topic}", lambda: any(name == full for name, _ in list(known)), patience)

    def publish(self, topic: str, type_name: str, message: Message) -> None:
        """Send a message, of the full name of a type, to all subscribers of a topic; the first time, wait for one."""
        full = self.full_name(topic)
        if full not in self._subscribed:
            self._publications[full] = {
                "topic": full,
                "address": self._sockets.publisher_address,
                "node_uuid": self._node,
                "msg_pub": {"ctrl": "", "msg_type": type_name},
            }
            self._do(lambda: self._topics.send(Event.ADVERTISE, pub=self._publications[full]))
            self.wait(f"no subscriber of {topic}", lambda: full in self._subscribed)
        content = SIM.encode(type_name.rpartition(".")[2], message)
        parts = [part.encode() for part in (full, self._sockets.publisher_address)]
        self._do(lambda: self._sockets.publisher.send_multipart([*parts, content, type_name.encode()]))

    def offers(self, service: str, patience: Patience | None = None) -> list[Message]:
        """Return the publications of all programs that offer a service; SimulatorFailed if none answers."""
        full, wait = self.full_name(service), (patience or self.patience).begin()
        while not self._services.get(full):
            if wait.is_over:
                raise SimulatorFailed(f"Gazebo Sim: no server offers {service}")
            self._ask(self._offers, full)
            with suppress(SimulatorFailed):
                self.wait("", lambda: bool(self._services.get(full)), Patience(seconds=_ASK_AGAIN))
        return list(self._services[full].values())

    def wait_for_answer(self, service: str) -> None:
        """Ask the attended program whether it offers a service; SimulatorFailed if it does not answer."""
        wait, offers = self.patience.begin(), self._services.setdefault(self.full_name(service), {})
        self.update(lambda: offers.pop(self._attended, None))
        while self._attended not in offers:
            if wait.is_over or not self.is_connected:
                raise SimulatorFailed(f"Gazebo Sim: the server does not answer for {service}")
            self._ask(self._offers, self.full_name(service))
            with suppress(SimulatorFailed):
                self.wait("", lambda: self._attended in offers, Patience(seconds=_ASK_AGAIN))

    def all_offers(self, service: str) -> list[Message]:
        """Return the publications of all programs that offer a service and answer within a moment after the first."""
        self._ask(self._offers, self.full_name(service))
        time.sleep(_ASK_AGAIN / 2)
        return self.offers(service)

    def request(
        self, service: str, type_name: str, message: Message, patience: Patience | None = None
    ) -> dict[str, Any]:
        """Return the response of a service to a message of a type; SimulatorFailed if it refuses or does not answer."""
        patience = patience or self.patience
        # Where the response goes and who asks, then the message, then the types of both.
        offer, request_id = self.offers(service, patience)[0], str(uuid.uuid4())
        publisher, own = offer["srv_pub"], self._sockets.responder_address
        parts = [publisher["socket_id"], offer["topic"], own, self._process, self._node, request_id]
        types = [publisher["request_type"].encode(), publisher["response_type"].encode()]
        content = [*(part.encode() for part in parts), SIM.encode(type_name, message), *types]
        self._do(lambda: self._send_request(offer["address"], content, patience.begin()))
        self.wait(f"{service} does not answer", lambda: request_id in self._responses, patience)
        answer, is_done = self._responses.pop(request_id)
        if not is_done:
            raise SimulatorFailed(f"Gazebo Sim: {service} refuses")
        return SIM.decode(publisher["response_type"].rpartition(".")[2], answer)

    def close(self) -> None:
        """Unsubscribe from everything, and disconnect."""
        self._do(self._end)
        self._thread.join()

    def full_name(self, topic: str) -> str:
        """Return the name of a topic or service with its partition."""
        return f"@/{self.partition.strip('/')}@{topic}"

    def _ask(self, where: Discovery, full: str) -> None:
        """Ask all programs who has a topic, or offers a service, of this full name."""
        self._do(lambda: where.send(Event.SUBSCRIBE, sub={"topic": full}))

    def _do(self, work: Callable[[], object]) -> None:
        """Hand work to the thread that owns the sockets."""
        self._work.put(work)
        with suppress(BlockingIOError):  # enough are waiting to wake it
            self._wake.send(b"!")  # any byte

    def _run(self) -> None:
        sockets = self._sockets
        readers: dict[Any, Callable[[], None]] = {
            self._woken.fileno(): self._read_work,
            self._topics.receiver.fileno(): lambda: self._read_discovery(self._topics, self._note_publisher),
            self._offers.receiver.fileno(): lambda: self._read_discovery(self._offers, self._note_service),
            sockets.subscriber: self._read_message,
            sockets.publisher: self._read_subscription,
            sockets.responder: self._read_response,
        }
        for receiver in readers:
            sockets.poller.register(receiver, sockets.receives)
        beat = 0.0  # when the next heartbeat is due
        try:
            while not self._closing:
                if time.monotonic() >= beat:
                    self._beat()
                    beat = time.monotonic() + HEARTBEAT_PERIOD
                for ready, _ in sockets.poller.poll(max(0, int((beat - time.monotonic()) * 1000))):
                    with suppress(KeyError, ValueError, NoMessage, sockets.Error):  # what others send may be anything
                        readers[ready]()
        finally:
            self.fail("the connection is closed")
            for owner in (sockets, self._topics, self._offers, self._wake, self._woken):
                owner.close()

    def _beat(self) -> None:
        """Do what is due each second: tell that we are there, and notice whether the server still does."""
        # Datagrams may get lost, so what we publish, and what has no publisher yet, is announced again each time.
        self._silent_beats = 0.0 if self._attended in self._heard else self._silent_beats + share()
        self._heard.clear()
        if self._attended and self._silent_beats >= _SILENT_BEATS:
            self.fail("the server does not answer any more")
        for discovery in (self._topics, self._offers):
            discovery.send(Event.HEARTBEAT)
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
        process = message["process_uuid"]
        self._heard.add(process)
        if message.get("type") == Event.ADVERTISE and "pub" in message:
            advertised(message["pub"])
        elif message.get("type") == Event.BYE:  # it offers and publishes nothing any more
            if process == self._attended:
                self.fail("the server has ended")
            self.update(lambda: [offers.pop(process, None) for offers in self._services.values()])
            for known in [known for known in self._connections if known[1] == process]:
                del self._connections[known]

    def _note_publisher(self, publication: Message) -> None:
        """Connect to a publisher of a subscribed topic, and register with it.

        A server can publish two types on one topic, as Pose and Pose_V on that of a model's poses, and sends only the
        type with which a subscriber has registered.
        """
        topic, process = publication["topic"], publication["process_uuid"]
        if topic not in self._types or (topic, process) in self._connections:
            return
        kind = publication.get("msg_pub", {}).get("msg_type", "")
        if kind.rpartition(".")[2] != self._types[topic]:
            return
        self._sockets.connect(self._sockets.subscriber, publication["address"])
        registered = {"ctrl": process, "msg_type": kind}
        own = {"topic": topic, "address": publication["address"], "node_uuid": self._node, "msg_pub": registered}
        self._topics.send(Event.NEW_CONNECTION, pub=own)
        self.update(lambda: self._connections.update({(topic, process): own}))

    def _note_service(self, publication: Message) -> None:
        offer = {publication["process_uuid"]: publication}
        self.update(lambda: self._services.setdefault(publication["topic"], {}).update(offer))

    def _read_message(self) -> None:
        full, _, content, kind = self._sockets.subscriber.recv_multipart()[:4]
        topic = full.decode(errors="replace")
        name = self._types.get(topic)
        if name and kind.decode(errors="replace").rpartition(".")[2] == name:
            self.add(topic, partial(SIM.decode, name, content))

    def _read_subscription(self) -> None:
        """Note a subscription: a first byte of 1 says that somebody has subscribed, of 0 that nobody is left."""
        content = self._sockets.publisher.recv()
        change = self._subscribed.add if content[:1] == b"\1" else self._subscribed.discard
        self.update(lambda: change(content[1:].decode(errors="replace")))

    def _read_response(self) -> None:
        *_, request_id, content, result = self._sockets.responder.recv_multipart()
        self.update(lambda: self._responses.update({request_id.decode(): (content, result == b"1")}))

    def _send_request(self, address: str, content: list[bytes], wait: Wait) -> None:
        """Send a request; while the connection is being made, try again."""
        self._sockets.connect(self._sockets.requester, address)
        try:
            self._sockets.requester.send_multipart(content)
        except self._sockets.Error:
            if not wait.is_over:
                time.sleep(_RETRY)
                self._do(lambda: self._send_request(address, content, wait))

    def _end(self) -> None:
        for topic, process in list(self._connections):
            self._topics.send(Event.END_CONNECTION, pub=self._connections[topic, process])
        for discovery in (self._topics, self._offers):
            discovery.send(Event.BYE)
        self._closing = True


def transport_client(environment: Mapping[str, str], patience: Patience) -> AbstractContextManager[TransportClient]:
    """A client at the address in environment variables; it disconnects when this ends."""
    return closing(TransportClient(environment, patience))
