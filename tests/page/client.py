"""A client of a server of the page: requests as they are, and the events that a page hears."""

from __future__ import annotations

import http.client
import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

TOKEN = "secret"  # noqa: S105  # of servers of tests


@dataclass(frozen=True, kw_only=True)
class Reply:
    """An answer with its status, headers by small names, and bytes."""

    status: int
    headers: Mapping[str, str]
    content: bytes

    def json(self) -> Any:
        return json.loads(self.content)

    @property
    def failure(self) -> dict[str, str]:
        """Error as the page gets it."""
        found: dict[str, str] = self.json()["error"]
        return found


class Client:
    """A browser of a kind: every request is a connection of its own, with the token unless it has another header."""

    def __init__(self, port: int, token: str = TOKEN, *, seconds: float = 20) -> None:
        self.port, self._seconds = port, seconds
        self._headers = {"Host": f"localhost:{port}", "Authorization": f"Bearer {token}"}

    def call(self, name: str, **arguments: Any) -> Any:
        """The value of a call, which must succeed."""
        reply = self.post(f"/api/{name}", arguments)
        assert reply.status == 200, reply.content
        return reply.json()

    def get(self, path: str, **headers: str) -> Reply:
        return self.request("GET", path, b"", headers)

    def post(
        self, path: str, arguments: object = None, /, body: bytes | Iterable[bytes] = b"", **headers: str
    ) -> Reply:
        """The answer to a body, or to arguments as JSON."""
        return self.request("POST", path, body if arguments is None else json.dumps(arguments).encode(), headers)

    def request(self, method: str, path: str, body: bytes | Iterable[bytes], headers: Mapping[str, str]) -> Reply:
        connection = http.client.HTTPConnection("localhost", self.port, timeout=self._seconds)
        try:
            lines = {**self._headers, **{name.replace("_", "-"): value for name, value in headers.items()}}
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            is_whole = isinstance(body, bytes)
            if isinstance(body, bytes):
                lines.setdefault("Content-Length", str(len(body)))
            else:
                lines["Transfer-Encoding"] = "chunked"
            for name, value in lines.items():
                connection.putheader(name, value.encode("latin-1"))
            with suppress(BrokenPipeError, ConnectionResetError):  # it may be answered before it is read
                connection.endheaders(body, encode_chunked=not is_whole)
            answer = connection.getresponse()
            found = {name.lower(): value for name, value in answer.getheaders()}
            return Reply(status=answer.status, headers=found, content=answer.read())
        finally:
            connection.close()

    def events(self, doc: str, page: str) -> Stream:
        return Stream(self.port, self._headers, {"doc": doc, "page": page})


class Stream:
    """The events that a page hears."""

    def __init__(self, port: int, headers: Mapping[str, str], arguments: Mapping[str, str]) -> None:
        self._connection = http.client.HTTPConnection("localhost", port, timeout=20)
        self._connection.request("POST", "/api/events", json.dumps(arguments), dict(headers))
        self._lines = self._connection.getresponse()
        assert self._lines.status == 200

    def until(self, **wanted: Any) -> dict[str, Any]:
        """The next event that has these values, itself or its state."""
        while line := self._lines.readline():
            event: dict[str, Any] = json.loads(line)
            if wanted.items() <= {**event.get("state", {}), **event}.items():
                return event
        raise AssertionError("the stream has ended")

    def rest(self) -> bytes:
        """Everything until its end."""
        return self._lines.read()

    def close(self) -> None:
        self._lines.close()
        self._connection.close()
