"""Runs of a page: commands with their forms' values, on a document or on a map that is written already; their lines.

    document or map, values, output --run--> Job, which is `rsegen COMMAND` in its own process (`jobs.py`)

The shell line does the same in the folder of the page. For a recipe that was never saved it has the recipe's flags, or,
if the command lacks some of them, it writes the maps first.
The folder with what a run wrote is shown in the file manager of the machine where the server runs.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from shutil import which
from typing import NamedTuple, TypedDict

from rsegen.errors import ParameterError, UserError
from rsegen.page.calls import Question, call_of_host
from rsegen.page.command_forms import CommandForm, command_form
from rsegen.page.host import Host
from rsegen.page.jobs import Job, JobRun, Jobs, JobValues
from rsegen.page.model.document import Document
from rsegen.page.model.texts import command_line, recipe_flags, stated_names
from rsegen.page.places import Places
from rsegen.params.sorts import Json
from rsegen.writing.journal import read_journal, refuse_loss, refuse_loss_below
from rsegen.writing.programs import has_screen
from rsegen.writing.store import refuse_taken_file


class ShellLine(TypedDict):
    """The line that does in a shell what a form says."""

    text: str  # empty while a value is wrong or missing
    why: str  # there is none


class _Target(NamedTuple):
    """The arguments for a document in the line of a command, as words; flags come before other words.

    before: a command that comes first, with its &&: the maps of a recipe that has no file, and no flags for all
    """

    before: str = ""
    flags: Sequence[str] = ()
    words: Sequence[str] = ()


def _target_of(form: CommandForm, document: Document, places: Places, map_name: str) -> _Target:
    """Return what stands for a document: its file if it is up to date, else its flags, or a map of it that is made."""
    recipe = document.session.recipe
    if document.path and not document.session.unsaved:
        return _Target(words=[str(places.relative(document.path))])
    if stated_names(recipe) <= form.recipe_flags:
        return _Target(flags=recipe_flags(recipe))
    folder = map_name or recipe.map_name(recipe.first_map)
    return _Target(before=f"{command_line(recipe, recipe.name)} && ", words=[f"{recipe.name}/{folder}"])


class _Arguments(NamedTuple):
    """The arguments of a command as a form gives them; place: where it writes, as one of the flags says too.

    others: inputs that are no flags, such as the files of clouds; made_maps: a map in the folder of the page
    """

    flags: list[str]
    others: list[str]
    made_maps: list[str]
    place: Path | None

    def line(self, command: str, target: _Target) -> str:
        """Return the line of a shell; target: what stands there for a document."""
        words = [*self.others, *self.made_maps, *target.words]
        # None of the words is taken for another flag.
        after = ["--"] if any(word.startswith("-") for word in words) else []
        return target.before + shlex.join(["rsegen", command, *target.flags, *self.flags, *after, *words])


def _arguments(host: Host, form: CommandForm, values: Mapping[str, Json], output: str, target: str) -> _Arguments:
    """Return the arguments of a command; a ParameterError if one of them is wrong."""
    flags, others = form.arguments(values, host.places)
    place = _output(form, output, host.folder)
    flags += [f"--output={place}"] if place else []
    made_maps = [str(host.places.relative(host.places.inside(target)))] if target else []
    return _Arguments(flags, others, made_maps, place)


@call_of_host
def shell_line(
    host: Host, *, doc: str, command: str, values: dict[str, Json], output: str = "", target: str = ""
) -> ShellLine:
    """Return the shell line that does what `run` does with these arguments, or why it cannot be given."""
    form, document = command_form(command), host.opened(doc).document
    try:
        words = _arguments(host, form, values, output, target)
    except UserError as error:
        return {"text": "", "why": error.problem if isinstance(error, ParameterError) else str(error)}
    return {"text": _line(words, form, document, host.places, values), "why": ""}


def _line(given: _Arguments, form: CommandForm, document: Document, places: Places, values: Mapping[str, Json]) -> str:
    takes_document = form.takes_recipe and not given.made_maps
    target = _target_of(form, document, places, str(values.get("map") or "")) if takes_document else _Target()
    return given.line(form.name, target)


_REFUSED_WITHIN = 10.0
"""Seconds in which a command refuses what exists already; on a busy machine Python alone takes some of them."""

_EXISTS = re.compile(r"rsegen: (.+): exists already; use --force to replace it")


@call_of_host
def run(  # noqa: PLR0913  # a page gives each
    host: Host,
    *,
    doc: str,
    command: str,
    values: dict[str, Json],
    output: str = "",
    target: str = "",
    replace: bool = False,
) -> JobValues:
    """Run a command on the recipe of a document; a Question if it would replace what it may replace.

    target: a map in the folder of the page, which then stands for the document
    """
    form, document = command_form(command), host.opened(doc).document
    takes_document = form.takes_recipe and not target
    if takes_document and (problem := document.session.problem):
        raise ParameterError(problem.where, problem.problem)
    words = _arguments(host, form, values, output, target)
    place = words.place
    words.flags.extend(["--force"] if replace and form.can_replace else [])
    recipe = document.session.recipe if takes_document else None
    job = Job(
        id=host.jobs.new_id(),
        doc=doc,
        command=command,
        line=_line(words, form, document, host.places, values),
        output=str(place or ""),
    )
    # A command without arguments takes no -- before them either.
    arguments = [command, *words.flags, "--json", "--progress=json"]
    if words.others or words.made_maps or recipe:
        arguments += ["--", *words.others, *words.made_maps]
    made = JobRun(job=job, arguments=arguments, recipe=recipe, folder=host.folder.resolve(), output=place)
    # If its output exists, it may refuse to replace it, and then nothing has happened but a question.
    made.is_shown = not (place and os.path.lexists(made.folder / place) and form.can_replace and not replace)
    host.jobs.start(made)
    if not made.is_shown:
        _refuse_if_taken(host.jobs, made)
    return asdict(job)


def _output(form: CommandForm, output: str, folder: Path) -> Path | None:
    """Return where a command writes, seen from the folder of pages; a UserError if that is outside, or missing."""
    if form.output is None:
        if output:
            raise ParameterError("output", f"{form.name} writes nothing")
        return None
    if not output:
        if form.needs_output:
            raise ParameterError("output", "Enter a name for the output, which is written in the folder of this page.")
        return None
    places = Places(folder)
    place = places.relative(places.inside(output))
    if place == Path():
        raise ParameterError("output", "This is the folder of this page itself. Enter a name inside it.")
    return place


def _refuse_if_taken(jobs: Jobs, made: JobRun) -> None:
    """Wait for a moment whether a command refuses what exists; then the Question whether to replace it, if it may."""
    until = time.monotonic() + _REFUSED_WITHIN
    while not made.ended.wait(0.05) and time.monotonic() < until and not made.job.done:
        pass
    refused = _EXISTS.match(made.stderr_lines[-1]) if made.job.state == "failed" and made.stderr_lines else None
    if refused and _may_be_replaced(made.folder / refused[1], _HOLDS.get(made.job.command, "map")):
        jobs.forget(made.job.id)
        raise Question(f"{refused[1]}: exists already", "exists")
    made.is_shown = True
    jobs.notify(made)


_HOLDS = {"drive": "drive", "dataset": "data set"}
"""Contents of the folders that commands write, if these are no maps, by command."""


def _may_be_replaced(path: Path, holds: str) -> bool:
    """Return whether --force replaces a file or folder: rsegen wrote it, and it is unchanged."""
    try:
        if path.is_file():
            refuse_taken_file(path, force=True)
        elif (within := read_journal(path.parent)) and read_journal(path) is None:
            refuse_loss_below(path.parent, path.name, within)  # a format in the folder of a map
        else:
            refuse_loss(path, holds)
    except UserError:
        return False
    return True


@call_of_host
def cancel(host: Host, *, job: int) -> JobValues:
    """Ask a job to stop."""
    return host.jobs.cancel(job)


@call_of_host
def jobs(host: Host) -> list[JobValues]:
    """Return all jobs."""
    return host.jobs.listed()


_OPENERS = {"darwin": "open", "win32": "explorer"}
"""Programs that open a folder, by platform; elsewhere it is that of freedesktop.org."""


class ShownFolder(TypedDict):
    """A folder, as a path to copy, and whether a file manager was opened on it."""

    path: str
    is_open: bool


@call_of_host
def show_folder(host: Host, *, path: str) -> ShownFolder:
    """Open the file manager on a folder, or on the folder of a file; only a person at this machine sees it."""
    place = host.places.inside(path)
    folder = place if place.is_dir() else place.parent
    opener = which(_OPENERS.get(sys.platform, "xdg-open"))
    is_open = False
    if opener and has_screen() and not os.environ.get("SSH_CONNECTION"):
        with suppress(OSError):
            quiet = subprocess.DEVNULL
            subprocess.Popen(  # noqa: S603  # no shell, and the folder is one of ours
                [opener, str(folder)], stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True
            )
            is_open = True
    return {"path": str(folder), "is_open": is_open}
