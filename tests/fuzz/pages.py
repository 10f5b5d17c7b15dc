"""Conversations with a server of the page: calls that are right, half right, broken, and several at the same time.

number --> calls of every name, their arguments damaged --HTTP, with the token--> server: one line, or an answer
                                                        --> its documents: valid, undone and done again as they were
"""

from __future__ import annotations

import json
import os
import random
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch
from urllib.parse import quote

from rsegen.page import calls
from rsegen.page.command_forms import command_forms
from rsegen.page.host import Host
from rsegen.page.jobs import JobRun, Jobs
from rsegen.page.model.actions import actions
from rsegen.page.service import Service
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import decode
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import load
from tests.fuzz.damage import damaged_bytes, damaged_text
from tests.fuzz.hostile import TEXTS, as_text, damaged_tree, scalar
from tests.page.client import TOKEN, Client, Reply

CALLS = 50
"""Calls of a conversation, and some more that look at what they left."""
FOLDER = "maps"
FILES: Mapping[str, str] = {
    "course.yaml": "# a course\nname: course\nseed: 7\nmaps: 2\nchunk_size: 6\nobstacles:\n"
    "  - kind: random  # rough\n    levels: 4\n  - {kind: peak, levels: 3, first: [1, 1], last: [4, 4]}\n",
    "flat.json": '{"seed": 3, "chunk_size": 5, "boundary": "none"}\n',
}
"""The recipes in the folder of the page."""
MOST_BLOCKS = 400
"""Blocks of a map of which a robot is asked: of more it takes seconds, as it may."""
LONGEST_LINE = 1200
SILENCE = 80
"""Seconds of wall time without an answer after which a server hangs."""
_ALLOWED = {200, 400, 403, 404, 405, 409, 413}
_SLOW = {"tilt", "reach", "way", "crossing", "measure", "pose", "variants", "maps", "results", "scene"}
_SELDOM = {"hello", "example_maps", "close", "crossing", "reach", "way", "tilt", "measure"}


class Wrong(AssertionError):
    """Error of a server that does what it must not do."""


class _NoJobs(Jobs):
    """Jobs that fail at once, as a process must not start others here; what commands do is tried by other families."""

    def start(self, run: JobRun) -> None:
        """Let a job fail."""
        self._runs[run.job.id] = run
        run.job.state, run.job.lines = "failed", ["nothing runs here"]
        run.ended.set()
        self.notify(run)


def talk(number: int) -> int:
    """Hold a conversation in the working folder, and return how many calls were answered; Wrong if one was not."""
    rng = random.Random(number)  # noqa: S311  # no secret
    with _served() as service, ExitStack() as stack:
        client = Client(service.listening_port, seconds=SILENCE)
        doc = client.call("open", what="course.yaml")["doc"]
        for page in ("a", "b"):  # of which one is never read
            stack.callback(client.events(doc, page).close)
        talked = _Talk(rng, service.host, client)
        talked.look()
        while talked.asked < CALLS:
            talked.ask_some()
            talked.look()
        talked.undo_all()
    return talked.asked


@contextmanager
def _served() -> Iterator[Service]:
    folder = Path.cwd() / FOLDER
    with patch.dict(os.environ, {"XDG_STATE_HOME": str(Path.cwd() / "kept")}):
        service = Service(host=Host(folder=folder, jobs=_NoJobs()), port=0, keep=True, token=TOKEN)
        service.start()
        try:
            yield service
        finally:
            service.close()


