"""One trial: a command is disturbed beside foreign things, then continued; what is wrong is a list of lines."""

from __future__ import annotations

import errno
import os
import random
import shutil
import stat
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tests.crash.commands import RUNS, TURNS, Run
from tests.crash.disks import Disk
from tests.crash.foreign import NAMES, add_foreign, put_foreign
from tests.crash.injection import ERRORS, Injection
from tests.crash.judging import (
    End,
    Tree,
    differences,
    is_hidden,
    journals,
    left_hidden,
    neither_old_nor_new,
    tree,
    visible,
    wrong_end,
)
from tests.crash.server import Server

KINDS = {
    "kill": 20,
    "killafter": 14,
    "power": 12,
    "fail": 26,
    "full": 8,
    "short": 5,
    "interrupt": 15,
    "stuck": 18,
    "dead": 6,
}
"""Weights of the draws of what happens at a call."""
SECOND, TAKEN, RESERVED = "second run", "foreign in its place", "foreign hidden name"
RUN_BY_NAME = {run.name: run for run in RUNS}
_OTHERS = {SECOND: 12, TAKEN: 6, RESERVED: 3}
_HIDDEN = (".rsegen", ".rsegen.jsonl")


@dataclass(frozen=True, kw_only=True, slots=True)
class Undisturbed:
    """A run that nobody disturbs: what exists before and after it, and how many of its calls are counted."""

    folder: Path
    before: Tree
    whole: Tree
    calls: int


@dataclass(frozen=True, kw_only=True, slots=True)
class Trial:
    """The command of a trial, what happens to it, what its disk lacks, and the generator that draws the rest.

    lacks: what is taken from the disk   exchanges: whether two names can then be exchanged at once
    """

    run: Run
    kind: str
    shared: bool
    lacks: Mapping[str, Any]
    exchanges: bool
    rng: random.Random

    @classmethod
    def drawn(cls, seed: int, number: int, *, exchanges: bool = True, disk: Disk | None = None) -> Trial:
        """Trial `number` of a seed; exchanges: on a disk that exchanges two names at once, unless it is another one."""
        rng = random.Random(f"{seed} {number}")  # noqa: S311  # moments, not secrets
        run = TURNS[number % len(TURNS)]
        kinds = {**KINDS, **_OTHERS}
        if not run.syncs:
            del kinds["power"]
        if "--force" not in run.command:
            del kinds[TAKEN]
        kind = rng.choices(list(kinds), list(kinds.values()))[0]
        shared, no_locks = run.shares and rng.random() < 0.7, rng.random() < 0.07
        unable = rng.choice((errno.EINVAL, errno.ENOSYS))
        lacks = ({"no_locks": True} if no_locks else {}) | ({} if exchanges or disk else {"no_exchange": unable})
        able = disk.exchanges if disk else exchanges
        return cls(run=run, kind=kind, shared=shared, lacks=lacks, exchanges=able, rng=rng)


def undisturbed(run: Run, server: Server, folder: Path, *, shared: bool) -> Undisturbed:
    """Run the command alone; `folder` keeps what exists before it."""
    _empty(server.trial)
    server.root.mkdir(parents=True)
    for command in run.first:
        _succeeded(server.run(command), run)
    if run.damage:
        run.damage(server.root)
    add_foreign(server.trial, shared=shared)
    _copied(server.trial, folder)
    before = tree(server.trial)
    end = _succeeded(server.run(run.command), run)
    return Undisturbed(folder=folder, before=before, whole=tree(server.trial), calls=end.calls)


def problems(trial: Trial, alone: Undisturbed, server: Server) -> tuple[str, list[str]]:
    """Description of a trial, and problems after it."""
    _empty(server.trial)
    _copied(alone.folder, server.trial)
    if trial.kind == SECOND:
        return _second_run(trial, alone, server)
    if trial.kind == TAKEN:
        return _taken(trial, alone, server)
    if trial.kind == RESERVED:
        return _reserved(trial, alone, server)
    return _disturbed(trial, alone, server)


