"""What a run makes: the files of each item as bytes, under the name that they will have, and what is known of it then.

A worker stages the files of its items in the hidden folder of the store; the process of the run puts them in place.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Generic, Protocol, TypeVar

from rsegen.io.checksums import Checksum
from rsegen.run.store import new_root, stage_all, stage_journal
from rsegen.run.swap import sync_trees

Item_contra = TypeVar("Item_contra", contravariant=True)
Made = TypeVar("Made")


@dataclass(frozen=True, kw_only=True, slots=True)
class Output(Generic[Made]):
    """The files of one item, and what is known of it.

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


class Product(Protocol[Item_contra, Made]):
    """How each of many items is made: all that a worker needs to know, except which items are its own."""

    @property
    def seconds(self) -> float:
        """About how long one item takes; decides how the items are divided among workers, never the result."""

    def __call__(self, item: Item_contra, /) -> Output[Made]:
        """Return the files of an item."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Staged(Generic[Made]):
    """An item whose files are complete in a folder of the staging: `output` without their bytes."""

    output: Output[Made]
    root: Path | None
    files: Mapping[str, Checksum]


@dataclass(frozen=True, kw_only=True, slots=True)
class Batch(Generic[Made]):
    """The items that a worker has staged, and the error by which the next one failed."""

    staged: Sequence[Staged[Made]]
    error: Exception | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Staging(Generic[Item_contra, Made]):
    """Makes items and stages their files, in any process that sees the folder."""

    product: Product[Item_contra, Made]
    folder: Path
    sync: bool

    def __call__(self, items: Sequence[Item_contra], /) -> Batch[Made]:
        """Return the items that are complete on the disk, up to the first that fails."""
        staged: list[Staged[Made]] = []
        error = None
        for item in items:
            try:
                staged.append(self._staged(self.product(item)))
            except Exception as failure:  # noqa: PERF203  # raised by the run, once those before it are in their places
                error = failure
                break
        if self.sync:
            sync_trees([one.root for one in staged if one.root])
        return Batch(staged=staged, error=error)

    def _staged(self, output: Output[Made]) -> Staged[Made]:
        if not output.files:
            return Staged(output=output, root=None, files={})
        root = new_root(self.folder)
        files = stage_all(root, output.files)
        if output.folder and not output.adds:
            stage_journal(root, files, output.holds)
        return Staged(output=replace(output, files={}), root=root, files=files)
