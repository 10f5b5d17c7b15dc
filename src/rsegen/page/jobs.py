"""Commands that pages run: each is `rsegen COMMAND` in its own process, with a document as its recipe.

    values of a form --CommandForm--> arguments --> rsegen drive course.yaml --robot=burger --json --progress=json
                                                       stderr: progress and report, line by line; stdout: the result

So a page can do what a shell can, with the same checks and messages, and nothing else. The recipe of the document is a
file in a folder of the job's own, so a document that was never saved is run too, and one that is edited meanwhile
changes nothing. A job is stopped as Ctrl-C stops a command, which leaves nothing half written; whatever happens to the
server, a job ends with it, and with a job all that it has started (`writing/programs.py`).
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from itertools import count, islice
from pathlib import Path
from typing import IO, Annotated, Any, Literal, TypedDict

from rsegen.errors import UserError, line_of, system_message
from rsegen.page.places import HOLDS
from rsegen.params.plugins import plugins
from rsegen.params.sorts import Json
from rsegen.recipe.recipe import Recipe
from rsegen.writing.programs import LaunchCommand, RunningProgram, running
from rsegen.writing.recipe_files import save

AT_ONCE = 4
"""Jobs that run at the same time; others wait: a drive takes a core or two."""

_KEPT = 50
"""Jobs that have ended whose outcome is kept."""

_PATIENCE = 15.0
"""Seconds from a stop, which lets a command take away what is half made, to the end of all that it has started."""

_MOST_LINES, _MOST_FILES, _MOST_RESULT = 200, 200, 4_000_000
"""Lines of a report, files that are listed, and letters of a result that pages get."""

_START = "import sys; sys.path[:] = filter(None, sys.path); from rsegen.__main__ import main; sys.exit(main())"
"""The command line without the working folder among the places of modules: its files may come from anybody."""

_WAITS = "waiting for other commands"


class MadeFile(TypedDict):
    """A file that a command wrote."""

    path: str
    name: str
    kind: Literal["picture", "table", "pdf", "recipe", "dataset", "page", "drive"]


@dataclass(kw_only=True)
class Job:
    """A command that waits, runs, or has ended."""

    id: int
    doc: str
    command: str
    line: str  # the same in a shell: "rsegen drive my.yaml --robot burger -o drives"
    state: Literal["running", "done", "failed", "cancelled"] = "running"
    done: float | None = None
    total: float | None = None  # null: unknown
    step: str = _WAITS
    lines: list[str] = field(default_factory=list)  # its report, or the one line of its error
    output: str = ""  # the file or folder that it writes, seen from the folder of pages
    files: list[MadeFile] = field(default_factory=list)
    result: Json = None  # of --json
    opens: str | None = None  # a recipe that a page may open: of scan, import


JobValues = Annotated[dict[str, Any], Job]
"""The values of a job, as pages get them."""


@dataclass(kw_only=True)
class JobRun:
    """The parts of a job: its arguments, the recipe that stands for one of them, and the program while it runs.

    is_shown: whether pages get its changes; stderr_lines: the lines of stderr that are no progress
    """

    job: Job
    arguments: Sequence[str]
    recipe: Recipe | None
    folder: Path
    output: Path | None
    program: RunningProgram | None = None
    is_cancelled: bool = False
    is_shown: bool = True
    stderr_lines: list[str] = field(default_factory=list)
    ended: threading.Event = field(default_factory=threading.Event)


class Jobs:
    """The commands of all documents; `changed` is called with a job, from its own thread, whenever it has changed."""

    def __init__(self, changed: Callable[[JobValues], None] = lambda _: None) -> None:
        self.changed = changed
        self._ids = count(1)
        self._runs: dict[int, JobRun] = {}
        self._lock = threading.Lock()
        self._pool = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="job")

    def start(self, run: JobRun) -> None:
        """Start a command, or let it wait for others."""
        with self._lock:
            self._runs[run.job.id] = run
            ended = [job for job, other in self._runs.items() if other.ended.is_set()]
            for job in ended[: max(len(ended) - _KEPT, 0)]:
                del self._runs[job]
        self.notify(run)
        self._pool.submit(self._work, run)

    def new_id(self) -> int:
        """Return the number of the next job."""
        return next(self._ids)

    def listed(self) -> list[JobValues]:
        """Return all jobs that are known, the oldest first."""
        with self._lock:
            return [asdict(run.job) for run in self._runs.values() if run.is_shown]

    @property
    def are_running(self) -> bool:
        """Return whether a job runs, or waits."""
        with self._lock:
            return not all(run.ended.is_set() for run in self._runs.values())

    def cancel(self, job: int) -> JobValues:
        """Ask a job to stop; it has stopped when its state says so. A UserError for one that is not known."""
        run = self._runs.get(job)
        if run is None:
            raise UserError(f"job {job} is not known any more; run the command again")
        if not run.ended.is_set():
            self._stop(run)
        return asdict(run.job)

    def forget(self, job: int) -> None:
        """Leave a job that has ended out of lists."""
        with self._lock:
            self._runs.pop(job, None)

    def close(self) -> None:
        """Stop all jobs, and wait until nothing of them runs."""
        for run in list(self._runs.values()):
            self._stop(run)
        self._pool.shutdown(cancel_futures=True)

    def _stop(self, run: JobRun) -> None:
        run.is_cancelled = True
        with suppress(ProcessLookupError):
            if run.program and run.program.exit_code is None:
                # SIGTERM stops a command as Ctrl-C does, and is not ignored by what was started in the background.
                run.program.process.send_signal(signal.SIGTERM)

    def notify(self, run: JobRun) -> None:
        """Tell that a job has changed, also what was held back."""
        if run.is_shown:
            self.changed(asdict(run.job))

    def _work(self, run: JobRun) -> None:
        """Run a command from its start to its end."""
        try:
            if run.is_cancelled:
                run.job.state = "cancelled"
            else:
                self._run(run)
        except Exception as error:  # of the system: no processes, a full disk
            problem = system_message(error) if isinstance(error, OSError) else str(error) or type(error).__name__
            run.job.state, run.job.lines = "failed", [line_of(problem)]
        finally:
            run.job.step = ""
            self.notify(run)
            run.ended.set()

    def _run(self, run: JobRun) -> None:
        began = time.time()
        loaded = os.pathsep.join(plugin.module.__file__ or plugin.module.__name__ for plugin in plugins())
        with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
            recipe = []
            if run.recipe is not None:
                file = Path(folder, f"{run.recipe.name}.yaml")
                save(run.recipe, file)
                recipe = [str(file)]
            launch = LaunchCommand(
                command=(sys.executable, "-c", _START, *run.arguments, *recipe),
                environment={"RSEGEN_PLUGINS": loaded, "PYTHONUNBUFFERED": "1"},
                folder=run.folder,
            )
            with Path(folder, "stdout").open("w+", encoding="utf-8", errors="replace") as output:
                code = self._watched(run, launch, output)
                output.seek(0)
                result = output.read(_MOST_RESULT + 1)
        self._conclude(run, code, result, began)

    def _watched(self, run: JobRun, launch: LaunchCommand, output: IO[str]) -> int:
        """Return the exit code of a command, and report its output until then."""
        read, write = os.pipe()
        with os.fdopen(read, encoding="utf-8", errors="replace") as stderr, os.fdopen(write, "w") as end:
            listener = threading.Thread(target=self._listen, args=(run, stderr), daemon=True)
            with running(launch, output, end) as program:
                end.close()  # so what is said ends with the program
                run.program, run.job.step = program, ""
                self.notify(run)
                listener.start()
                code = _exit_code(run, program)
            listener.join()
            return code

    def _listen(self, run: JobRun, stderr: Any) -> None:
        """Take what a command says on stderr: progress, its report, or words."""
        for line in stderr:
            values: Any = {}
            with suppress(ValueError):
                values = json.loads(line) if line.startswith("{") else {}
            if "done" in values:
                run.job.done, run.job.total = values["done"], values.get("total")
                run.job.step = str(values.get("step", ""))
                self.notify(run)
            elif "report" in values:
                run.job.lines = list(map(str, values["report"]))[:_MOST_LINES]
            elif line.strip():
                run.stderr_lines.append(line.strip())
                del run.stderr_lines[:-_MOST_LINES]

    def _conclude(self, run: JobRun, code: int, result: str, began: float) -> None:
        """Say how a command ended: its report and files, or the one line of its error."""
        job = run.job
        if len(result) <= _MOST_RESULT:
            with suppress(ValueError):
                job.result = json.loads(result)
        # What differs is a result too, with exit code 1.
        if code and (run.is_cancelled or job.result is None):
            job.lines = [line.removeprefix("rsegen: ") for line in run.stderr_lines[-1:]]
            job.state = "cancelled" if run.is_cancelled else "failed"
            return
        job.lines = [*job.lines, *run.stderr_lines][:_MOST_LINES]
        if run.output:
            job.files = list(islice(_made(run.folder, run.output, began), _MOST_FILES))
        if run.recipe is None and (made := [file for file in job.files if file["kind"] == "recipe"]):
            job.opens = made[0]["path"]
        job.state = "done"  # last, as a page that lists its jobs meanwhile takes it for the whole outcome


def _exit_code(run: JobRun, program: RunningProgram) -> int:
    """Return the exit code of a command once it has ended, by itself or because it was stopped long enough ago."""
    until = None
    while True:
        with suppress(subprocess.TimeoutExpired):
            return program.process.wait(0.2)
        if run.is_cancelled and until is None:
            until = time.monotonic() + _PATIENCE
            with suppress(ProcessLookupError):
                program.process.send_signal(signal.SIGTERM)  # also if it was cancelled before it ran
        if until is not None and time.monotonic() > until:
            program.end()


_KINDS: Mapping[str, Literal["picture", "table", "pdf", "page"]] = {
    ".png": "picture",
    ".jpg": "picture",
    ".jpeg": "picture",
    ".svg": "picture",
    ".webp": "picture",
    ".csv": "table",
    ".md": "table",
    ".pdf": "pdf",
    ".html": "page",
}


def _made(folder: Path, output: Path, began: float) -> Iterator[MadeFile]:
    """Yield the files for people below an output that were written since a time; seen from the folder of pages."""
    paths = [folder / output] if (folder / output).is_file() else _below(folder / output)
    for path in paths:
        kind = HOLDS.get(path.name) or _KINDS.get(path.suffix)
        if kind == "recipe" and any((path.parent / name).is_file() for name in ("drive.json", "rating.json")):
            continue  # the map of a drive, which is opened with it, or the fields of a rating, each at its own level
        if kind and path.stat().st_mtime >= began - 1:
            shown = path.parent if kind in ("drive", "dataset") else path
            name = path.parent.name if kind == "recipe" else shown.name
            yield {"path": str(shown.relative_to(folder)), "name": name, "kind": kind}


_DEPTH, _MOST_LOOKED_AT = 3, 20_000
"""Folders below an output that are looked into, and entries in all of them: a map has its formats in folders."""


def _below(folder: Path) -> Iterator[Path]:
    """Yield the files below a folder, those above first; hidden ones and links are left out."""
    waiting, left = [(folder, 0)], _MOST_LOOKED_AT
    while waiting:
        place, depth = waiting.pop(0)
        try:
            with os.scandir(place) as entries:
                known = sorted(islice(entries, left), key=lambda entry: entry.name)
        except OSError:
            continue
        left -= len(known)
        for entry in known:
            if entry.name.startswith(".") or entry.is_symlink():
                continue
            if entry.is_file():
                yield Path(entry.path)
            elif depth < _DEPTH:
                waiting.append((Path(entry.path), depth + 1))
