"""The ZeroMQ sockets of a client of Gazebo Sim's transport."""

from __future__ import annotations

from typing import Any


class Sockets:
    """Sockets for topics (subscriber, publisher) and services (requester, responder), bound at a host's free ports."""

    def __init__(self, host: str, process: str) -> None:
        import zmq

        self._zmq = zmq
        self._context = zmq.Context()
        self._connected: set[str] = set()
        self.Error = zmq.ZMQError
        self.subscriber = self._context.socket(zmq.SUB)
        self.subscriber.setsockopt(zmq.RCVHWM, 0)
        self.publisher = self._context.socket(zmq.XPUB)
        self.requester, self.responder = (self._context.socket(zmq.ROUTER) for _ in range(2))
        self.requester.setsockopt(zmq.ROUTER_MANDATORY, 1)
        self.responder.setsockopt(zmq.ROUTING_ID, process.encode())
        for each in self.all:
            each.setsockopt(zmq.LINGER, 0)
        self.publisher_address, self.responder_address = (
            self._bound(each, host) for each in (self.publisher, self.responder)
        )

    @property
    def all(self) -> tuple[Any, ...]:
        """All of them."""
        return self.subscriber, self.publisher, self.requester, self.responder

    def subscribe(self, topic: str) -> None:
        """Have the messages of a topic, by its full name, from all publishers that are connected."""
        self.subscriber.setsockopt(self._zmq.SUBSCRIBE, topic.encode())

    def connect(self, own: Any, address: str) -> None:
        """Connect one of them to an address, once."""
        if address not in self._connected:
            self._connected.add(address)
            own.connect(address)

    def poller(self, *others: Any) -> Any:
        """A poller of those that receive, and of other sockets."""
        poller = self._zmq.Poller()
        for each in (self.subscriber, self.publisher, self.responder, *others):
            poller.register(each, self._zmq.POLLIN)
        return poller

    def close(self) -> None:
        """Close them."""
        for each in self.all:
            each.close()
        self._context.term()

    def _bound(self, own: Any, host: str) -> str:
        own.bind(f"tcp://{host}:*")
        return str(own.getsockopt(self._zmq.LAST_ENDPOINT).rstrip(b"\0").decode())
