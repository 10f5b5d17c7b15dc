"""Commands that pages run: the command of a form on a document, as a job."""

from __future__ import annotations

import os
import re
import shlex
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rsegen.errors import ParameterError, UserError
from rsegen.page.calls import Question, call_of_host
from rsegen.page.forms import CommandForm, command_form
from rsegen.page.host import Host
from rsegen.page.jobs import Job, Jobs, Run
from rsegen.page.places import Places
from rsegen.run.journal import read_journal, refuse_loss, refuse_loss_below
from rsegen.run.store import refuse_taken_file

_REFUSED_WITHIN = 10.0
"""Seconds in which a command refuses what exists already; on a busy machine Python alone takes some of them."""

_EXISTS = re.compile(r"rsegen: (.+): exists already; give --force to replace it")


@call_of_host
def run(
    host: Host, *, doc: str, command: str, values: dict[str, Any], output: str = "", replace: bool = False
) -> dict[str, Any]:
    """Run a command on the recipe of a document; a Question if it would replace what it may replace."""
    form, document = command_form(command), host.opened(doc).document
    if form.takes_recipe and (problem := document.session.problem):
        raise ParameterError(problem.where, problem.problem)
    flags, others = form.arguments(values, host.places)
    place = _output(form, output, host.folder)
    flags += [f"--output={place}"] if place else []
    flags += ["--force"] if replace and form.can_replace else []
    recipe = document.session.recipe if form.takes_recipe else None
    file = str(host.places.seen(document.path)) if document.path else ""
    if document.session.unsaved or not file:  # a name for it, as the file, if there is one, is not up to date
        file = f"{document.session.recipe.name}.yaml"
    words = [*others, file] if recipe else others
    # None of the words is taken for another flag.
    after = ["--"] if any(word.startswith("-") for word in words) else []
    job = Job(
        id=host.jobs.new_id(),
        doc=doc,
        command=command,
        line=shlex.join(["rsegen", command, *flags, *after, *words]),
    )
    # A command without arguments takes no -- before them either.
    arguments = (command, *flags, "--json", "--progress=json", *(["--", *others] if others or recipe else []))
    made = Run(job=job, arguments=arguments, recipe=recipe, folder=host.folder.resolve(), output=place)
    # If its output exists, it may refuse to replace it, and then nothing has happened but a question.
    made.is_told = not (place and os.path.lexists(made.folder / place) and form.can_replace and not replace)
    host.jobs.start(made)
    if not made.is_told:
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
            raise ParameterError("output", "is missing; give a name below the folder of this page")
        return None
    places = Places(folder)
    place = places.seen(places.inside(output))
    if place == Path():
        raise ParameterError("output", "is the folder of this page; give a name below it")
    return place


def _refuse_if_taken(jobs: Jobs, made: Run) -> None:
    """Wait for a moment whether a command refuses what exists; then the Question whether to replace it, if it may."""
    until = time.monotonic() + _REFUSED_WITHIN
    while not made.ended.wait(0.05) and time.monotonic() < until and not made.job.done:
        pass
    refused = _EXISTS.match(made.said[-1]) if made.job.state == "failed" and made.said else None
    if refused and _may_be_replaced(made.folder / refused[1], _HOLDS.get(made.job.command, "map")):
        jobs.forget(made.job.id)
        raise Question(f"{refused[1]}: exists already", "exists")
    made.is_told = True
    jobs.tell(made)


_HOLDS = {"drive": "drive", "dataset": "data set"}
"""What a folder holds that a command writes, if that is no map."""


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
def cancel(host: Host, *, job: int) -> dict[str, Any]:
    """Ask a job to stop."""
    return host.jobs.cancel(job)


@call_of_host
def jobs(host: Host) -> list[dict[str, Any]]:
    """Return all jobs."""
    return host.jobs.listed()
