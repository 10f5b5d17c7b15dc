"""A run: what it will make, checked once, then made item by item, each put in its place whole or not at all.

RunPlan --run--> the result of each item, in order
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Generic, TypeVar

from rsegen.errors import Incomplete, ParameterError, Stopped, UserError, WriteError
from rsegen.run.execute import Execution, execute
from rsegen.run.product import Product, Staged, Staging
from rsegen.run.stop import held
from rsegen.run.store import Store, open_store

Item = TypeVar("Item")
Made = TypeVar("Made")


class OnExisting(Enum):
    """What a run does with what exists in its folder already."""

    REFUSE = "refuse it, and make nothing"
    REPLACE = "replace it"
    KEEP = "keep what is complete, and make the rest"

    @classmethod
    def of(cls, *, force: bool, resume: bool) -> OnExisting:
        """Return what two flags ask for; a ParameterError for both together."""
        if force and resume:
            raise ParameterError("resume", "--resume and --force exclude each other")
        return cls.REPLACE if force else cls.KEEP if resume else cls.REFUSE


@dataclass(frozen=True, kw_only=True, slots=True)
class RunPlan(Generic[Item, Made]):
    """What a run will make, how, and what exists already and stays; nothing prevents it any more.

    product: how an item is made   to_make: the items, in order   existing: items that exist and are kept
    replaces: whether folders that exist are replaced, if rsegen wrote them and they are unchanged
    what: the items in messages
    """

    folder: Path
    product: Product[Item, Made]
    to_make: Sequence[Item]
    existing: Sequence[Item] = ()
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
    staging = Staging(product=plan.product, folder=store.staging.absolute(), sync=plan.execution.sync)
    batches = execute(staging, plan.to_make, plan.product.seconds, plan.execution)
    made: list[Made] = []
    try:
        with closing(batches):
            for batch in batches:
                before = len(made)
                for staged in batch.staged:
                    with held():
                        _put(store, staged, force=plan.replaces)
                        made.append(staged.output.made)
                if batch.staged:
                    store.sync_names()
                for result in made[before:]:
                    if progress:
                        progress(result)
                if batch.error:
                    raise batch.error
    except (KeyboardInterrupt, UserError, OSError) as error:
        raise _ended(error, store, _left(store, plan, len(made))) from error
    return tuple(made)


def _ended(error: BaseException, store: Store, left: str) -> BaseException:
    """Return what ended a run as the error that also says what is left: exit code 2 means that nothing was changed."""
    if isinstance(error, KeyboardInterrupt):
        return Stopped(left, changed=store.changed)
    if not store.changed:
        return error
    if isinstance(error, OSError):
        return WriteError(f"{store.folder}: cannot be written: {error.strerror or error}; {left}")
    return Incomplete(f"{error}; {left}")


def _left(store: Store, plan: RunPlan[Item, Made], made: int) -> str:
    """Return what is in the folder, in words that are true."""
    there, wanted = made + len(plan.existing), len(plan.to_make) + len(plan.existing)
    if not store.changed:
        return f"nothing was changed in {plan.folder}"
    rest = "; the others are as they were" if plan.replaces else ""
    return f"{there} of {wanted} {plan.what} are complete in {plan.folder}{rest}"


def _put(store: Store, staged: Staged[Made], *, force: bool) -> None:
    """Put the files of an item in their place."""
    output = staged.output
    if staged.root is None:
        return
    if not output.adds:
        store.put_folder(staged.root, output.folder, output.holds, force=force)
        return
    store.put_staged(
        staged.root, staged.files, below=output.folder, force=output.force, whole=output.whole, holds=output.holds
    )
