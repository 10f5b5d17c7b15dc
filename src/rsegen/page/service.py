"""A server that runs: its address, its end, and a thread for it and the page in an output cell of a notebook."""

from __future__ import annotations

import asyncio
import atexit
import ipaddress
import os
import re
import secrets
import socket
import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from hashlib import blake2b
from html import escape
from pathlib import Path
from threading import Thread
from urllib.parse import quote

import uvicorn
from starlette.types import ASGIApp

from rsegen.errors import FileError, ParameterError, library_message, shown
from rsegen.input_files import regular_content
from rsegen.page.documents import open as open_document
from rsegen.page.host import Host
from rsegen.page.model.session import Session
from rsegen.page.server import Desk
from rsegen.recipe.recipe import Recipe
from rsegen.writing.user_state import create_private, state_folder

_GRACE = 6.0
"""Seconds from the last page to the end: a reload takes one or two, and a page that lost its server tries after 1.5."""


class _Server(uvicorn.Server):
    """A server that ends the streams of its pages before it waits for what is under way, and ends after its last page.

    keep: it goes on without a page
    """

    def __init__(self, app: ASGIApp, desk: Desk, *, keep: bool) -> None:
        config = uvicorn.Config(
            app,
            log_config=None,
            access_log=False,
            server_header=False,
            proxy_headers=False,
            ws="none",
            timeout_graceful_shutdown=10,
        )
        super().__init__(config)
        self._desk, self._keep = desk, keep

    async def on_tick(self, counter: int) -> bool:
        """Return whether to end, ten times a second."""
        left = self._desk.last_page
        if not self._keep and left is not None and asyncio.get_running_loop().time() - left > _GRACE:
            self.should_exit = self.should_exit or not self._desk.host.jobs.are_running
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End the streams, then everything else."""
        self._desk.ended.set()
        await super().shutdown(sockets)


@dataclass(kw_only=True)
class Service:
    """A server with its address; is_open_to_others: whether other machines may reach it."""

    host: Host
    address: str = "127.0.0.1"
    port: int | None = None
    keep: bool = False
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    listening_port: int = field(init=False)
    is_open_to_others: bool = field(init=False)
    _ip: ipaddress.IPv4Address | ipaddress.IPv6Address = field(init=False)
    _socket: socket.socket = field(init=False)
    _desk: Desk = field(init=False)
    _server: _Server = field(init=False)
    _thread: Thread | None = None

    def __post_init__(self) -> None:
        self._socket = _listening(self.address, self.port)
        ip, self.listening_port = self._socket.getsockname()[:2]
        self._ip = ipaddress.ip_address(ip)
        self.is_open_to_others = not self._ip.is_loopback
        names = [self.address.lower(), *([socket.gethostname().lower()] if self._ip.is_unspecified else [])]
        self._desk = Desk(host=self.host, token=self.token)
        app = self._desk.application(frozenset(names), any_address=self.is_open_to_others)
        self._server = _Server(app, self._desk, keep=self.keep)

    def url(self, doc: str = "", play: str = "") -> str:
        """Return the address of the page, with its token, of a document on it, and of a drive that plays over it."""
        name = f"[{self._ip}]" if self._ip.version == 6 else str(self._ip)
        name = socket.gethostname() if self._ip.is_unspecified else "localhost" if name == "127.0.0.1" else name
        opened = self.host.documents.get(doc)
        parts = {"open": opened.opens_again if opened else "", "doc": doc, "play": play}
        shown = "".join(f"&{key}={quote(value)}" for key, value in parts.items() if value)
        return f"http://{name}:{self.listening_port}/?token={self.token}{shown}"

    def keep_token(self) -> None:
        """Take the token that an earlier server in this folder had, so that its addresses open the page again.

        Only on this machine alone: an address that was given to others ends with its server.
        """
        if not self.is_open_to_others:
            self.token = self._desk.token = _kept_token(self.host.folder.resolve())

    def write_door(self, url: str) -> Path:
        """Write a file that leads a browser to an address, which only this user can read; it is removed when it did.

        An address that a browser is started with stands in the list of processes, which every user of the machine can
        read. The file is in the folder of the page: browsers of snap and flatpak see no temporary folder and no hidden
        file. Only where that folder cannot be written to is it a temporary one.
        """
        page = f'<!doctype html><meta http-equiv="refresh" content="0;url={escape(url)}"><title>rsegen</title>\n'
        for folder in (self.host.folder, None):
            with suppress(OSError):
                file, name = tempfile.mkstemp(".html", "rsegen-", folder)
                break
        else:
            raise FileError("no file can be written that leads the browser to the page; open the address above")
        with os.fdopen(file, "w", encoding="utf-8") as written:
            written.write(page)
        self._desk.door = Path(name)
        return self._desk.door

    def run(self) -> None:
        """Serve until a signal, or the end of the last page."""
        try:
            with self._socket:
                self._server.run(sockets=[self._socket])
        finally:  # a signal is raised once more when the server has ended
            self._desk.remove_door()
            self.host.close()

    def start(self) -> None:
        """Serve in a thread until `close`, or the end of this process."""
        self._thread = Thread(target=self.run, name="rsegen.gui", daemon=True)
        self._thread.start()
        atexit.register(self.close)

    def close(self) -> None:
        """End the server that runs in a thread, and what it runs."""
        atexit.unregister(self.close)
        self._server.should_exit = True
        if self._thread:
            self._thread.join(30)
        self._socket.close()


def _kept_token(folder: Path) -> str:
    """Return the token of servers in a folder, kept in a file of this user's; a new one where none can be written."""
    token = secrets.token_urlsafe(24)
    digest = blake2b(os.fsencode(folder), digest_size=12).hexdigest()
    path = state_folder() / f"{digest}.token"
    with suppress(OSError):
        with suppress(FileExistsError):
            create_private(path, token)
            return token
        earlier = regular_content(path, 100) or b""
        if re.fullmatch(rb"[A-Za-z0-9_-]{32}", earlier):
            return earlier.decode("ascii")
    return token


