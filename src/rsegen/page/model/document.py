"""A recipe that is open, with its file: read, saved, watched, and kept in a journal while it is not saved.

A journal has drafts on disk after every change, so that a crash or a kill loses none:

    $XDG_STATE_HOME/rsegen/HASH-PID.json   the draft of a document whose path has this hash, in the process PID

A draft knows the checksum of the text that it began with: if somebody has changed the file since, a draft that is
brought back is reported as a conflict. A draft exists exactly as long as it is not in its file. The draft of a process
that has ended is found by the next process that opens the same document. It is written whole, next to its place, and
then renamed, so a kill leaves the one before.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields
from datetime import datetime
from hashlib import blake2b
from pathlib import Path
from types import MappingProxyType

from rsegen.errors import FileError, ParameterError, UserError, system_reason
from rsegen.input_files import regular_content
from rsegen.page.calls import Question
from rsegen.page.model.session import Draft, Session
from rsegen.page.model.texts import text_after
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import MAX_RECIPE_MIB, recipe_and_content
from rsegen.writing.store import write_file
from rsegen.writing.user_state import state_file, state_files, state_folder, write_state

SUFFIXES = (".yaml", ".yml", ".json")
"""Suffixes of recipe files."""


@dataclass(kw_only=True)
class Document:
    """A session and its file.

    title: what a page calls it while it has no file; text: of the file, as it was read or written last; recovered: when
    changes were made that an earlier process did not save, and that were brought back; file_is_gone: somebody removed
    or renamed the file, so the recipe is saved nowhere
    """

    session: Session
    journal: DraftFile
    title: str = "untitled"
    path: Path | None = None
    text: str = ""
    changed_on_disk: bool = False
    recovered: str | None = None
    file_is_gone: bool = False
    _was_saved: Draft | None = None
    _start: Draft = field(init=False)
    _stamp: tuple[int, int] | None = None
    _began_with: str = field(init=False)

    def __post_init__(self) -> None:
        self._start = self.session.draft
        self._stamp = self._stamp_now()
        self._began_with = _checksum(self.text.encode())
        self.session.changed = self._session_changed
        self.journal.start = start_of(self._start)
        if recovered := self.journal.recovered():
            draft, self.recovered, self._began_with = recovered
            self.session.restore(draft)
            self.changed_on_disk = self._differs()

    @classmethod
    def of_file(cls, path: Path) -> Document:
        """Return the document of a recipe file, with the changes that an earlier process did not save."""
        text = _read(path)
        return cls(session=session_of_file(path), journal=DraftFile(name=str(path)), path=path, title="", text=text)

    @property
    def shown_title(self) -> str:
        """Return the title on a page: the name of the file, or, in the folder of a map or a drive, of the map."""
        if self.path and self.path.name == "recipe.json":
            return self.session.recipe.map_name(self.session.recipe.first_map)
        return self.path.name if self.path else self.title

    def save(self, path: Path | None = None, *, replace: bool = False) -> None:
        """Write the recipe to its file or another one; a Question if that would replace what somebody else wrote."""
        target = path or self.path
        if target is None:
            raise UserError("the recipe has no file yet; choose a name")
        if target.suffix.lower() not in SUFFIXES:
            raise FileError(f"{target.name}: a recipe must be a .yaml or .json file")
        if not replace:
            self._ask_before(target)
        # If the file cannot be written, the new name is taken back too.
        with self.session.all_or_nothing():
            if target != self.path:
                self._take_name_of(target)
            recipe = self.session.draft.recipe()
            same_kind = (target.suffix.lower() == ".json") == self.text.lstrip().startswith("{")
            text = text_after(self.text if same_kind else "", recipe, target.suffix)
            write_file([text.encode()], target, force=True)
        if target != self.path:
            self.journal.remove()
            self.journal = DraftFile(name=str(target))
        self.path, self.text = target, text
        self._saved()

    def reload(self) -> None:
        """Take over what is in the file, or what a document without one began with; undo takes it back."""
        draft = self._start
        if self.path is not None:
            self.text, draft = _read(self.path), session_of_file(self.path).draft
        self.session.saved = draft
        self.session.restore(draft)
        self._saved()

    def check_file(self) -> bool:
        """Look whether somebody else wrote or removed the file; return whether that has changed since the last look."""
        stamp = self._stamp_now()
        if stamp == self._stamp:
            return False
        self._stamp, before = stamp, (self.changed_on_disk, self.file_is_gone)
        self.changed_on_disk = self._differs()
        self._note_removal(is_gone=stamp is None and not os.path.lexists(self.path or ""))
        return (self.changed_on_disk, self.file_is_gone) != before

    def _note_removal(self, *, is_gone: bool) -> None:
        """Count what was in the file as not saved while there is no file, so that it stays in the journal."""
        if is_gone == self.file_is_gone:
            return
        self.file_is_gone = is_gone
        if is_gone:
            self._was_saved, self.session.saved = self.session.saved, None
        else:
            self.session.saved = self._was_saved
        self._session_changed()

    def _saved(self) -> None:
        """Remember that the draft is in the file."""
        self.session.saved, self.file_is_gone = self.session.draft, False
        self.changed_on_disk, self.recovered, self._stamp = False, None, self._stamp_now()
        self._session_changed()

    def _session_changed(self) -> None:
        if self.session.unsaved:
            self.journal.write(self.session.draft, self._began_with)
        else:
            self.journal.remove()
            self.recovered, self._began_with = None, _checksum(self.text.encode())
            self.changed_on_disk = self._differs()

    def _ask_before(self, target: Path) -> None:
        if target == self.path:
            if self._differs():
                self.changed_on_disk = True
                raise Question(f"{target.name} was changed by another program after you opened it", "changed")
        elif os.path.lexists(target):
            raise Question(f"{target.name} exists already", "exists")

    def _differs(self) -> bool:
        """Return whether the file has another text than the draft began with; one that is gone can be written anew."""
        try:
            return self.path is not None and _checksum(self.path.read_bytes()) != self._began_with
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:
            return True

    def _stamp_now(self) -> tuple[int, int] | None:
        """Return what shows without reading the file that it may have changed."""
        with suppress(OSError):
            if self.path is not None:
                status = self.path.stat()
                return status.st_mtime_ns, status.st_size
        return None

    def _take_name_of(self, target: Path) -> None:
        """Call the maps as the file, if they have no name of their own, and the file's name can be one."""
        name = self.session.draft.values.get("name", _DEFAULT_NAME)
        if name in (_DEFAULT_NAME, self.path.stem if self.path else _DEFAULT_NAME):
            with suppress(ParameterError):
                self.session.set(name="name", value=parameters(Recipe)["name"].check("name", target.stem))


