"""Runs cases one by one in this process, and judges what they did."""

from __future__ import annotations

import faulthandler
import gc
import importlib
import json
import os
import re
import shutil
import sys
import tempfile
import traceback
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rsegen.input_files import JOURNAL
from tests.fuzz.case import Case
from tests.fuzz.readers import called
from tests.fuzz.sandbox import Exceeded, Sandbox

FREE_MEMORY = 64_000_000
FREE_DISK = 400_000
"""Bytes that rsegen finds free: it refuses what is valid and large, so that a case takes milliseconds."""
SAMPLED = 4000
"""Points that are taken from the surface of a mesh, for the same reason."""
LONGEST_LINE = 1200
SILENCE = 120
"""Seconds after which a case hangs in a library, where no signal ends it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Failure:
    """Problem of a case; `sort` is the same for cases that fail alike."""

    sort: str
    detail: str


@dataclass(frozen=True, kw_only=True, slots=True)
class _Ended:
    """End of a case: exit code, what it printed, the error that it ended by, what else it did."""

    code: object
    out: str
    err: str
    error: BaseException | None
    amiss: tuple[str, ...]


class Judge:
    """Runs cases below a folder, which no other process uses."""

    def __init__(self, root: Path) -> None:
        self._folder, self._temporary = root / "case", root / "tmp"
        for folder in (self._folder, self._temporary, root / "home", root / "bin"):
            folder.mkdir(parents=True)
        self._error: BaseException | None = None
        _small_machine(root)
        _quiet_libraries()
        self._prepare()
        self._streams = [tempfile.TemporaryFile(dir=root) for _ in range(2)]  # noqa: SIM115  # as long as the process
        for number, stream in enumerate(self._streams, 1):
            os.dup2(stream.fileno(), number)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        self._sandbox = Sandbox(root)

    def _prepare(self) -> None:
        """Have heavy modules imported, and remember the errors that commands end by."""
        edge: Any = importlib.import_module("rsegen.cli.edge")
        for name in (
            "matplotlib.pyplot",
            "PIL.Image",
            "yaml",
            "numpy.random",
            "pyarrow.parquet",
            "xml.etree.ElementTree",
            "trimesh",
            "trimesh.exchange.load",
            "trimesh.sample",
            "pypcd4.pypcd4",
            "laspy",
        ):
            importlib.import_module(name)
        importlib.import_module("PIL.Image").init()
        usual = edge.failed

        def failed(error: BaseException, *of: object) -> int:
            self._error = error
            return int(usual(error, *of))

        edge.failed = failed
        building: Any = importlib.import_module("rsegen.recipe.building")
        framed = building.framed

        def counted(*of: object) -> object:
            self._sandbox.maps += 1
            return framed(*of)

        building.framed = counted

    def failure(self, case: Case) -> Failure | None:
        """Problem of a case; None if there is none. If it hangs where Python is not asked, all ends."""
        faulthandler.dump_traceback_later(SILENCE, exit=True, file=self._streams[0])
        return self._in_fork(case) if case.forked else self._here(case)

    def _in_fork(self, case: Case) -> Failure | None:
        read, write = os.pipe()
        child = os.fork()
        if not child:
            try:
                found = self._here(case)
            except BaseException:  # whatever it is, the parent must hear of it
                found = Failure(sort="the trial itself", detail=traceback.format_exc())
            os.write(write, json.dumps(None if found is None else [found.sort, found.detail]).encode())
            os._exit(0)
        os.close(write)
        with os.fdopen(read, "rb") as pipe:
            text = pipe.read()
        _, status = os.waitpid(child, 0)
        if not text:
            return Failure(sort="crash", detail=f"ended by {status}")
        said = json.loads(text)
        return None if said is None else Failure(sort=said[0], detail=said[1])

    def _here(self, case: Case) -> Failure | None:
        os.chdir("/")
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder.mkdir()
        case.lay_out(self._folder)
        os.chdir(self._folder)
        before = _snapshot(self._folder)
        try:
            ended = self._run(case)
        except Exceeded as error:
            gc.collect()  # or what it had would be held against the next one
            if error.honest:
                return None
            return Failure(
                sort=f"too long {_place(error)}", detail=f"more {error} than a case may use: {_place(error)}"
            )
        after = _snapshot(self._folder)
        left = os.listdir(self._temporary)
        for name in left:
            shutil.rmtree(self._temporary / name, ignore_errors=True)
        for check in (_amiss, _misbehaved, _unreadable):
            if found := check(ended):
                return found
        if left:
            return Failure(sort="left in the temporary folder", detail=str(left))
        return _wrote(case, ended, before, after)

    def _run(self, case: Case) -> _Ended:
        for stream in self._streams:
            stream.seek(0)
            stream.truncate()
        self._error = None
        usual = sys.stdout, sys.stderr
        sys.stdout, sys.stderr = (
            open(number, "w", encoding="utf-8", errors=errors, closefd=False)  # noqa: SIM115  # flushed below
            for number, errors in ((1, "strict"), (2, "backslashreplace"))
        )
        try:
            self._sandbox.may_connect = case.family in ("wire", "page")
            with self._sandbox.watched():
                code = called(case.argv)
        finally:
            for each in (sys.stdout, sys.stderr):
                each.flush()
            sys.stdout, sys.stderr = usual
        out, err = (os.pread(number, 10_000_000, 0).decode("utf-8", "surrogateescape") for number in (1, 2))
        return _Ended(code=code, out=out, err=err, error=self._error, amiss=tuple(self._sandbox.amiss))


def _amiss(ended: _Ended) -> Failure | None:
    return Failure(sort=ended.amiss[0].partition(":")[0], detail=ended.amiss[0]) if ended.amiss else None


def _misbehaved(ended: _Ended) -> Failure | None:
    """An exit code that should not be, or other words than the one line that belongs to it."""
    from rsegen.errors import DatasetDamaged

    if "internal error" in ended.err or "Traceback" in ended.err:
        where = _place(ended.error)
        return Failure(sort=f"internal error {where}", detail=f"{ended.err.strip()} {where}")
    fails = isinstance(ended.error, DatasetDamaged) or ended.err.startswith("rsegen: plug-in ")
    differs = bool(ended.out) and not ended.err  # as `compare` says of maps
    if ended.code not in (0, 2) and not (ended.code == 1 and (fails or differs)):
        where = _place(ended.error)
        return Failure(sort=f"exit code {ended.code} {where}", detail=f"{ended.code}: {ended.err.strip()} {where}")
    lines = ended.err.splitlines()
    if ended.code != 0 and not differs and (len(lines) != 1 or not lines[0].startswith("rsegen")):
        return Failure(sort=f"{len(lines)} lines on stderr {_plain(ended.err)}", detail=ended.err)
    if ended.code == 2 and ended.out:
        return Failure(sort=f"printed and refused {_plain(ended.err)}", detail=ended.err)
    if any(not line.startswith("rsegen: ") for line in lines if ended.code == 0):
        return Failure(sort=f"words on stderr {_plain(ended.err)}", detail=ended.err)
    return None


def _unreadable(ended: _Ended) -> Failure | None:
    for text in (ended.out, ended.err):
        if not text.replace("\n", "").replace("\t", "").isprintable():
            return Failure(sort=f"not printable {_plain(text)}", detail=repr(text[:2000]))
    if any(len(line) > LONGEST_LINE for line in ended.err.splitlines()):
        return Failure(sort=f"a long line {_plain(ended.err)}", detail=ended.err)
    return None


def _wrote(case: Case, ended: _Ended, before: Mapping[str, object], after: Mapping[str, object]) -> Failure | None:
    """Changes that should not be: anything if it was refused, else what is no output, or was left half done."""
    changed = [name for name in {*before, *after} if before.get(name) != after.get(name)]
    outputs = () if ended.code == 2 else tuple(os.path.normpath(name) for name in case.outputs)
    journals = {os.path.join(os.path.dirname(one), JOURNAL) for one in outputs}
    for name in sorted(changed):
        inside = name in journals or any(
            one in (".", name) or name.startswith(f"{one}{os.sep}") or one.startswith(name + os.sep) for one in outputs
        )
        if not inside:
            return Failure(
                sort=f"wrote with exit code {ended.code} {_place(ended.error)}", detail=f"{name}: {ended.err}"
            )
        if os.path.basename(name).startswith(".") and os.path.basename(name) != JOURNAL and name in after:
            return Failure(sort="left a hidden file", detail=name)
    return None


def _snapshot(folder: Path) -> dict[str, object]:
    """Everything in a folder, by kind, size and time."""
    found: dict[str, object] = {}
    for home, folders, names in os.walk(folder):
        for name in (*folders, *names):
            path = os.path.join(home, name)
            said = os.lstat(path)
            is_folder = name in folders and not os.path.islink(path)
            found[os.path.relpath(path, folder)] = (
                "folder" if is_folder else (said.st_mode, said.st_size, said.st_mtime_ns)
            )
    return found


def _place(error: BaseException | None) -> str:
    """The last line of rsegen that an error came by, and the sort of error."""
    if error is None:
        return ""
    frames = [
        frame for frame in traceback.extract_tb(error.__traceback__) if f"{os.sep}rsegen{os.sep}" in frame.filename
    ]
    where = f"{frames[-1].filename.rpartition('rsegen' + os.sep)[2]}:{frames[-1].lineno}" if frames else ""
    return f"{type(error).__name__} at {where}"


def _plain(text: str) -> str:
    """The words of a message without what differs from case to case."""
    return " ".join(re.findall(r"[a-z]{3,}", re.sub(r"/\S*/case\b", "", text.partition("\n")[0])))[:80]


def _small_machine(root: Path) -> None:
    """No simulator, no screen, a home and a temporary folder of its own, little memory and disk."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "PYTHONWARNINGS", "RSEGEN_PLUGINS"):
        os.environ.pop(name, None)
    os.environ |= {"PATH": str(root / "bin"), "HOME": str(root / "home"), "TMPDIR": str(root / "tmp")}
    os.environ |= {"MPLCONFIGDIR": str(root / "home"), "MPLBACKEND": "agg", "COLUMNS": "100"}
    tempfile.tempdir = str(root / "tmp")
    sys.dont_write_bytecode = True
    resources: Any = importlib.import_module("rsegen.writing.resources")
    resources._free_memory = lambda: FREE_MEMORY
    resources._free_disk = lambda _: FREE_DISK
    patience: Any = importlib.import_module("rsegen.simulators.patience")
    patience.share = lambda: 1.0
    clouds: Any = importlib.import_module("rsegen.scanning.clouds")
    clouds._SAMPLED = SAMPLED


def _quiet_libraries() -> None:
    """Warnings of numpy's arithmetic are errors: what is computed of what is not a number is wrong."""
    warnings.simplefilter("ignore")
    warnings.filterwarnings("error", category=RuntimeWarning)
