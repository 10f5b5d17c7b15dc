"""The server of the page: one address of this machine, with a token without which nothing is answered.

    request --Guard: host, origin, headers--> route --token, size, JSON, types--> call in a thread --> JSON

Nothing that comes in is trusted. A web page that somebody else made can send requests to this machine too: it has no
token, and of the answers it can read none, as no other origin is allowed. A name that was made to lead here ("DNS
rebinding") is not among the hosts that are answered. The token is in the address that is printed, as Jupyter has it.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import json
import logging
import mimetypes
import os
import re
import secrets
import socket
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread
from typing import Any
from urllib.parse import quote, urlsplit

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rsegen.errors import FileError, ParameterError, RsegenError, UserError, said_by, shown
from rsegen.exporters.browser.page import editor_page, policy
from rsegen.page import calls
from rsegen.page.host import Event, Host, Listener, Opened

MOST_CALL, MOST_UPLOAD, MOST_UPLOADED = 4 * 2**20, 64 * 2**20, 2**30
"""Bytes of a call, of a file that a page sends, and of all of these files."""

_DEEPEST = 60
"""Lists and objects in each other in a call: a recipe has five."""

_ALIVE = 5.0
"""Seconds after which a page hears that the server lives; proxies end what is silent for a minute."""

_MOST_UNHEARD = 1000
"""Events that wait for a page at most; a page that is slower is cut off, and asks again."""

_GRACE = 6.0
"""Seconds from the last page to the end: a reload takes one or two, and a page that lost its server tries after 1.5."""

_LOG = logging.getLogger("rsegen.page")

_FRAMES = "'self' " + " ".join(
    f"{scheme}://{host}:*" for scheme in ("http", "https") for host in ("localhost", "127.0.0.1", "[::1]")
)
"""Who may show the page in a frame: Jupyter on this machine."""


def application(host: Host, token: str, *, names: tuple[str, ...] = (), any_address: bool = False) -> ASGIApp:
    """Return the application that serves a host, to requests for this machine, or for other names or addresses."""
    calls.load_calls()
    desk = _Desk(host=host, token=token)
    routes = [
        Route("/", desk.index),
        Route("/api/events", desk.events, methods=["POST"]),
        Route("/api/upload", desk.upload, methods=["POST"]),
        Route("/api/file", desk.file, methods=["POST"]),
        Route("/api/{name}", desk.call, methods=["POST"]),
    ]
    app = Starlette(routes=routes, lifespan=desk.lifespan, exception_handlers={_Refused: _refusal, 500: _internal})
    app.state.desk = desk
    return _Guard(app, frozenset(names), any_address)


class _Refused(Exception):
    """A request that is not answered: its status, and why."""

    def __init__(self, status: int, text: str, where: str = "", kind: str = "") -> None:
        super().__init__(text)
        self.status = status
        self.failure = {"where": where, "text": text} | ({"kind": kind} if kind else {})


async def _refusal(_: Request, error: Exception) -> Response:
    assert isinstance(error, _Refused)  # noqa: S101  # it is registered for these
    # The rest of the body, if there is one, is not read, so nothing else can come on this connection.
    return _Answer({"error": error.failure}, error.status, {"Connection": "close"})


async def _internal(request: Request, error: Exception) -> Response:
    _LOG.error("%s failed", request.url.path, exc_info=error)
    text = f"internal error, please report it: {type(error).__name__}: {said_by(error)}"
    return _Answer({"error": {"where": "", "text": text}}, 500)


class _Answer(JSONResponse):
    """JSON of ASCII letters: texts may have surrogates, which UTF-8 has not."""

    def render(self, content: Any) -> bytes:
        """Return the bytes of a value."""
        return json.dumps(content, separators=(",", ":")).encode("ascii")


class _Guard:
    """Lets requests for this machine through that no other web page has sent, and forbids browsers all that is not
    needed.
    """

    def __init__(self, app: ASGIApp, names: frozenset[str], any_address: bool) -> None:
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
            await _Answer({"error": {"where": "", "text": problem}}, 403)(scope, receive, send_guarded)
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
        """Return whether a Host header names this machine; an address cannot be made to lead elsewhere, as names can."""
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


@dataclass(eq=False, kw_only=True)
class _Desk:
    """What answers requests, and who listens; ended: set when the server ends, which ends all streams.

    last_page: when the last page was closed, by the clock of the loop; None while there is one, or was none
    """

    host: Host
    token: str
    ended: asyncio.Event = field(default_factory=asyncio.Event)
    streams: int = 0
    last_page: float | None = None

    @contextlib.asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        """Watch the files while the server runs, and end the host with it."""
        watching = asyncio.create_task(self._watch())
        try:
            yield
        finally:
            watching.cancel()
            self.ended.set()
            await run_in_threadpool(self.host.close)

    async def index(self, request: Request) -> Response:
        """Return the page."""
        given = request.query_params.get("token", "")
        if not secrets.compare_digest(given.encode(), self.token.encode()):
            return Response("the address lacks its token: use the one that rsegen gui printed\n", 403)
        return HTMLResponse(editor_page())

    async def call(self, request: Request) -> Response:
        """Answer a call, in a thread."""
        arguments = await self._arguments(request)
        name = request.path_params["name"]
        try:
            return _Answer(await run_in_threadpool(answer, self.host, name, arguments))
        except (RsegenError, RecursionError) as error:
            raise _refused(error) from None

    async def events(self, request: Request) -> Response:
        """Stream the events of a document, a line each, as long as the page is open."""
        arguments = await self._arguments(request)
        try:
            known = calls.checked(_heard, arguments)
            opened = self.host.opened(known["doc"])
        except UserError as error:
            raise _refused(error) from None
        page = known.get("page") or secrets.token_hex(8)
        return StreamingResponse(self._lines(opened, page), media_type="application/x-ndjson")

    async def upload(self, request: Request) -> Response:
        """Keep the bytes of a file that a page sends, until the server ends; gives its path."""
        self._check_token(request)
        name = _file_name(request.query_params.get("name", ""))
        content = await _body(request, MOST_UPLOAD)
        try:
            return _Answer({"path": str(await run_in_threadpool(_keep, self.host.uploads, name, content))})
        except UserError as error:
            raise _refused(error) from None

    async def file(self, request: Request) -> Response:
        """Return the bytes of a file in the server's folder, or of one that a page sent."""
        try:
            known = calls.checked(_named, await self._arguments(request))
            path = self.host.inside(known["path"])
        except UserError as error:
            raise _refused(error) from None
        if not path.is_file():
            raise _Refused(404, f"{known['path']}: there is no such file")
        kind = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
        return FileResponse(path, media_type=kind, filename=path.name)

    async def _lines(self, opened: Opened, page: str) -> AsyncIterator[bytes]:
        loop, events = asyncio.get_running_loop(), asyncio.Queue[Event](_MOST_UNHEARD)
        full = asyncio.Event()

        def put(event: Event) -> None:
            try:
                events.put_nowait(event)
            except asyncio.QueueFull:
                full.set()

        def send(event: Event) -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(put, event)

        listener = Listener(page=page, send=send)
        self.streams, self.last_page = self.streams + 1, None
        await run_in_threadpool(opened.add, listener)
        try:
            while not full.is_set() and not self.ended.is_set():
                event = await self._next(events)
                yield json.dumps(event or {"event": "alive"}).encode("ascii") + b"\n"
        finally:
            self.streams -= 1
            if not self.streams:
                self.last_page = loop.time()
            # The stream is cancelled when its page is closed, so a thread tells the others.
            loop.run_in_executor(None, opened.remove, listener)

    async def _next(self, events: asyncio.Queue[Event]) -> Event | None:
        """Return the next event; None if there is none for some seconds, or the server ends."""
        waiting = [asyncio.ensure_future(events.get()), asyncio.ensure_future(self.ended.wait())]
        try:
            await asyncio.wait(waiting, timeout=_ALIVE, return_when=asyncio.FIRST_COMPLETED)
            got = waiting[0]
            return got.result() if got.done() else None  # type: ignore[return-value]  # the event
        finally:
            for each in waiting:
                each.cancel()

    async def _watch(self) -> None:
        """Look every second whether somebody else wrote a file that a page has open."""
        while True:
            await asyncio.sleep(1.0)
            for opened in [each for each in self.host.documents.values() if each.pages]:
                try:
                    await run_in_threadpool(_look, opened)
                except Exception:
                    _LOG.exception("cannot look at %s", opened.document.path)

    async def _arguments(self, request: Request) -> dict[str, Any]:
        """Return the arguments of a call that has the token."""
        self._check_token(request)
        return _parsed(await _body(request, MOST_CALL))

    def _check_token(self, request: Request) -> None:
        given = request.headers.get("authorization", "")
        if not secrets.compare_digest(given.encode(), f"Bearer {self.token}".encode()):
            raise _Refused(403, "the token is wrong: use the address that rsegen gui printed last")


