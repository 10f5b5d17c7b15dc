"""The host of all documents that pages have open: recipes that are edited, each with its history and its file.

Two pages on one file share its document; `documents.py` has the calls that open, edit and save them. Calls run in
threads; of one document one at a time, under its lock, but for those that only read. What changes is sent to all pages
of the document, as events.
"""

from __future__ import annotations

import os
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from secrets import token_hex
from tempfile import TemporaryDirectory
from threading import Lock, RLock
from typing import Any, Literal, TypedDict

from rsegen.errors import ParameterError, TooLarge, UserError
from rsegen.page.jobs import Jobs, JobValues
from rsegen.page.model.actions import Ends, ends_of
from rsegen.page.model.document import Document, DraftFile
from rsegen.page.model.session import Entry, Session, is_enabled
from rsegen.page.places import Places
from rsegen.params.sorts import Json


class Row(TypedDict):
    """An obstacle in the list of a document."""

    entry: Entry  # without whether it is switched on
    enabled: bool
    ends: Ends | None  # where it lies in the map shown, also if drawn at random


class Problem(TypedDict):
    """The reason why a draft is invalid; the scene shows the last valid one."""

    where: str
    text: str


class PlaceInDataSet(TypedDict):
    """The place of a map in a data set."""

    folder: str
    place: int  # from 0 on, as in DIR#17
    maps: int


class State(TypedDict):
    """Everything that pages show of a document."""

    doc: str
    opens: str  # by what it is opened again after a restart; empty: a new recipe
    revision: int  # counts changes, undo included
    title: str
    path: str | None
    unsaved: bool
    can_undo: bool
    can_redo: bool
    values: dict[str, Json]  # global parameters
    rows: list[Row]
    problem: Problem | None
    maps: int
    first_map: int
    data_set: PlaceInDataSet | None  # that the recipe is the map of
    name: str
    changed_on_disk: bool  # somebody else wrote the file
    file_is_gone: bool  # somebody else removed or renamed it
    recovered: str | None  # changes of a session that ended without saving were brought back: when
    journal: str  # why changes would be lost in a crash, such as a full disk; empty: they would not
    pages: int  # that have it open


Search = Literal["tilt", "reach", "crossing", "way", "measure", "variants"]
"""Searches on a map, of which the newest of each name is done."""


class StateChanged(TypedDict):
    """A document has changed."""

    event: Literal["state"]
    state: State
    page: str  # that changed it


class JobChanged(TypedDict):
    """A job of a document has changed."""

    event: Literal["job"]
    job: JobValues


class FileChanged(TypedDict):
    """Somebody else wrote the file of a document, or took that back."""

    event: Literal["file"]
    changed_on_disk: bool


class SearchProgress(TypedDict):
    """Progress of a search, 0 to 1, or of one of its steps."""

    event: Literal["progress"]
    of: Search
    step: str  # in words; empty if it has one alone
    share: float


class Alive(TypedDict):
    """The server lives."""

    event: Literal["alive"]


Event = StateChanged | JobChanged | FileChanged | SearchProgress | Alive

MOST_DOCUMENTS = 100
"""Documents that are open at once at most; of those that no page has open, saved ones are closed first."""


@dataclass(eq=False, kw_only=True)
class Asker:
    """The page that a call is of, by the name that it gave itself, and whether it has gone before it was answered."""

    page: str = ""
    has_left: bool = False


_ASKER: ContextVar[Asker | None] = ContextVar("who asked for what is done", default=None)


@contextmanager
def asked_by(asker: Asker) -> Iterator[None]:
    """Let searches inside belong to a page, and end if it has gone."""
    token = _ASKER.set(asker)
    try:
        yield
    finally:
        _ASKER.reset(token)


@dataclass(eq=False, kw_only=True)
class Listener:
    """A page that hears the events of a document; send: called with each, from any thread."""

    page: str
    send: Callable[[Event], None]


_SENT_EVERY = 0.2
"""Seconds between two tellings of how far a search is."""


