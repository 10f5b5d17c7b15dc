"""The server of the page: one address of this machine, with a token without which nothing is answered.

    request --Guard: host, origin--> route --token, size, JSON--> types --> call in a thread --> JSON

Nothing that comes in is trusted. The token is in the printed address, as in Jupyter, but not in the command line of the
browser that is opened: other users of the machine can read that. A web page that somebody else made can send
requests to this machine too: it has no token, and of the answers it can read none, as no other origin is allowed. A
name that was made to lead here ("DNS rebinding") is not among the hosts that are answered.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import json
import logging
import mimetypes
import re
import secrets
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rsegen.errors import FileError, ParameterError, RsegenError, library_message, line_of, shown, system_message
from rsegen.page import calls
from rsegen.page.host import Asker, Event, Host, Listener, Opened, asked_by
from rsegen.page.manual import manual_page
from rsegen.page.shown_map import editor_page, policy

_FRAMES = "'self' " + " ".join(
    f"{scheme}://{host}:*" for scheme in ("http", "https") for host in ("localhost", "127.0.0.1")
)
"""Origins that may show the page in a frame: Jupyter on this machine."""


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
        own = {f"{scheme}://{hosts[0].lower()}" for scheme in ("http", "https")}
        return "only the page of this server may ask" if origin is not None and origin.lower() not in own else ""

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
    too_large = Refused(413, f"more than {most // 2**20} MiB at once")
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
        arguments = json.loads(body or b"{}", parse_constant=_no_constant)
        _check_values(arguments)
    except (ValueError, RecursionError) as error:
        raise Refused(400, f"not JSON: {library_message(error)}") from None
    if not isinstance(arguments, dict):
        raise Refused(400, f"{shown(arguments)} is not an object of arguments")
    return arguments


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _check_values(value: Any) -> None:
    """Raise a ValueError for values that are nested too deeply, or texts with half a character."""
    level = [value]
    for _ in range(_DEEPEST):
        below: list[Any] = []
        for node in level:
            if isinstance(node, str):
                node.encode()
            elif isinstance(node, dict):
                below += [*node.keys(), *node.values()]
            elif isinstance(node, list):
                below += node
        if not below:
            return
        level = below
    raise ValueError("nested too deeply")


def file_name(given: str) -> str:
    """Return a name for a file that a page sends: the letters, digits and ending of the given one."""
    return re.sub(r"[^A-Za-z0-9._-]", "_", given.replace("\\", "/").rpartition("/")[2]).lstrip(".")[-100:] or "file"


MOST_CALL, MOST_UPLOAD, MOST_UPLOADED = 4 * 2**20, 64 * 2**20, 2**30
"""Bytes of a call, of a file that a page sends, and of all of these files."""

_STRANGER = "the address has no token: open the one that rsegen gui printed\n"

_ALIVE = 5.0
"""Seconds after which a page hears that the server lives; proxies end what is silent for a minute."""

_MOST_UNHEARD = 1000
"""Events that wait for a page at most; a page that is slower is cut off, and asks again."""

_LOG = logging.getLogger("rsegen.page")


async def _refusal(_: Request, error: Exception) -> Response:
    """Return why a request is not answered, as an error of the user's or of the page's."""
    status = 400
    failure: calls.Failure = {"where": "", "text": str(error)}
    match error:
        case Refused():
            status = error.status
        case RecursionError():
            failure["text"] = "the arguments are nested too deeply"
        case OSError():
            failure["text"] = system_message(error)
        case ParameterError():
            failure = {"where": error.where, "text": error.problem}
        case calls.Question():
            status, failure["kind"] = 409, error.kind
    failure["text"] = line_of(failure["text"])
    # The rest of the body, if there is one, is not read, so nothing else can come on this connection.
    return Answer({"error": failure}, status, {"Connection": "close"})


async def _internal(request: Request, error: Exception) -> Response:
    _LOG.error("%s failed", request.url.path, exc_info=error)
    text = f"internal error, please report it: {type(error).__name__}: {library_message(error)}"
    return Answer({"error": {"where": "", "text": text}}, 500)


@dataclass(eq=False, kw_only=True)
class Desk:
    """The documents and jobs that answer requests, and the pages that listen.

    ended: set when the server ends, which ends all streams
    last_page: when the last page was closed, by the clock of the loop; None while there is one, or was none
    door: a file that leads the first page to its address, and is removed then
    """

    host: Host
    token: str
    ended: asyncio.Event = field(default_factory=asyncio.Event)
    streams: int = 0
    last_page: float | None = None
    door: Path | None = None

    def application(self, names: frozenset[str] = frozenset(), *, any_address: bool = False) -> ASGIApp:
        """Return the application; names: other ones of this machine; any_address: it may be asked by any of its own."""
        calls.load_calls()
        routes = [
            Route("/", self.index),
            Route("/manual", self.manual),
            Route("/api/events", self.events, methods=["POST"]),
            Route("/api/upload", self.upload, methods=["POST"]),
            Route("/api/file", self.file, methods=["POST"]),
            Route("/api/{name}", self.call, methods=["POST"]),
        ]
        refused = dict.fromkeys((Refused, RsegenError, RecursionError, OSError), _refusal)
        handlers: dict[Any, Any] = {**refused, 500: _internal}
        app = Starlette(routes=routes, lifespan=self.lifespan, exception_handlers=handlers)
        return Guard(app, names, any_address=any_address)

    @contextlib.asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        """Watch the files while the server runs."""
        watching = asyncio.create_task(self._watch())
        try:
            yield
        finally:
            watching.cancel()
            self.ended.set()

    async def index(self, request: Request) -> Response:
        """Return the page."""
        if not self._has_token(request):
            return Response(_STRANGER, 403)
        self.remove_door()
        return HTMLResponse(editor_page())

    async def manual(self, request: Request) -> Response:
        """Return the help of all commands as a page."""
        if not self._has_token(request):
            return Response(_STRANGER, 403)
        return HTMLResponse(await run_in_threadpool(manual_page))

    def _has_token(self, request: Request) -> bool:
        token = request.query_params.get("token", "")
        return secrets.compare_digest(token.encode(), self.token.encode())

    def remove_door(self) -> None:
        """Remove the file that led a browser here."""
        if self.door is not None:
            with contextlib.suppress(OSError):
                self.door.unlink()
            self.door = None

    async def call(self, request: Request) -> Response:
        """Answer a call, in a thread; a search ends if its page has gone meanwhile."""
        arguments = await self._arguments(request)
        page = arguments.get("page", "")
        asker = Asker(page=page if isinstance(page, str) else "")
        leaving = asyncio.create_task(_watch_leaving(request, asker))
        try:
            with asked_by(asker):  # also in the thread, which has a copy of the context
                return Answer(await run_in_threadpool(answer, self.host, request.path_params["name"], arguments))
        finally:
            leaving.cancel()

    async def events(self, request: Request) -> Response:
        """Stream the events of a document, a line each, as long as the page is open."""
        known = calls.checked_arguments(_stream_arguments, await self._arguments(request))
        lines = self._lines(self.host.opened(known["doc"]), known.get("page") or secrets.token_hex(8))
        return StreamingResponse(lines, media_type="application/x-ndjson")

    async def upload(self, request: Request) -> Response:
        """Keep the bytes of a file that a page sends, until the server ends; gives its path."""
        self._check_token(request)
        name = file_name(request.query_params.get("name", ""))
        content = await body_of(request, MOST_UPLOAD)
        return Answer({"path": str(await run_in_threadpool(_keep, self.host.uploads, name, content))})

    async def file(self, request: Request) -> Response:
        """Return the bytes of a file in the server's folder, or of one that a page sent."""
        known = calls.checked_arguments(_named, await self._arguments(request))
        path = self.host.places.inside(known["path"])
        if not path.is_file():
            raise Refused(404, f"{known['path']}: there is no such file")
        path.open("rb").close()  # what cannot be read is refused before the answer begins
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
        try:
            await run_in_threadpool(opened.add, listener)
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
            event = waiting[0]
            return event.result() if event.done() else None  # type: ignore[return-value]  # the event
        finally:
            for task in waiting:
                task.cancel()

    async def _watch(self) -> None:
        """Look every second whether somebody else wrote a file that a page has open."""
        while True:
            await asyncio.sleep(1.0)
            for opened in [document for document in self.host.all() if document.pages]:
                await run_in_threadpool(_check_file, opened)

    async def _arguments(self, request: Request) -> dict[str, Any]:
        """Return the arguments of a call that has the token."""
        self._check_token(request)
        return parsed(await body_of(request, MOST_CALL))

    def _check_token(self, request: Request) -> None:
        credentials = request.headers.get("authorization", "")
        if not secrets.compare_digest(credentials.encode(), f"Bearer {self.token}".encode()):
            raise Refused(403, "the token is wrong: open the address that rsegen gui printed last")


