r"""Discovery of Gazebo Sim's transport: who publishes a topic or offers a service, told by UDP multicast.

    rsegen --SUBSCRIBE topic--> all programs        a program that has the topic answers ADVERTISE, with its address
    rsegen --ADVERTISE topic--> all programs        a program that wants the topic connects to our address
    rsegen --NEW_CONNECTION---> the publisher       only then it sends its messages to others than itself
    all    --HEARTBEAT--------> all programs        each second; who is silent for three is gone

Topics and services have a port each. A message is preceded by its length in two bytes.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator, Mapping
from contextlib import suppress
from enum import IntEnum
from typing import Any

from rsegen.errors import SimulatorFailed
from rsegen.simulation.simulators.sim_messages import SIM
from rsegen.simulation.simulators.wire import NO_MESSAGE, Message

HEARTBEAT_PERIOD = 1.0
"""Seconds."""

TOPICS, SERVICES = "MSG", "SRV"
"""The two sorts of what is discovered, as in the names of variables."""

_PORTS = {TOPICS: 10317, SERVICES: 10318}
_GROUP = "239.255.0.7"
_WIRE_VERSION = 10
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
        self._port = int(_variable(environment, f"DISCOVERY_{sort}_PORT") or _PORTS[sort])
        self._relays = [each for each in _variable(environment, "RELAY").split(":") if each]
        self._senders: list[socket.socket] = []
        self.receiver = _udp()
        try:
            self._join(interfaces(environment))
        except OSError as error:
            self.close()
            raise SimulatorFailed(f"Gazebo Sim: no multicast on this computer ({error.strerror or error})") from None

    def send(self, event: Event, **content: Message) -> None:
        """Send a message to all programs; `content`: sub or pub."""
        found = {"version": _WIRE_VERSION, "process_uuid": self._process, "type": event, **content}
        if "pub" in found:
            found["pub"] = {"process_uuid": self._process, "scope": _EVERYWHERE, **content["pub"]}
        message = SIM.encode("Discovery", found)
        for sender in self._senders:
            for host in (self._group, *self._relays):
                with suppress(OSError):  # an interface that is down
                    sender.sendto(struct.pack("<H", len(message)) + message, (host, self._port))

    def receive(self) -> dict[str, Any] | None:
        """The next message of another program of our version; None if it is something else."""
        with suppress(OSError, KeyError, *NO_MESSAGE):
            content = self.receiver.recv(2**16)
            if struct.unpack_from("<H", content)[0] == len(content) - 2:
                message = SIM.decode("Discovery", content[2:])
                if message.get("version") == _WIRE_VERSION and message["process_uuid"] != self._process:
                    return message
        return None

    def close(self) -> None:
        """Close the sockets."""
        for each in (self.receiver, *self._senders):
            each.close()

    def _join(self, addresses: list[str]) -> None:
        for option in (socket.SO_REUSEADDR, getattr(socket, "SO_REUSEPORT", socket.SO_REUSEADDR)):
            self.receiver.setsockopt(socket.SOL_SOCKET, option, 1)
        self.receiver.bind(("", self._port))
        self.receiver.settimeout(0)
        for address in addresses:
            membership = socket.inet_aton(self._group) + socket.inet_aton(address)
            with suppress(OSError):  # an interface without multicast
                self.receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
                sender = _udp()
                self._senders.append(sender)
                sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(address))


def interfaces(environment: Mapping[str, str]) -> list[str]:
    """The addresses of this computer that messages go by: that of GZ_IP or IGN_IP, else all, 127.0.0.1 last."""
    given = _variable(environment, "IP")
    return [given] if given else sorted(set(_addresses()) | {"127.0.0.1"}, key=lambda each: each.startswith("127."))


def partition_of(environment: Mapping[str, str]) -> str:
    """The name that keeps simulations apart, by default that of the computer and the user."""
    import getpass

    given = _variable(environment, "PARTITION")
    return given or f"{socket.gethostname()}:{environment.get('USER') or getpass.getuser()}"


def _variable(environment: Mapping[str, str], name: str) -> str:
    """A variable by its name since Garden, else by that of before."""
    return environment.get(f"GZ_{name}") or environment.get(f"IGN_{name}") or ""


def _addresses() -> Iterator[str]:
    import psutil

    for found in psutil.net_if_addrs().values():
        yield from (each.address for each in found if each.family == socket.AF_INET)


def _udp() -> socket.socket:
    return socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