class _Talk:
    """A conversation so far: what each document began with, and what the files held."""

    def __init__(self, rng: random.Random, host: Host, client: Client) -> None:
        self._rng, self._host, self._client = rng, host, client
        self._began: dict[str, Any] = {}
        self._files: dict[Path, bytes] = {}
        self.asked = 0

    # Calls.

    def ask_some(self) -> None:
        """Send a request, or several at the same time, and judge the answers."""
        several = self._rng.random() < 0.2
        requests = [self._request() for _ in range(self._rng.randint(2, 6) if several else 1)]
        with ThreadPoolExecutor(len(requests)) as pool:
            for request, reply in zip(requests, pool.map(lambda send: send[1](), requests), strict=True):
                _judge(request[0], reply)
        self.asked += len(requests)
        if not any("/api/save" in shown for shown, _ in requests):
            self._check_files()
        self._files = self._contents()

    def _request(self) -> tuple[str, Callable[[], Reply]]:
        """Draw a request: how it is shown, and what sends it."""
        rng, client = self._rng, self._client
        kind = rng.random()
        if kind < 0.03:
            path = rng.choice(("/", "/manual", "/api/hello", "/nothing", f"/{quote(rng.choice(TEXTS))[:500]}"))
            given = f"{path}?token={rng.choice((TOKEN, 'x', ''))}"
            return given, lambda: client.get(given)
        if kind < 0.06:
            path = f"/api/upload?name={quote(rng.choice((*TEXTS, 'a.csv', 'b.yaml'))[:200], errors='replace')}"
            content = damaged_bytes(rng, b"1,2\n3,4\n" * 10)
            return path, lambda: client.post(path, body=content)
        name = self._name()
        body = self._body(name)
        stranger = rng.random() < 0.02
        headers = {"Authorization": "Bearer x"} if stranger else {}
        path = f"/api/{name}"
        if name == "crossing":  # it drives for half a minute, and a page stops it
            return path, lambda: self._stopped(path, body)
        return f"{path} {body[:300]!r}", lambda: client.post(path, body=body, **headers)

    def _stopped(self, path: str, body: bytes) -> Reply:
        """Ask for a search, and stop those of all documents until it ends."""
        with ThreadPoolExecutor(1) as pool:
            reply = pool.submit(self._client.post, path, body=body)
            while not wait([reply], timeout=0.3).done:
                for doc in [*self._host.documents]:
                    self._client.post("/api/stop", {"doc": doc, "of": "crossing"})
            return reply.result()

    def _name(self) -> str:
        rng = self._rng
        known = [*calls.OF_HOST, *calls.OF_DOCUMENT, "file"]
        while True:
            name = rng.choice((*known, *["edit"] * 2 * len(known)))
            too_slow = name in _SLOW and any(_blocks(opened) > MOST_BLOCKS for opened in self._host.all())
            if not too_slow and (name not in _SELDOM or rng.random() < 0.3):
                return name if rng.random() < 0.99 else quote(rng.choice(TEXTS)[:100], errors="replace", safe="")

    def _body(self, name: str) -> bytes:
        rng = self._rng
        function = calls.OF_HOST.get(name) or calls.OF_DOCUMENT.get(name)
        arguments = self._arguments(function) if function else {"path": self._value("path")}
        if name in calls.OF_DOCUMENT:
            arguments["doc"] = self._value("doc")
        way = rng.random()
        if way < 0.45:
            return json.dumps(arguments).encode()
        tree = damaged_tree(rng, arguments, yaml=False)
        text = as_text(tree).encode("utf-8", "surrogatepass")
        return damaged_text(rng, text) if way > 0.92 else text

    def _arguments(self, function: Callable[..., Any]) -> dict[str, Any]:
        """Draw arguments of a function or an action by their names; those with a default only now and then."""
        known, needed = calls.keywords(function)
        return {name: self._value(name) for name in known if name in needed or self._rng.random() < 0.4}

    def _value(self, name: str) -> Any:
        """Draw a value that belongs to a name."""
        rng = self._rng

        def cell() -> list[int]:
            return [rng.randrange(7), rng.randrange(7)]

        own: Mapping[str, Callable[[], Any]] = {
            "doc": lambda: rng.choice([*self._host.documents] * 20 + ["d0-000000"]),
            "actions": lambda: [self._action() for _ in range(rng.choice((1, 1, 1, 2, 3, 8)))],
            "entry": self._entry,
            "value": lambda: rng.choice((1, 2, 5, 6, 10, "outer", [2, 1], 3, None)),
            "name": lambda: rng.choice([*parameters(Recipe)]),
            "cell": cell,
            "cells": lambda: [cell() for _ in range(rng.randrange(9))],
            "values": lambda: {rng.choice(("map", "robot", "to", "seed")): rng.choice(("a", 1, "stl", ["stl"]))},
            "start": lambda: [rng.uniform(-1, 1), rng.uniform(-1, 1)],
            "goal": lambda: [rng.uniform(-1, 1), rng.uniform(-1, 1)],
            "paths": lambda: [self._value("path") for _ in range(rng.randrange(4))],
            "command": lambda: rng.choice([*command_forms()]),
            "best": lambda: rng.choice(("length", "tilt", "margin")),
        }
        if name in own:
            return own[name]()
        return rng.choice(_VALUES.get(name, _VALUES["index"]))

    def _action(self) -> dict[str, Any]:
        name = self._rng.choice([*actions(), "add", "undo", "redo", "paint"])
        return {"do": name, **self._arguments(actions()[name])}

    def _entry(self) -> dict[str, Any]:
        rng = self._rng
        entry = {"kind": rng.choice(_KINDS), "levels": rng.randint(2, 6)}
        if rng.random() < 0.6:
            entry |= {"first": [rng.randrange(6), rng.randrange(6)], "last": [rng.randrange(6), rng.randrange(6)]}
        if rng.random() < 0.3:
            entry |= {rng.choice(("softness", "key", "weights", "enabled", "blend", "rows")): scalar(rng, yaml=False)}
        return json.loads(json.dumps(entry, default=str))  # type: ignore[no-any-return]  # an object

    # What they left.

    def look(self) -> None:
        """Raise Wrong for a document whose recipe is not that of its list, or that cannot be asked for."""
        for doc in [*self._host.documents]:
            opened = self._host.documents[doc]
            held = self._state(doc)
            recipe = opened.session.recipe
            if held["problem"] is None and _recipe(held) != recipe:
                raise Wrong(f"{doc}: the list is another recipe than the session's")
            if decode(json.loads(json.dumps(recipe.entry()))) != recipe:
                raise Wrong(f"{doc}: the recipe is not valid")
            self._began.setdefault(doc, _draft(held))

    def undo_all(self) -> None:
        """Raise Wrong for a document that undone is not what it began with, or done again not what it was."""
        for doc, began in self._began.items():
            if doc not in self._host.documents:
                continue
            end = self._moved(doc, "redo")
            if self._moved(doc, "undo") != began:
                raise Wrong(f"{doc}: undone, it is not what it began with")
            if self._moved(doc, "redo") != end:
                raise Wrong(f"{doc}: done again, it is not what it was")

    def _moved(self, doc: str, direction: str) -> Any:
        while (held := self._state(doc))[f"can_{direction}"]:
            self._client.call("edit", doc=doc, actions=[{"do": direction}] * 20)
        return _draft(held)

    def _state(self, doc: str) -> Any:
        reply = self._client.post("/api/state", {"doc": doc})
        _judge("state", reply)
        if reply.status != 200:
            raise Wrong(f"{doc}: has no state: {reply.content[:300]!r}")
        return reply.json()

    def _contents(self) -> dict[Path, bytes]:
        return {path: path.read_bytes() for path in Path(FOLDER).rglob("*") if path.is_file()}

    def _check_files(self) -> None:
        """Raise Wrong for a file that changed though nothing was saved, or that is no recipe."""
        now = self._contents()
        if self._files and now != self._files:
            raise Wrong(f"files changed: {sorted(map(str, {*now.items()} ^ {*self._files.items()}))[:3]}")
        for path in now:
            load(path)


