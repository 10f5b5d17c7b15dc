"""Drafts on disk after every change, so that a crash or a kill loses none.

    $XDG_STATE_HOME/rsegen/HASH-PID.json   the draft of a document whose path has this hash, in the process PID

A draft is there exactly as long as it is not in its file. One of a process that has ended is found by the next one that
opens the same document. It is written whole, beside its place, and then renamed, so a kill leaves the one before.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from hashlib import blake2b
from pathlib import Path
from types import MappingProxyType

from rsegen.page.model.session import Draft


def state_folder() -> Path:
    """Return the folder for what programs keep of a user between their runs, after the XDG base directories."""
    given = os.environ.get("XDG_STATE_HOME", "")
    return (Path(given) if os.path.isabs(given) else Path.home() / ".local" / "state") / "rsegen"


@dataclass(kw_only=True, slots=True)
class Journal:
    """The draft of one document on disk.

    name: the document's path, or another text that only it has; failed: why the draft is not on disk, if it should be
    """

    name: str
    failed: str = ""

    def write(self, draft: Draft) -> None:
        """Write the draft; if that fails, as on a full disk, the work goes on."""
        path = self._path(os.getpid())
        new = path.with_suffix(f".{os.urandom(4).hex()}")
        when = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M")
        content = {"name": self.name, "when": when, "values": dict(draft.values), "rows": [*map(dict, draft.rows)]}
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            with open(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
                json.dump(content, file)
            new.replace(path)
            self.failed = ""
        except OSError as error:
            self.failed = f"changes cannot be kept against a crash: {error.strerror or error}"
            with suppress(OSError):
                new.unlink(missing_ok=True)

    def remove(self) -> None:
        """Remove the draft, as it is saved or discarded; also those of processes that have ended."""
        for path in (self._path(os.getpid()), *self._left()):
            with suppress(OSError):
                path.unlink(missing_ok=True)

    def recovered(self) -> tuple[Draft, str] | None:
        """Return the latest draft of processes that have ended, if one can be read, and when it was made."""
        for path in sorted(self._left(), key=_changed, reverse=True):
            with suppress(OSError, ValueError, TypeError, KeyError, RecursionError):
                content = json.loads(path.read_text("utf-8"))
                rows = tuple(MappingProxyType(dict(row)) for row in content["rows"])
                if content["name"] == self.name:
                    return Draft(values=MappingProxyType(dict(content["values"])), rows=rows), str(content["when"])
        return None

    def _left(self) -> list[Path]:
        """Return the files of processes that have ended: this one has none before it writes its own."""
        found = self._path(0).parent.glob(f"{self._stem}-*.json")
        return [path for path in found if path.stem.rpartition("-")[2].isdecimal() and not _is_being_edited(path)]

    def _path(self, pid: int) -> Path:
        return state_folder() / f"{self._stem}-{pid}.json"

    @property
    def _stem(self) -> str:
        return blake2b(self.name.encode("utf-8", "surrogateescape"), digest_size=12).hexdigest()


def _changed(path: Path) -> float:
    with suppress(OSError):
        return path.stat().st_mtime
    return 0.0


def _is_being_edited(path: Path) -> bool:
    """Return whether the other process that wrote a draft runs: its number may have become that of a later one."""
    import psutil

    pid = int(path.stem.rpartition("-")[2])
    try:
        process = psutil.Process(pid)
        ended = process.status() in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)  # a parent has not asked for it yet
        return pid != os.getpid() and not ended and process.create_time() < _changed(path) + 1
    except (psutil.NoSuchProcess, OverflowError):
        return False
    except psutil.Error:  # of another user, perhaps
        return True