def _disturbed(trial: Trial, alone: Undisturbed, server: Server) -> tuple[str, list[str]]:
    """A call of the run fails, or kills it; in some trials the run that continues it is killed too."""
    injection = _injection(trial.kind, trial.rng, alone.calls)
    command, done = list(trial.run.command), list[str]()
    wrong, gaps, named = list[str](), False, ""
    for again in range(1 + (trial.rng.random() < 0.25)):
        if again:  # a run that goes on is killed too
            command = _continued(trial.run, alone, server)
            injection = _injection("kill", trial.rng, alone.calls)
        before = tree(server.trial)
        end = server.run(command, injection)
        if injection.power:
            cut_power(server.root, end)
        done.append(f"{replace(injection, **trial.lacks)}: {end.call or 'never reached'}")
        gaps |= bool(not trial.exchanges and end.signal)
        named += end.err.partition("could not be put back")[2]
        now, interrupted = tree(server.trial), injection.mode == "interrupt" and bool(end.call)
        wrong += _judged(trial.run, alone, now, before, gaps=gaps, named=named)
        wrong += wrong_end(end, before, now, alone.whole, interrupted=interrupted)
    wrong += _gone_on(trial.run, alone, server)
    if not wrong and trial.rng.random() < 0.2:
        wrong += _replaced_again(trial.run, alone, server)
    return "; then ".join(done), wrong


def _judged(
    run: Run, alone: Undisturbed, now: Tree, before: Tree, *, gaps: bool = False, named: str = ""
) -> Iterator[str]:
    """Problems with what is on disk after a run that was disturbed."""
    old, whole, found = (_of_root(files) for files in (alone.before, alone.whole, now))
    yield from neither_old_nor_new(found, old, whole, run.depth, gaps=gaps, named=named)
    yield from (f"outside: {line}" for line in differences(_outside(now), _outside(before)))


def _gone_on(run: Run, alone: Undisturbed, server: Server) -> Iterator[str]:
    """Continue the run to its end; what is wrong with that, and after it."""
    end = server.run(_continued(run, alone, server))
    if end.code or end.signal:
        yield f"cannot be continued: exit code {end.code}: {end.err.strip()[:300]}"
    now = tree(server.trial)
    wrong = differences(visible(now), visible(alone.whole)) or differences(journals(now), journals(alone.whole))
    if wrong:
        yield f"after the run that continues it, {', '.join(wrong)}"
    if left := left_hidden(now):
        yield f"after the run that continues it, {', '.join(left[:5])} is left"


def _replaced_again(run: Run, alone: Undisturbed, server: Server) -> Iterator[str]:
    """Replace what was made by itself: its journal knows all of it."""
    end = server.run(run.forced())
    if end.code or end.signal:
        yield f"what was made cannot be replaced: exit code {end.code}: {end.err.strip()[:300]}"
    elif wrong := differences(visible(tree(server.trial)), visible(alone.whole)):
        yield f"after it was replaced by itself, {', '.join(wrong)}"


def _second_run(trial: Trial, alone: Undisturbed, server: Server) -> tuple[str, list[str]]:
    """A run is stopped, and the same command is run; then the first goes on."""
    k = trial.rng.randint(1, alone.calls)
    first = server.run(trial.run.command, Injection(mode="stop", k=k))
    done = f"a second run while the first is stopped at call {k} of {alone.calls}: {first.call}, {dict(trial.lacks)}"
    if not first.stopped:
        return done, [*wrong_end(first, alone.before, tree(server.trial), alone.whole, interrupted=False)]
    before = tree(server.trial)
    resumes = trial.run.goes_on == "resume" and trial.rng.random() < 0.5
    second = server.second(_continued(trial.run, alone, server) if resumes else trial.run.command)
    wrong = [*_wrong_second(second, before, tree(server.trial), early_or_late=not 0.25 < k / alone.calls < 0.75)]
    end = server.go_on()
    now = tree(server.trial)
    if end.code not in ((0, 2) if second.code == 0 else (0,)) or end.signal:
        wrong.append(f"the first run ends with exit code {end.code}: {end.err.strip()[:200]}")
    if different := differences(visible(now), visible(alone.whole)):
        wrong.append(f"after both runs, {', '.join(different)}")
    if left := left_hidden(now):
        wrong.append(f"after both runs, {', '.join(left[:5])} is left")
    return done, wrong


def _wrong_second(second: End, before: Tree, now: Tree, *, early_or_late: bool) -> Iterator[str]:
    """Problems with a second run; before the first holds the folder, and once it is done, it may succeed."""
    if second.signal < 0:
        yield "the second run does not end"
    elif second.code == 0:
        if not early_or_late:
            yield "the second run was not refused"
    elif second.code != 2 or second.err.count("\n") != 1:
        yield f"the second run ends with exit code {second.code}: {second.err[-300:]!r}"
    else:
        if wrong := differences(now, before):
            yield f"the second run was refused, but {', '.join(wrong)}: {second.err.strip()[:200]}"
        if "out" not in second.err and "another run" not in second.err:
            yield f"the second run names neither the folder nor the other run: {second.err.strip()[:200]}"


