"""One trial: a run that is killed, or meets a full disk, then goes on; what is wrong after it is a line."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil

from tests.crash.commands import Run
from tests.support.complaints import snapshot

Files = Mapping[str, bytes | None]

_LONGEST = 600


def killed(run: Run, folder: Path, whole: Files, seconds: float, rng: random.Random) -> list[str]:
    """What is wrong after a run is killed at a random moment, maybe again while it goes on, and then ends.

    seconds: how long an undisturbed run takes. Killed are all of its processes at once, or only one of them.
    """
    run.prepared(folder)
    before = snapshot(folder)
    problems: list[str] = []
    for command in [run.command, *[run.goes_on] * rng.choice((0, 0, 1, 2))]:
        kill_after(started(command, folder), rng.uniform(0, 1.1 * seconds), rng)
        problems += _half_written(folder, before, whole)
    return [*problems, *_gone_on(run, folder, whole)]


def on_a_full_disk(run: Run, disk: Path, whole: Files, rng: random.Random) -> list[str]:
    """What is wrong after a run meets a disk that is too small by a random amount, which then is enlarged."""
    size = sum(len(content or b"") for content in whole.values())
    with _disk(disk, 2**28):
        folder = run.prepared(disk / "out")
        before = snapshot(folder)
        used = sum(4096 * -(-len(content or b"") // 4096) for content in before.values())
        _resize(disk, used + round(rng.uniform(0.1, 0.9) * size))
        code, err = ended(started(run.command, folder))
        problems: list[str] = (
            [] if code in (1, 2) or snapshot(folder) == whole else [f"exit code {code} on a full disk"]
        )
        problems += [] if err.count("\n") == bool(code) else [f"not one line on stderr: {err[:300]!r}"]
        problems += _half_written(folder, before, whole)
        _resize(disk, 2**28)
        return [*problems, *_gone_on(run, folder, whole)]


def can_mount(folder: Path) -> bool:
    """Whether this user may make small disks here."""
    try:
        with _disk(folder, 2**20):
            return True
    except subprocess.CalledProcessError:
        return False


def started(command: Sequence[str], folder: Path) -> subprocess.Popen[str]:
    """A command that writes into a folder, as a session of processes of its own."""
    arguments = [sys.executable, "-m", "rsegen", *command, "-o", str(folder)]
    return subprocess.Popen(
        arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Its exit code and what it said on stderr, at its end."""
    _, err = process.communicate(timeout=_LONGEST)
    return process.returncode, err


def kill_after(process: subprocess.Popen[str], seconds: float, rng: random.Random) -> None:
    """Kill a run by a signal that it cannot handle; return when none of its processes is left."""
    with suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
    with suppress(psutil.NoSuchProcess):
        processes = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
        if rng.random() < 0.5:
            processes = [rng.choice(processes)]
        for each in processes:
            with suppress(psutil.NoSuchProcess):
                each.kill()
    ended(process)
    while _session_lives(process.pid):
        time.sleep(0.01)


def _session_lives(session: int) -> bool:
    try:
        os.killpg(session, 0)
    except ProcessLookupError:
        return False
    return True


def _half_written(folder: Path, before: Files, whole: Files) -> Iterator[str]:
    """Every file, but those in hidden folders, is that of before or that of a whole run."""
    for name, content in snapshot(folder).items():
        hidden = name.startswith(".rsegen.") or "/.rsegen." in name
        of_the_run = name.endswith((".rsegen.jsonl", "unfinished.jsonl"))
        if not hidden and not of_the_run and content not in (before.get(name, b""), whole.get(name, b"")):
            yield f"{name} is half written"


def _gone_on(run: Run, folder: Path, whole: Files) -> Iterator[str]:
    code, err = ended(started(run.goes_on, folder))
    if code:
        yield f"cannot be continued: {err.strip()[:300]}"
    after = snapshot(folder)
    for name in sorted(after.keys() | whole.keys()):
        if name not in after or name not in whole:
            yield f"{name} is {'missing' if name in whole else 'left over'}"
        elif after[name] != whole[name]:
            yield f"{name} has other bytes"


@contextmanager
def _disk(folder: Path, size: int) -> Iterator[None]:
    """A disk of a size in a folder, in memory."""
    folder.mkdir(exist_ok=True)
    _run("mount", "-t", "tmpfs", "-o", f"size={size}", "rsegen", folder)
    try:
        yield
    finally:
        _run("umount", folder)


def _resize(folder: Path, size: int) -> None:
    _run("mount", "-o", f"remount,size={size}", folder)


def _run(*command: str | Path) -> None:
    subprocess.run(command, check=True, capture_output=True)