_DEFAULT_NAME = next(known.default for known in fields(Recipe) if known.name == "name")


def _checksum(content: bytes) -> str:
    return blake2b(content, digest_size=16).hexdigest()


def session_of_file(path: Path) -> Session:
    """Return a session with the recipe in a file, whose obstacles keep the keys that they have there."""
    recipe, content = recipe_and_content(path)
    rows = content.get("obstacles") if isinstance(content, Mapping) else None
    keys = (row.get("key") for row in rows or () if isinstance(row, Mapping))
    return Session.of(recipe, frozenset(key for key in keys if isinstance(key, str)))


def _read(path: Path) -> str:
    """Return the text of a recipe file, line ends as they are; empty if it has none, which loading it then says."""
    most = MAX_RECIPE_MIB.get(path.suffix.lower(), MAX_RECIPE_MIB[".yaml"]) * 2**20
    return (regular_content(path, most) or b"").decode("utf-8", "replace")


def start_of(draft: Draft) -> str:
    """Return a checksum of a draft as a document begins with it."""
    return _checksum(json.dumps([dict(draft.values), [*map(dict, draft.rows)]], sort_keys=True, default=str).encode())


@dataclass(kw_only=True, slots=True)
class DraftFile:
    """The draft of one document on disk.

    name: the document's path, or another text that only it has; start: the checksum of what the draft was made of;
    failed: why the draft is not on disk, if it should be
    """

    name: str
    start: str = ""
    failed: str = ""

    def write(self, draft: Draft, began_with: str) -> None:
        """Write the draft and the checksum of the text that it began with; if that fails (disk full), work goes on."""
        when = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M")
        values, rows = dict(draft.values), [*map(dict, draft.rows)]
        content = {"name": self.name, "when": when, "began_with": began_with, "values": values, "rows": rows}
        content |= {"own": sorted(draft.own), "start": self.start}
        try:
            write_state(self._stem, content)
            self.failed = ""
        except OSError as error:
            reason = system_reason(error)
            self.failed = f"unsaved changes are lost if rsegen ends: they cannot be kept in {state_folder()} ({reason})"

    def remove(self) -> None:
        """Remove the draft, as it is saved or discarded, and all drafts of it by processes that have ended."""
        for path in (state_file(self._stem), *self._left()):
            with suppress(OSError):
                path.unlink(missing_ok=True)

    def recovered(self) -> tuple[Draft, str, str] | None:
        """Return the latest draft of processes that have ended, if one can be read.

        With it come the time at which it was made, and the checksum of the text that it began with.
        """
        for path in self._left():
            with suppress(OSError, ValueError, TypeError, KeyError, RecursionError):
                content = json.loads(path.read_text("utf-8"))
                rows = tuple(MappingProxyType(dict(row)) for row in content["rows"])
                if content["name"] == self.name:
                    self.start = str(content.get("start", ""))
                    values, own = MappingProxyType(dict(content["values"])), frozenset(map(str, content["own"]))
                    draft = Draft(values=values, rows=rows, own=own)
                    return draft, str(content["when"]), str(content["began_with"])
        return None

    def is_free_for(self, draft: Draft) -> bool:
        """Return whether processes that have ended left no draft here, or one that was made of this draft."""
        return self.recovered() is None or self.start == start_of(draft)

    def _left(self) -> list[Path]:
        """Return the files of processes that have ended, the newest first; this one has none before it writes."""
        own = state_file(self._stem)
        return [path for path, runs in state_files(self._stem) if path == own or not runs]

    @property
    def _stem(self) -> str:
        return blake2b(self.name.encode("utf-8", "surrogateescape"), digest_size=12).hexdigest()
