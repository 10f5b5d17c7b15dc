"""The client of Gazebo Classic's transport, and servers that connect and disconnect at any moment."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from queue import SimpleQueue

import psutil
import pytest

from rsegen.errors import SimulatorFailed
from rsegen.simulators.classic_transport import TransportClient, transport_client
from rsegen.simulators.patience import Patience
from rsegen.simulators.wire import CLASSIC
from tests.support.patience import until

TOPIC = "/gazebo/lab/request"
SUBSCRIBERS = 4


def packet(kind: str, type_name: str, message: dict[str, object]) -> bytes:
    inside = {"type": kind, "serialized_data": CLASSIC.encode(type_name, message), "stamp": {"sec": 1}}
    content = CLASSIC.encode("Packet", inside)
    return b"%08X" % len(content) + content


@contextmanager
def a_client() -> Iterator[TransportClient]:
    """A client of a master that only tells the name of its world."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = server.getsockname()

        def serve() -> None:
            client, _ = server.accept()
            with client:
                client.sendall(packet("topic_namepaces_init", "GzString_V", {"data": ["lab"]}))
                while client.recv(4096):
                    pass

        threading.Thread(target=serve, daemon=True).start()
        with transport_client(address, Patience(seconds=5.0, sign=5.0)) as client:
            try:
                yield client
            finally:
                with suppress(OSError):
                    client._master.shutdown(socket.SHUT_RDWR)


def subscriber(client: TransportClient) -> socket.socket:
    return socket.create_connection(client._own.getsockname(), 5)


def test_every_subscriber_gets_every_unread_message(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with a_client() as client:
        waiting: SimpleQueue[Callable[[], None]] = SimpleQueue()
        start = client._start_thread
        monkeypatch.setattr(client, "_start_thread", waiting.put)
        others = [subscriber(client) for _ in range(SUBSCRIBERS)]
        for run in [waiting.get(timeout=10) for _ in others]:
            start(run)
        for other in others:
            other.sendall(packet("sub", "Subscribe", {"topic": TOPIC, "host": "127.0.0.1", "port": 1}))
        client.wait("subscribers are lost", lambda: len(client._subscribers[TOPIC]) == SUBSCRIBERS)
        client.publish("~/request", "GzString", {"data": "hello"})
        for other in others:
            with other, other.makefile("rb") as stream:
                assert CLASSIC.decode("GzString", stream.read(int(stream.read(8), 16))) == {"data": "hello"}


def test_a_closed_client_refuses_connections() -> None:
    with a_client() as client:
        address = client._own.getsockname()
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(address, 5)


def test_a_connection_that_comes_while_a_client_is_closed_is_closed_too() -> None:
    with a_client() as client:
        pass
    ours, theirs = connected()
    with theirs:
        assert client._registered(ours).fileno() == -1
        assert theirs.recv(1) == b""


def test_a_publisher_that_is_gone_already_is_no_error() -> None:
    with a_client() as client:
        with socket.create_server(("127.0.0.1", 0)) as gone:
            port = gone.getsockname()[1]
        for host, number in (("127.0.0.1", port), ("127.0.0.1", 2**31), ("127.0.0.1", -1), ("\0", port), ("a" * 99, 1)):
            client._read_publisher(TOPIC, host, number)
        assert client._publishers == {}


def test_a_closed_client_leaves_no_thread_and_no_socket() -> None:
    before = threading.active_count(), open_sockets()
    for _ in range(5):
        with a_client() as client:
            others = [subscriber(client) for _ in range(SUBSCRIBERS)]
            for other in others:
                other.sendall(packet("sub", "Subscribe", {"topic": TOPIC, "host": "127.0.0.1", "port": 1}))
            client.wait("subscribers are lost", lambda: len(client._subscribers[TOPIC]) == SUBSCRIBERS)
        for other in others:
            assert other.recv(1) == b""
            other.close()
    until(lambda: (threading.active_count(), open_sockets()) <= before)


def open_sockets() -> int:
    return len(psutil.Process().net_connections("tcp"))


@pytest.mark.parametrize(
    "junk",
    [
        b"-0000001",
        b"FFFFFFFF",
        b"0x000001a",
        b"     001a",
        b"00000003\x0a\xff\xff",
        b"0000000B\x0a\xf5\xff\xff\xff\xff\xff\xff\xff\xff\x01",
        b"00000000",
        b"00000010short",
    ],
)
def test_junk_ends_or_is_passed_over_and_others_are_served(junk: bytes) -> None:
    with a_client() as client:
        hostile = subscriber(client)
        with hostile, subscriber(client) as other:
            hostile.sendall(junk)
            hostile.shutdown(socket.SHUT_WR)
            assert hostile.recv(1) == b""
            other.sendall(packet("sub", "Subscribe", {}) + packet("sub", "Subscribe", {"topic": TOPIC}))
            client.wait("a subscriber is lost", lambda: bool(client._subscribers[TOPIC]))
            client.publish("~/request", "GzString", {"data": "hello"})
            with other.makefile("rb") as stream:
                assert CLASSIC.decode("GzString", stream.read(int(stream.read(8), 16))) == {"data": "hello"}


def test_a_master_may_send_anything() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            client, _ = server.accept()
            with client:
                for junk in (b"", b"\x0a\xff", b"\x12\xf5\xff\xff\xff\xff\xff\xff\xff\xff\x01", b"\xff" * 20):
                    client.sendall(b"%08X" % len(junk) + junk)
                client.sendall(packet("publisher_add", "Publish", {"topic": TOPIC}))
                client.sendall(packet("topic_namepaces_init", "GzString_V", {"data": ["lab"]}))
                while client.recv(4096):
                    pass

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        with transport_client(server.getsockname(), Patience(seconds=5.0, sign=5.0)) as client:
            assert client.world == "lab"
        thread.join(5)
        assert not thread.is_alive()


def connected() -> tuple[socket.socket, socket.socket]:
    """Two sockets of TCP that are connected."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        ours = socket.create_connection(server.getsockname(), 5)
        return ours, server.accept()[0]


def test_a_subscriber_that_reads_nothing_is_given_up_after_the_patience() -> None:
    with a_client() as client, subscriber(client) as other:
        other.sendall(packet("sub", "Subscribe", {"topic": TOPIC, "host": "127.0.0.1", "port": 1}))
        client.wait("a subscriber is lost", lambda: bool(client._subscribers[TOPIC]))
        client.patience = Patience(seconds=0.5, sign=0.5)
        began = time.monotonic()
        with pytest.raises(SimulatorFailed, match=r"the server accepted no message for 0\.5 s"):
            client.publish("~/request", "GzString", {"data": "x" * 2**25})
        assert 0.4 < time.monotonic() - began < 15


def test_a_subscriber_that_reads_slowly_gets_all() -> None:
    with a_client() as client, subscriber(client) as other:
        other.sendall(packet("sub", "Subscribe", {"topic": TOPIC, "host": "127.0.0.1", "port": 1}))
        client.wait("a subscriber is lost", lambda: bool(client._subscribers[TOPIC]))
        text = "".join(chr(97 + i % 26) for i in range(2**22))
        sending = threading.Thread(target=client.publish, args=("~/request", "GzString", {"data": text}))
        sending.start()
        with other.makefile("rb") as stream:
            time.sleep(0.3)
            assert sending.is_alive()
            assert CLASSIC.decode("GzString", stream.read(int(stream.read(8), 16))) == {"data": text}
        sending.join(10)
        assert not sending.is_alive()