@dataclass(eq=False, kw_only=True)
class Opened:
    """A document that pages have open.

    shown: the map that each page shows, by the name that the page gave itself; kept: what was made of its maps, by
    keys; searches: the newest request of each search of each page, by both names; data_set: that it is a map of, if it
    is one; what: by which it was opened, and is again after a restart; home: the folder of the host
    """

    id: str
    document: Document
    home: Path
    what: str = ""
    data_set: PlaceInDataSet | None = None
    lock: RLock = field(default_factory=RLock)
    shown: dict[str, int] = field(default_factory=dict)
    kept: OrderedDict[object, Any] = field(default_factory=OrderedDict)
    searches: dict[tuple[str, str], object] = field(default_factory=dict)
    _turns: dict[str, Lock] = field(default_factory=dict)
    _listeners: list[Listener] = field(default_factory=list)

    @property
    def session(self) -> Session:
        """The recipe with its history."""
        return self.document.session

    @property
    def opens_again(self) -> str:
        """Argument of `open` to open it again, also in another server in this folder: its file, or what was given."""
        path = self.document.path
        return str(path.relative_to(self.home)) if path and path.is_relative_to(self.home) else self.what

    @property
    def pages(self) -> int:
        """The number of pages that have it open."""
        return len({listener.page for listener in self._listeners})

    @property
    def stamp(self) -> tuple[object, ...]:
        """Return a value that differs after every change that pages show."""
        document = self.document
        return self.session.revision, document.path, document.changed_on_disk, document.recovered, self.session.unsaved

    def add(self, listener: Listener) -> None:
        """Send events to a page from now on, and say to all how many pages there are."""
        self._listeners.append(listener)
        self.send_state("")

    def remove(self, listener: Listener) -> None:
        """Send no more events to a page, end its searches, and say to the others how many are left."""
        if listener in self._listeners:
            self._listeners.remove(listener)
        if listener.page not in {other.page for other in self._listeners}:
            self.shown.pop(listener.page, None)
            for name, page in (*self.searches,):
                if page == listener.page:
                    self.searches.pop((name, page), None)
        self.send_state("")

    def send(self, event: Event, page: str = "") -> None:
        """Send an event to every page of the document, or to one alone; may be called in any thread."""
        for listener in (*self._listeners,):
            if page in ("", listener.page):
                listener.send(event)

    def send_state(self, page: str) -> None:
        """Send the state to every page, each with the ends in the map that it shows; page: which one changed it."""
        states: dict[int, State] = {}
        with self.lock:
            for listener in (*self._listeners,):
                index = self.index_of(listener.page)
                states[index] = states.get(index) or state_of(self, index)
                listener.send({"event": "state", "state": states[index], "page": page})

    @contextmanager
    def newest_turn(self, name: Search) -> Iterator[Callable[..., None]]:
        """Wait until no search of this name is done; a UserError for a request that a newer one of its page replaced.

        So of those that wait the newest of each page alone is done, and none whose page has gone. Yields a function for
        what takes seconds to call now and then, with the share that is done, and of which step, if the page shall see
        it: it raises that error too.
        """
        asker = _ASKER.get() or Asker()
        self.searches[name, asker.page] = own = object()
        last_sent = 0.0

        def watch(share: float | None = None, step: str = "") -> None:
            nonlocal last_sent
            if asker.has_left or self.searches.get((name, asker.page)) is not own:
                raise UserError("it was stopped, or a newer request replaced it")
            if share is not None and time.monotonic() - last_sent > _SENT_EVERY:
                last_sent = time.monotonic()
                self.send({"event": "progress", "of": name, "step": step, "share": share}, asker.page)

        try:
            # Who waited here and is no longer the newest is refused before it starts.
            with self._turns.setdefault(name, Lock()):
                watch()
                yield watch
        finally:
            if self.searches.get((name, asker.page)) is own:
                del self.searches[name, asker.page]

    def stop_search(self, name: Search) -> None:
        """Stop the search of a name that is done for the page that asks."""
        self.searches.pop((name, (_ASKER.get() or Asker()).page), None)

    def index_of(self, page: str, given: int | None = None, *, or_first: bool = False) -> int:
        """Return the map that a page shows, remembered if it is given; the first one if nothing is known.

        A ParameterError if there is no such map; `or_first`: then too the first one, as another page took it away.
        """
        recipe = self.session.recipe
        index = self.shown.get(page, recipe.first_map) if given is None else given
        if index in recipe.indices:
            if page:
                self.shown[page] = index
            return index
        if given is not None and not or_first:
            raise ParameterError("index", f"{given} is outside {recipe.indices[0]}..{recipe.indices[-1]}")
        return recipe.first_map