_PORT = 8437
"""The first choice, so that an address stays the same; another one is taken while this one is in use."""


def _listening(address: str, port: int | None) -> socket.socket:
    """Return a socket that listens at an address; a ParameterError if it cannot be had."""
    try:
        family, _, _, _, place = socket.getaddrinfo(address, port or 0, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        raise ParameterError(
            "host", f"{shown(address)} is no address of this machine ({library_message(error)})"
        ) from None
    if port is None:
        with suppress(OSError):
            return socket.create_server((place[0], _PORT), family=family)
    try:
        return socket.create_server((place[0], port or 0), family=family)
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        raise ParameterError("port", f"cannot listen on port {port} of {address} ({reason})") from None


class Gui:
    """A page that edits a recipe, shown in an output cell; `recipe` is its current recipe.

    Its server ends with `close`, in a `with` statement at its end, and with the notebook's kernel.

    Parameters
    ----------
    service : Service
        The server of the page.
    doc : str
        The id of the document that it shows.
    """

    def __init__(self, service: Service, doc: str) -> None:
        self._service, self._doc = service, doc
        service.start()

    @property
    def url(self) -> str:
        """The address of the page, with its token; browsers on this machine can open it too."""
        return self._service.url(self._doc)

    @property
    def recipe(self) -> Recipe:
        """The recipe as it is on the page now; the last valid one, if it is not."""
        return self._service.host.opened(self._doc).session.recipe

    def close(self) -> None:
        """End the server, and with it what it runs."""
        self._service.close()

    def __enter__(self) -> Gui:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """Return the page in a frame, which notebooks show."""
        frame = 'width="100%" height="760" style="border: 0" allow="clipboard-write; fullscreen"'
        return f'<iframe {frame} src="{escape(self.url)}"></iframe>'


def gui(shown: Recipe | str | Path | None = None, *, folder: str | Path = ".", port: int | None = None) -> Gui:
    """Return a page that edits a recipe: `rsegen.gui(recipe)` in a cell of Jupyter.

    Parameters
    ----------
    shown : Recipe, str or Path, optional
        A recipe, the path of a file in `folder`, or the name of an example; by default a new recipe.
    folder : str or Path, default '.'
        Where the page reads and writes files.
    port : int, optional
        Port of its address, of which a remote machine's must be forwarded; by default a free one.

    Returns
    -------
    Gui
        The page, with its recipe.

    Raises
    ------
    UserError
        If the page, or its port, cannot be had.
    """
    host = Host(folder=Path(folder).resolve())
    if isinstance(shown, Recipe):
        doc = host.open(Session.of(shown)).id
    else:
        doc = open_document(host, what=str(shown or ""))["doc"]
    return Gui(Service(host=host, port=port, keep=True), doc)