def _taken(trial: Trial, alone: Undisturbed, server: Server) -> tuple[str, list[str]]:
    """Something foreign is where the run would replace what rsegen wrote: it is refused."""
    replaced = _replaced(alone, 1 + max(1, trial.run.depth))
    name = trial.rng.choice(replaced)
    path = server.root / name
    what = trial.rng.choice(
        ["a link", "a folder"] if path.is_file() else ["a link", "a folder", "a change", "a file more"]
    )
    put_foreign(path, what, trial.rng)
    before = tree(server.trial)
    end = server.run(trial.run.command)
    now = tree(server.trial)
    wrong = [*wrong_end(end, before, now, alone.whole, interrupted=False)]
    if end.code != 2:
        wrong = [f"was not refused: exit code {end.code}", *differences(now, before)]
    return f"{what} at {name}", wrong


def _reserved(trial: Trial, alone: Undisturbed, server: Server) -> tuple[str, list[str]]:
    """Something foreign has the name of a hidden folder or journal of rsegen: it stays, refused or not."""
    name, what = trial.rng.choice(_HIDDEN), trial.rng.choice(("a link", "a folder", "a file"))
    path = server.root / "out" / name
    path.parent.mkdir(exist_ok=True)
    if os.path.lexists(path):  # of a run before it
        return "nothing", []
    if what == "a file":
        path.write_text("mine\n", "utf-8")
    else:
        put_foreign(path, what, trial.rng)
    before = tree(server.trial)
    end = server.run(trial.run.command)
    now = tree(server.trial)
    wrong = [*wrong_end(end, before, now, alone.whole, interrupted=False)]
    ours = f"root/out/{name}"
    mine = {
        place: file
        for place, file in before.items()
        if place == ours or place.startswith(f"{ours}/") or not place.startswith("root/out")
    }
    wrong += differences({place: file for place, file in now.items() if place in mine}, mine)
    return f"{what} named out/{name}", wrong


def _replaced(alone: Undisturbed, depth: int) -> list[str]:
    """The units in the output folder that a run replaces, by so many of their names."""
    old, new = (_of_root(visible(files)) for files in (alone.before, alone.whole))
    changed = {path for path in old.keys() & new.keys() if old[path] != new[path]}
    found = sorted({"/".join(path.split("/")[:depth]) for path in changed})
    same = (path for path in new if path.startswith("out/") and old.get(path, ("",))[0] == "file")
    return found or sorted(path for path in same if path.split("/")[1] not in NAMES)


def _injection(kind: str, rng: random.Random, calls: int) -> Injection:
    return Injection(
        mode="kill" if kind == "power" else kind,
        k=rng.randint(1, max(1, calls)),
        error=rng.choice(ERRORS) if kind in ("fail", "stuck", "dead") else errno.ENOSPC if kind == "short" else 0,
        every=rng.choice((1, 1, 2, 3)) if kind == "stuck" else 1,
        alone=kind in ("kill", "killafter") and rng.random() < 0.5,
        power=kind == "power",
    )


def _continued(run: Run, alone: Undisturbed, server: Server) -> list[str]:
    made = visible(alone.whole).keys() - visible(alone.before).keys()
    return run.continued(exists=any(os.path.lexists(server.trial / path) for path in made if path != "root/out"))


def cut_power(root: Path, end: End) -> None:
    """Take from files what the disk was not yet sure to have."""
    sizes = dict(end.unsynced)
    for folder, _, names in os.walk(root):
        for path in (os.path.join(folder, name) for name in names):
            now = os.lstat(path)
            if stat.S_ISREG(now.st_mode) and now.st_ino in sizes:
                os.truncate(path, min(now.st_size, sizes[now.st_ino]))


def _of_root(files: Tree) -> Tree:
    return {path.removeprefix("root/"): file for path, file in files.items() if path.startswith("root/")}


def _outside(files: Tree) -> Tree:
    return {path: file for path, file in files.items() if path.startswith("outside") and not is_hidden(path)}


def _copied(folder: Path, place: Path) -> None:
    """Copy a folder with its links; not the times of links, as shutil does, which SFTP cannot set."""
    subprocess.run(["cp", "-R", "-P", "--preserve=mode", str(folder), str(place)], check=True)


def _empty(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)


def _succeeded(end: End, run: Run) -> End:
    if end.code or end.signal:
        raise AssertionError(f"{run.name}, undisturbed: exit code {end.code}: {end.err}")
    return end