@dataclass(kw_only=True)
class Host:
    """Documents by their ids, the folder in which files may be read and written, and the commands that run."""

    folder: Path
    jobs: Jobs = field(default_factory=Jobs)
    documents: dict[str, Opened] = field(default_factory=dict)
    _ids: Iterator[int] = field(default_factory=lambda: count(1))
    _own: str = field(default_factory=lambda: token_hex(3))
    _temporary: TemporaryDirectory[str] | None = None
    _lock: RLock = field(default_factory=RLock)

    def __post_init__(self) -> None:
        self.jobs.changed = self.send_job

    def opened(self, name: str) -> Opened:
        """Return a document by its id."""
        if name not in self.documents:
            raise UserError(f"document {name or '(none)'} is not open here any more: reload the page")
        return self.documents[name]

    def open(self, session: Session | None = None, title: str = "untitled", text: str = "") -> Opened:
        """Open a session that has no file as a document; without a session a new recipe.

        Changes of a document without a file that an earlier process did not save are brought back: all of them for a
        new recipe, and for another session only changes of a document that began as it does.
        """
        begins = session or Session.of()
        with self._lock:
            # Documents without a file are numbered; the number is the name of the draft on disk.
            taken = {opened.document.journal.name for opened in self.all()}
            drafts = (DraftFile(name=f"{self.folder.resolve()}: untitled {number}") for number in count(1))
            free = (draft for draft in drafts if draft.name not in taken)
            journal = next(draft for draft in free if session is None or draft.is_free_for(begins.draft))
            return self._add(Document(session=begins, journal=journal, title=title, text=text))

    def open_file(self, path: Path) -> Opened:
        """Open a recipe file as a document, or return the document that it is open as."""
        with self._lock:
            for opened in self.all():
                if opened.document.path == path:
                    return opened
            return self._add(Document.of_file(path))

    def all(self) -> list[Opened]:
        """Return all documents."""
        return list(self.documents.values())

    def send_job(self, job: JobValues) -> None:
        """Say to the pages of a job's document what has become of it."""
        if opened := self.documents.get(job["doc"]):
            opened.send({"event": "job", "job": job})

    @property
    def read_only(self) -> str:
        """Return why nothing can be saved in the folder, with advice; an empty text if it can."""
        if os.access(self.folder, os.W_OK | os.X_OK):
            return ""
        return f"{self.folder} is read-only, so nothing can be saved; start rsegen gui in another folder to save"

    def close(self) -> None:
        """End what runs, and remove what was uploaded; what is not saved stays in the journal."""
        self.jobs.close()
        if self._temporary is not None:
            self._temporary.cleanup()

    @property
    def uploads(self) -> Path:
        """The folder of the files that pages sent, which is removed at the end."""
        with self._lock:
            if self._temporary is None:
                self._temporary = TemporaryDirectory(prefix="rsegen-", ignore_cleanup_errors=True)
            return Path(self._temporary.name).resolve()

    @property
    def places(self) -> Places:
        """Return the folders in which files may be read and written."""
        return Places(self.folder, self.uploads if self._temporary else None)

    def _add(self, document: Document) -> Opened:
        if len(self.documents) >= MOST_DOCUMENTS:
            unused = [opened.id for opened in self.all() if not opened.pages and not opened.session.unsaved]
            if not unused:
                raise TooLarge(f"{MOST_DOCUMENTS} recipes with unsaved changes are open; save or close some")
            del self.documents[unused[0]]
        # No document of another server has the number, as an address may be opened after a restart.
        opened = Opened(id=f"d{next(self._ids)}-{self._own}", document=document, home=self.folder.resolve())
        self.documents[opened.id] = opened
        return opened


def state_of(opened: Opened, index: int) -> State:
    """Return all that pages show of a document, with the ends of obstacles in map `index`."""
    document, session = opened.document, opened.session
    problem, recipe = session.problem, session.recipe
    return {
        "doc": opened.id,
        "opens": opened.opens_again,
        "revision": session.revision,
        "title": document.shown_title,
        "path": str(document.path) if document.path else None,
        "unsaved": session.unsaved,
        "can_undo": session.can_undo,
        "can_redo": session.can_redo,
        "values": dict(session.draft.values),
        # The switch of a row is a value of its own, next to its entry.
        "rows": [
            {
                "entry": {name: value for name, value in entry.items() if name != "enabled"},
                "enabled": is_enabled(entry),
                "ends": ends_of(entry, recipe, index),
            }
            for entry in session.draft.rows
        ],
        "problem": {"where": problem.where, "text": problem.problem} if problem else None,
        "maps": recipe.maps,
        "first_map": recipe.first_map,
        "data_set": None if document.path else opened.data_set,
        "name": recipe.name,
        "changed_on_disk": document.changed_on_disk,
        "file_is_gone": document.file_is_gone,
        "recovered": document.recovered,
        "journal": document.journal.failed,
        "pages": opened.pages,
    }