def answer(host: Host, name: str, arguments: dict[str, Any]) -> Any:
    """Return what a call gives; the pages of a document hear of it if it has changed."""
    page = arguments.get("page", "")
    doc = arguments.get("doc", "")
    opened = host.documents.get(doc) if isinstance(doc, str) else None
    before = opened.stamp if opened else None
    try:
        return _called(host, name, arguments)
    finally:
        if opened and opened.stamp != before and opened.id in host.documents:
            opened.tell_state(page if isinstance(page, str) else "")


def _called(host: Host, name: str, arguments: dict[str, Any]) -> Any:
    if name in calls.OF_HOST:
        function = calls.OF_HOST[name]
        return function(host, **calls.checked(function, _without_page(function, arguments)))
    if name not in calls.OF_DOCUMENT:
        raise ParameterError("", f"unknown call {shown(name)}")
    function = calls.OF_DOCUMENT[name]
    own = {key: value for key, value in arguments.items() if key != "doc"}
    known = calls.checked(function, _without_page(function, own))
    doc = arguments.get("doc", "")
    if not isinstance(doc, str):
        raise ParameterError("doc", f"{shown(doc)} is not a text")
    opened = host.opened(doc)
    with contextlib.nullcontext() if name in calls.AT_ONCE else opened.lock:
        return function(opened, **known)


