"""Lets requests through that the page of this server sent, and no other.

A web page that somebody else made can send requests to this machine too: it has no token, and of the answers it can
read none, as no other origin is allowed. A name that was made to lead here ("DNS rebinding") is not among the hosts
that are answered.
"""

from __future__ import annotations

import ipaddress
import json
from collections.abc import Mapping
from typing import Any
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

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
    """Lets requests for this machine through that no other web page has sent, and forbids browsers all that is not
    needed.
    """

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
                MutableHeaders(scope=message).update(_guarding_headers())
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


def _guarding_headers() -> Mapping[str, str]:
    return {
        "Content-Security-Policy": policy("'self'") + f"; frame-ancestors {_FRAMES}",
        "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cache-Control": "no-store",
    }