async def _watch_leaving(request: Request, asker: Asker) -> None:
    """Note when a page ends the connection of a call whose body was read."""
    while (await request.receive())["type"] != "http.disconnect":
        pass
    asker.has_left = True


def answer(host: Host, name: str, arguments: dict[str, Any]) -> Any:
    """Return what a call gives; the pages of a document hear of it if it has changed."""
    function = calls.OF_HOST.get(name) or calls.OF_DOCUMENT.get(name)
    if function is None:
        raise ParameterError("", f"unknown call {shown(name)}")
    # A page names itself, and its document, in every call, also to functions to which it is all the same.
    named = {"page"} if name in calls.OF_HOST else {"page", "doc"}
    own = {key: value for key, value in arguments.items() if key not in named - {*calls.keywords(function)[0]}}
    known = calls.checked_arguments(function, own)
    doc, page = arguments.get("doc", ""), arguments.get("page", "")
    if not isinstance(doc, str):
        raise ParameterError("doc", f"{shown(doc)} is not a text")
    opened = host.documents.get(doc) if name in calls.OF_HOST else host.opened(doc)
    before = opened.stamp if opened else None
    try:
        if opened is None or name in calls.OF_HOST:
            return function(host, **known)
        with contextlib.nullcontext() if name in calls.AT_ONCE else opened.lock:
            return function(opened, **known)
    finally:
        if opened and opened.stamp != before and opened.id in host.documents:
            opened.send_state(page if isinstance(page, str) else "")


def _stream_arguments(*, doc: str, page: str = "") -> None:
    """Take what a stream of events is asked with."""


def _named(*, path: str) -> None:
    """Take what a file is asked with."""


def _check_file(opened: Opened) -> None:
    if opened.lock.acquire(blocking=False):  # else the next second is early enough
        try:
            if not opened.document.check_file():
                return
        finally:
            opened.lock.release()
        opened.send({"event": "file", "changed_on_disk": opened.document.changed_on_disk})
        opened.send_state("")


def _keep(folder: Path, name: str, content: bytes) -> Path:
    """Write a file into a new folder among those that pages sent."""
    size = sum(path.stat().st_size for path in folder.glob("*/*"))
    if size + len(content) > MOST_UPLOADED:
        raise FileError("too many files were sent; start rsegen gui again")
    own = folder / secrets.token_hex(6)
    own.mkdir()
    (own / name).write_bytes(content)
    return own / name
