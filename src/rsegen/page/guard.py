"""Let requests through that the page of this server sent, and no other, with bodies of bounded size and depth.

A web page that somebody else made can send requests to this machine too: it has no token, and of the answers it can
read none, as no other origin is allowed. A name that was made to lead here ("DNS rebinding") is not among the hosts
that are answered.
"""

from __future__ import annotations

import ipaddress
import json
import re
from typing import Any
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rsegen.errors import said_by, shown
from rsegen.exporters.browser.page import policy

_FRAMES = "'self' " + " ".join(
    f"{scheme}://{host}:*" for scheme in ("http", "https") for host in ("localhost", "127.0.0.1")
)
"""Who may show the page in a frame: Jupyter on this machine."""


class Answer(JSONResponse):
    """JSON of ASCII letters: texts may have surrogates, which UTF-8 has not."""

    def render(self, content: Any) -> bytes:
        """Return the bytes of a value."""
        return json.dumps(content, separators=(",", ":")).encode("ascii")


class Guard:
    """Filter that lets requests through that no other web page has sent; browsers are forbidden what is not needed."""

    def __init__(self, app: ASGIApp, names: frozenset[str], *, any_address: bool) -> None:
        self.app, self._names, self._any_address = app, names, any_address

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":  # no web sockets
            await send({"type": "websocket.close", "code": 1008})
            return
        headers = Headers(scope=scope)
        problem = self._problem(headers)

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                frames = f"; frame-ancestors {_FRAMES}"
                MutableHeaders(scope=message).update({"Content-Security-Policy": policy("'self'") + frames, **_HEADERS})
            await send(message)

        if problem:
            await Answer({"error": {"where": "", "text": problem}}, 403)(scope, receive, send_guarded)
        else:
            await self.app(scope, receive, send_guarded)

    def _problem(self, headers: Headers) -> str:
        hosts = headers.getlist("host")
        if len(hosts) != 1 or not self._is_ours(hosts[0]):
            return "this address is not the one that rsegen gui printed"
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc.lower() != hosts[0].lower():
            return "only the page of this server may ask"
        return ""

    def _is_ours(self, host: str) -> bool:
        """Return whether a Host header names this machine; an address cannot be made to lead here, as names can."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
            address = None if name in {"localhost", *self._names} else ipaddress.ip_address(name)
        except ValueError:
            return False
        return address is None or address.is_loopback or self._any_address


_HEADERS = {
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}

_DEEPEST = 60
"""Lists and objects in each other in a call: a recipe has five."""


_DISCARDED = 4
"""Times the most that a body may have up to which it is read to its end, and not kept: the answer to a body that is
still being sent may be lost, as a connection that is closed with unread bytes is reset."""


class Refused(Exception):
    """A request that is not answered: its status, and why."""

    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status = status


async def body_of(request: Request, most: int) -> bytes:
    """Return the body of a request; one that is larger is refused, and not kept."""
    size = request.headers.get("content-length", "0")
    too_large = Refused(413, f"more than {most // 2**20} MB at once")
    if not size.isdecimal() or len(size) > 15 or int(size) > _DISCARDED * most:
        raise too_large
    body, read = bytearray(), 0
    try:
        async for part in request.stream():
            read += len(part)
            if read > _DISCARDED * most:
                raise too_large
            if read <= most:
                body += part
    except ClientDisconnect:
        raise Refused(400, "the request ended early") from None
    if read > most:
        raise too_large
    return bytes(body)


def parsed(body: bytes) -> dict[str, Any]:
    """Return a JSON object that can be passed on: not nested too deeply, of texts that can be written."""
    try:
        found = json.loads(body or b"{}", parse_constant=_no_constant)
        _check_values(found)
    except (ValueError, RecursionError) as error:
        raise Refused(400, f"not JSON: {said_by(error)}") from None
    if not isinstance(found, dict):
        raise Refused(400, f"{shown(found)} is not an object of arguments")
    return found


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _check_values(value: Any) -> None:
    """Raise a ValueError for values that are nested too deeply, or texts with half a character."""
    level = [value]
    for _ in range(_DEEPEST):
        below: list[Any] = []
        for each in level:
            if isinstance(each, str):
                each.encode()
            elif isinstance(each, dict):
                below += [*each.keys(), *each.values()]
            elif isinstance(each, list):
                below += each
        if not below:
            return
        level = below
    raise ValueError("nested too deeply")


def file_name(given: str) -> str:
    """Return a name for a file that a page sends: the letters, digits and ending of the given one."""
    return re.sub(r"[^A-Za-z0-9._-]", "_", given.replace("\\", "/").rpartition("/")[2]).lstrip(".")[-100:] or "file"
