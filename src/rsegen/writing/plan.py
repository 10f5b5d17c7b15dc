"""A run: what it will make, checked once, then made item by item, each put in its place whole or not at all.

    product: item --> Output, files as bytes --staging, in any process--> staged folder --run_in, this one--> its place

Workers, or a cluster, only write below the hidden folder of the store; the process of the run alone puts things in
place, in the order of the items. A resumed run keeps an item that exists already, to the byte: a map is known by its
recipe.json, which must be the one that would be written, and by its files, which must be as its journal says. Whatever
ends a run, the error says what is complete.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Generic, TypeVar

from rsegen.errors import Incomplete, OutputError, ParameterError, Stopped, Stuck, UserError, WriteError, system_reason
from rsegen.input_files import JOURNAL, Checksum
from rsegen.recipe.codec import map_json
from rsegen.recipe.recipe import Recipe, index_of
from rsegen.writing.execute import Execution, execute
from rsegen.writing.journal import compare, journal_text, read_errors, read_journal, refuse_link, refuse_loss
from rsegen.writing.stop import held
from rsegen.writing.store import NOTES, Store, new_root, open_store, stage_all
from rsegen.writing.swap import sync_trees

if TYPE_CHECKING:
    from rsegen.writing.dry import Notes

Item = TypeVar("Item")
Made = TypeVar("Made")


@dataclass(frozen=True, kw_only=True, slots=True)
class Output(Generic[Made]):
    """The files of one item, and its description.

    folder: the name of the folder that they are in, below that of the run; empty for that one itself
    holds: what the folder is then, as its journal says; `adds`: to a folder that exists, and keeps everything else
    force: of added files those that may be replaced   whole: folders among them that are replaced as one
    """

    made: Made
    files: Mapping[PurePosixPath, Iterable[bytes]] = field(default_factory=dict)
    folder: str = ""
    holds: str = "map"
    adds: bool = False
    force: frozenset[str] = frozenset()
    whole: frozenset[str] = frozenset()


Staged = tuple[Output[Made], Path, Mapping[str, Checksum]]
"""An item without the bytes of its files, the folder in which they are staged, and their checksums."""


def _stage(
    product: Callable[[Item], Output[Made]], folder: Path, items: Sequence[Item], *, sync: bool
) -> tuple[Sequence[Staged[Made]], Exception | None]:
    """Make items and stage their files, in any process that sees the folder.

    Returns those that are complete on the disk, and the error by which the next one failed.
    """
    staged: list[Staged[Made]] = []
    error = None
    for item in items:
        try:
            output, root = product(item), new_root(folder)
            files = stage_all(root, output.files)
            if files and not output.adds:
                stage_all(root, {PurePosixPath(JOURNAL): [journal_text(output.holds, files)]})
            staged.append((replace(output, files={}), root, files))
        except Exception as failure:  # raised by the run, once those before it are in their places
            error = failure
            break
    if sync:
        sync_trees(*(root for _, root, files in staged if files))
    return staged, error


class OnExisting(Enum):
    """The treatment of items that exist in the folder of a run already."""

    REFUSE = "refuse it, and make nothing"
    REPLACE = "replace it"
    KEEP = "keep what is complete, and make the rest"

    @classmethod
    def of(cls, *, force: bool, resume: bool) -> OnExisting:
        """Return what two flags ask for; a ParameterError for both together."""
        if force and resume:
            raise ParameterError("resume", "resume=True and force=True exclude each other")
        return cls.REPLACE if force else cls.KEEP if resume else cls.REFUSE


@dataclass(frozen=True, kw_only=True, slots=True)
class RunPlan(Generic[Item, Made]):
    """A run that was checked: the items to make, how, and those that exist already and stay.

    product: a picklable function that makes an item   seconds: about how long an item takes; decides how the items are
    divided among workers, never the result   to_make: the items, in order   existing: items that exist and are kept
    added_to: the folders of those to which files were added, whose journals are tidied
    replaces: whether folders that exist are replaced, if rsegen wrote them and they are unchanged
    what: the items in messages
    """

    folder: Path
    product: Callable[[Item], Output[Made]]
    seconds: float
    to_make: Sequence[Item]
    existing: Sequence[Item] = ()
    added_to: Sequence[str] = ()
    replaces: bool = False
    execution: Execution = field(default_factory=Execution)
    what: str = "maps"


def run(plan: RunPlan[Item, Made], progress: Callable[[Made], object] | None = None) -> tuple[Made, ...]:
    """Make the items of a plan; `progress` is called with the result of each that is in its place."""
    with open_store(plan.folder, sync=plan.execution.sync) as store:
        return run_in(store, plan, progress)


def run_in(
    store: Store, plan: RunPlan[Item, Made], progress: Callable[[Made], object] | None = None
) -> tuple[Made, ...]:
    """Make the items of a plan in a folder that is open.

    Whatever ends it, what is in its place stays. Raises Stopped for Ctrl-C, and Incomplete for a mistake of the
    user that shows only after something was written.
    """
    if noted := NOTES.get():
        return tuple(_noted(noted, store.folder, plan))
    store.tidy(plan.added_to)
    # Batches come in the order of the items; after each, results are reported, and an error ends the run.
    staging = partial(_stage, plan.product, store.staging.absolute(), sync=plan.execution.sync)
    made: list[Made] = []
    try:
        with closing(execute(staging, plan.to_make, plan.seconds, plan.execution)) as batches:
            for batch, failure in batches:
                for staged in batch:
                    # A signal between the swap and the count would report one item too few.
                    with held():
                        made.append(_put(store, staged, force=plan.replaces))
                store.sync_names()
                if progress:
                    for output, _, _ in batch:
                        progress(output.made)
                if failure:
                    raise failure
    except (KeyboardInterrupt, UserError, OSError) as error:
        raise _ended(error, store, plan, len(made)) from error
    return tuple(made)


def _noted(noted: Notes, folder: Path, plan: RunPlan[Item, Made]) -> Iterator[Made]:
    """Note the files of each item in a dry run, and yield what is known of those that would be made."""
    for item in plan.existing:
        noted.rest(folder / plan.product(item).folder, "keep")
    for item in plan.to_make:
        output = plan.product(item)
        home, names = folder / output.folder, [str(path) for path in output.files]
        if output.adds:
            noted.put(home, names)
            for top in output.whole:
                noted.rest(home / top, "remove")
            noted.rest(home, "keep")
        elif names:
            noted.put_whole(home, names)
        yield output.made


def _ended(error: BaseException, store: Store, plan: RunPlan[Item, Made], made: int) -> BaseException:
    """Return what ended a run as the error that also says what is left: exit code 2 means that nothing was changed."""
    left, stuck = f"nothing was changed in {plan.folder}", store.swaps.words()
    if store.swaps.changed:
        complete, planned = made + len(plan.existing), len(plan.to_make) + len(plan.existing)
        others = "; the others are as they were" if plan.replaces and not stuck else ""
        left = f"{complete} of {planned} {plan.what} are complete in {plan.folder}{others}"
    if isinstance(error, KeyboardInterrupt):
        return Stopped(left, changed=store.swaps.changed)
    # Nothing was changed, so the error alone is the truth; else it gets the exit code of a run that ended half way.
    if not store.swaps.changed:
        return error
    if isinstance(error, OSError):
        kind = Stuck if stuck else WriteError
        return kind(f"{store.folder}: cannot be written: {system_reason(error)}; {left}{stuck}")
    return Incomplete(f"{error}; {left}")


def _put(store: Store, staged: Staged[Made], *, force: bool) -> Made:
    """Put the files of an item in their place, force: of a whole folder; return what is known of it."""
    output, root, files = staged
    if output.adds:
        store.put_staged(root, files, below=output.folder, force=output.force, whole=output.whole, holds=output.holds)
    elif files:
        store.put_folder(root, output.folder, output.holds, force=force)
    return output.made


def existing_maps(recipe: Recipe, folder: Path, is_complete: Callable[[str], bool]) -> list[int]:
    """Return the indices of the maps in `folder` that are kept: complete, by what `is_complete` says of a map's folder.

    OutputError for the first folder that has a map's name and holds something else, or a file that was changed.
    """
    names = os.listdir(folder) if folder.is_dir() else ()
    indices = ((index_of(recipe, name), name) for name in names)
    exact = sorted(index for index, name in indices if index is not None and recipe.map_name(index) == name)
    homes = ((index, folder / recipe.map_name(index)) for index in exact)
    return [index for index, home in homes if is_kept(home, map_json(recipe, index), is_complete)]


def is_kept(home: Path, recipe_file: bytes, is_complete: Callable[[str], bool]) -> bool:
    """Return whether the map of that recipe.json in the folder `home` is kept; if not, the folder may be replaced.

    OutputError if it holds something else than this map, or a file that was changed or would be lost.
    """
    # By its checksum in the journal recipe.json is known to be that of this map, without being read.
    refuse_link(home)
    with read_errors(home):
        journal = read_journal(home)
        if journal is None or Checksum.of(recipe_file) not in journal.files.get("recipe.json", ()):
            raise OutputError(
                f"{home}: exists already and is not this map of rsegen: its journal is missing, or says another seed, "
                "parameter or version; use those of the run that was stopped, or another folder or name"
            )
        comparison = compare(home, journal)
    for name in comparison.changed:
        raise OutputError(
            f"{home / name}: was changed after rsegen wrote it; delete it to have the map made again, or use "
            "another folder"
        )
    if not comparison.missing and is_complete(str(home)):
        return True
    refuse_loss(home, "map")
    return False