_KINDS = ("peak", "platform", "random", "normal_random", "horizontal_barrier", "diagonal_barrier", "pit", "stairs", "x")
_VALUES: Mapping[str, tuple[Any, ...]] = {
    "page": ("a", "b", ""),
    "index": (0, 1, 2, None),
    "row": (0, 1, 2, 3, -1),
    "to": (0, 1, 2),
    "at": (0, 1, None),
    "level": (-1, 0, 1, 5),
    "end": ("first", "last", "both"),
    "enabled": (True, False),
    "replace": (True, False),
    "gesture": ("g", "h", None),
    "what": ("", "", "course.yaml", "flat.json", "mixed-course", "peak", "course.yaml#1", "missing.yaml", "../a.yaml"),
    "folder": ("", ".", "sub", "..", "/"),
    "path": ("", "course.yaml", "flat.json", "new.yaml", "new.json", "a.txt", "no/such.yaml", "../a.yaml", ".a.yaml"),
    "output": ("", "out", "out.png", "../out"),
    "target": ("", "course.yaml", "missing"),
    "map_name": ("", "course_0000", "x"),
    "count": (1, 2, 3),
    "first": (0, 1, 5),
    "by": ("", "steps.rms", "nothing"),
    "of": ("tilt", "reach", "crossing", "way", "measure", "variants"),
    "robot": ("burger", "crawler", "jackal", "course.yaml", "nobody"),
    "x": (0.0, 0.1, -0.3, 9.0),
    "y": (0.0, 0.1, -0.3, 9.0),
    "heading": (0.0, 1.5, 400.0),
    "job": (1, 2, 0),
    "judge": ("x", "the prediction by its poses"),
    "trial": (0, 1, -1),
}
"""Values that belong to parameters of calls and actions, right ones and some that are not, by their names."""


def _judge(shown: str, reply: Reply) -> None:
    """Raise Wrong for an answer that says of an internal error, or says what is wrong in no readable line."""
    if reply.status not in _ALLOWED:
        raise Wrong(f"{reply.status} {reply.content[:600]!r} after {shown}")
    if not shown.startswith("/api/") or reply.status == 200:
        return
    try:
        text = reply.failure["text"]
    except (ValueError, KeyError, TypeError):
        if reply.status in (404, 405):  # no such route
            return
        raise Wrong(f"{reply.status} without a line: {reply.content[:300]!r} after {shown}") from None
    if "\n" in text or "internal error" in text or not text or len(text) > LONGEST_LINE:
        raise Wrong(f"{reply.status} {text[:600]!r} after {shown}")


def _blocks(opened: Any) -> int:
    n_x, n_y = opened.session.recipe.grid.shape
    return int(n_x * n_y)


def _recipe(held: Mapping[str, Any]) -> Recipe:
    rows = [{**row["entry"], **({} if row["enabled"] else {"enabled": False})} for row in held["rows"]]
    return decode({**held["values"], "obstacles": rows})


def _draft(held: Mapping[str, Any]) -> Any:
    return held["values"], [(row["entry"], row["enabled"]) for row in held["rows"]]