def _without_page(function: Callable[..., Any], arguments: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the arguments without the page that asks, for a function to which it is all the same."""
    if "page" in function.__code__.co_varnames:
        return arguments
    return {key: value for key, value in arguments.items() if key != "page"}


def _heard(*, doc: str, page: str = "") -> None:
    """Take what a stream of events is asked with."""


def _named(*, path: str) -> None:
    """Take what a file is asked with."""


def _look(opened: Opened) -> None:
    if opened.lock.acquire(blocking=False):  # else the next second is early enough
        try:
            if not opened.document.look():
                return
        finally:
            opened.lock.release()
        opened.tell({"event": "file", "changed_on_disk": opened.document.changed_on_disk})
        opened.tell_state("")


def _refused(error: Exception) -> _Refused:
    if isinstance(error, RecursionError):
        return _Refused(400, "the arguments are nested too deeply")
    where = error.where if isinstance(error, ParameterError) else ""
    text = error.problem if isinstance(error, ParameterError) else str(error)
    kind = error.kind if isinstance(error, calls.Question) else ""
    return _Refused(409 if kind else 400, text, where, kind)


async def _body(request: Request, most: int) -> bytes:
    """Return the body of a request; one that is larger is not read to its end."""
    size = request.headers.get("content-length", "0")
    too_large = _Refused(413, f"more than {most // 2**20} MB at once")
    if not size.isdecimal() or len(size) > 15 or int(size) > most:
        raise too_large
    body = bytearray()
    try:
        async for part in request.stream():
            body += part
            if len(body) > most:
                raise too_large
    except ClientDisconnect:
        raise _Refused(400, "the request ended early") from None
    return bytes(body)


def _parsed(body: bytes) -> dict[str, Any]:
    """Return a JSON object that can be passed on: not nested too deeply, of texts that can be written."""
    try:
        found = json.loads(body or b"{}", parse_constant=_no_constant)
        _check_values(found)
    except (ValueError, RecursionError) as error:
        raise _Refused(400, f"not JSON: {said_by(error)}") from None
    if not isinstance(found, dict):
        raise _Refused(400, f"{shown(found)} is not an object of arguments")
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


def _file_name(given: str) -> str:
    """Return a name for a file that a page sends: the letters, digits and ending of the given one."""
    return re.sub(r"[^A-Za-z0-9._-]", "_", given.replace("\\", "/").rpartition("/")[2]).lstrip(".")[-100:] or "file"


def _keep(folder: Path, name: str, content: bytes) -> Path:
    """Write a file into a new folder among those that pages sent."""
    size = sum(path.stat().st_size for path in folder.glob("*/*"))
    if size + len(content) > MOST_UPLOADED:
        raise FileError("too many files were sent; start rsegen gui again")
    own = folder / secrets.token_hex(6)
    own.mkdir()
    (own / name).write_bytes(content)
    return own / name


class _Server(uvicorn.Server):
    """A server that ends the streams of its pages before it waits for what is under way, and ends after its last page.

    keep: it goes on without a page
    """

    def __init__(self, app: ASGIApp, desk: _Desk, *, keep: bool) -> None:
        config = uvicorn.Config(
            app, log_level="critical", access_log=False, server_header=False, ws="none", timeout_graceful_shutdown=10
        )
        super().__init__(config)
        self._desk, self._keep = desk, keep

    async def on_tick(self, counter: int) -> bool:
        """Return whether to end, ten times a second."""
        left = self._desk.last_page
        if not self._keep and left is not None and asyncio.get_running_loop().time() - left > _GRACE:
            self.should_exit = self.should_exit or not any(works() for works in self._desk.host.busy)
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End the streams, then everything else."""
        self._desk.ended.set()
        await super().shutdown(sockets)


@dataclass(kw_only=True)
class Service:
    """A server with its address; run: serve until it ends, in this thread."""

    host: Host
    address: str = "127.0.0.1"
    port: int | None = None
    keep: bool = False
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    _socket: socket.socket = field(init=False)
    _server: _Server = field(init=False)
    _thread: Thread | None = None

    def __post_init__(self) -> None:
        self._socket = _listening(self.address, self.port)
        ip = self._socket.getsockname()[0]
        everywhere = ipaddress.ip_address(ip).is_unspecified
        names = (self.address.lower(), *([socket.gethostname().lower()] if everywhere else []))
        app = application(
            self.host, self.token, names=names, any_address=not ipaddress.ip_address(ip).is_loopback
        )
        self._server = _Server(app, app.app.state.desk, keep=self.keep)  # type: ignore[attr-defined]  # a _Guard

    def url(self, doc: str = "") -> str:
        """Return the address of the page, with its token, and of a document on it."""
        ip, port = self._socket.getsockname()[:2]
        given = ipaddress.ip_address(ip)
        name = "localhost" if given.is_loopback and given.version == 4 else socket.gethostname()
        if not given.is_loopback and not given.is_unspecified or given.version == 6 and given.is_loopback:
            name = f"[{ip}]" if given.version == 6 else ip
        return f"http://{name}:{port}/?token={self.token}" + (f"&doc={quote(doc)}" if doc else "")

    @property
    def listening_port(self) -> int:
        """The port of the address."""
        port: int = self._socket.getsockname()[1]
        return port

    def run(self) -> None:
        """Serve until a signal, or the end of the last page."""
        with self._socket:
            self._server.run(sockets=[self._socket])

    def start(self) -> None:
        """Serve in a thread until `close`, or the end of this process."""
        self._thread = Thread(target=self.run, name="rsegen.gui", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the server that runs in a thread, and what it runs."""
        self._server.should_exit = True
        if self._thread:
            self._thread.join(30)


_PORT = 8437
"""The first choice, so that an address stays the same; another one is taken while this one is in use."""


def _listening(address: str, port: int | None) -> socket.socket:
    """Return a socket that listens at an address; a UserError if it cannot be had."""
    try:
        family, _, _, _, place = socket.getaddrinfo(address, port or 0, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        raise UserError(f"--host: {shown(address)} is no address of this machine ({said_by(error)})") from None
    for tried in (port,) if port is not None else (_PORT, 0):
        try:
            return socket.create_server((place[0], tried), family=family, backlog=128)
        except OSError as error:
            if tried == 0 or port is not None:
                text = f"--host {address}, --port {tried}: cannot be listened at ({os.strerror(error.errno or 0)})"
                raise UserError(text) from None
    raise AssertionError("port 0 is any that is free")
