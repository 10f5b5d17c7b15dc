"""The runs that are killed: what they need first, their command, and the one that goes on after a kill."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.support.complaints import snapshot

_RECIPE = ["--obstacle", "random levels=5", "--obstacle", "peak levels=4", "--seed", "7"]
_OTHER = ["--obstacle", "random levels=5", "--obstacle", "peak levels=4", "--seed", "8"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Run:
    """A command that writes into a folder; `first` are commands that have filled it before; `goes_on` ends it again."""

    name: str
    command: Sequence[str]
    goes_on: Sequence[str]
    first: Sequence[Sequence[str]] = ()

    def prepared(self, folder: Path) -> Path:
        """The folder, filled with what exists before the run."""
        shutil.rmtree(folder, ignore_errors=True)
        for command in self.first:
            finished([*command, "-o", str(folder)])
        return folder

    def whole(self, folder: Path) -> Mapping[str, bytes | None]:
        """What lies in the folder after a run that nobody disturbs."""
        finished([*self.command, "-o", str(self.prepared(folder))])
        return snapshot(folder)


def finished(arguments: Sequence[str]) -> None:
    """Run a command to its end; it has to succeed."""
    subprocess.run([sys.executable, "-m", "rsegen", *arguments], check=True, capture_output=True)


def _resumed(name: str, *arguments: str, first: Sequence[Sequence[str]] = ()) -> Run:
    return Run(name=name, command=arguments, goes_on=[*arguments, "--resume"], first=first)


def _forced(name: str, *arguments: str, first: Sequence[Sequence[str]]) -> Run:
    return Run(name=name, command=[*arguments, "--force"], goes_on=[*arguments, "--force"], first=first)


_MAPS = ["--maps", "80", "--workers", "2"]
_FORMATS = ["--to", "stl,heightmap", "--workers", "2"]

RUNS = (
    _resumed("generate", "generate", *_RECIPE, *_MAPS),
    _resumed("generate, one process", "generate", *_RECIPE, "--maps", "30", "--workers", "1"),
    _resumed("generate --no-sync", "generate", *_RECIPE, *_MAPS, "--no-sync"),
    _forced("generate --force", "generate", *_RECIPE, *_MAPS, first=[["generate", *_OTHER, *_MAPS]]),
    _resumed("series", "series", *_RECIPE, "--maps", "16", "--workers", "2"),
    _resumed("export", "export", *_RECIPE, "--maps", "50", *_FORMATS),
    _resumed("export to worlds", "export", *_RECIPE, "--maps", "30", *_FORMATS, first=[["generate", *_RECIPE, *_MAPS]]),
    _forced(
        "export --force",
        *["export", *_RECIPE, "--maps", "30", "--to", "heightmap pixels=2", "--workers", "2"],
        first=[["export", *_RECIPE, "--maps", "30", *_FORMATS]],
    ),
    _resumed("dataset", "dataset", *_RECIPE, "--maps", "4000", "--shard-maps", "100", "--workers", "2"),
    _forced(
        "dataset --force",
        *["dataset", *_RECIPE, "--maps", "4000", "--shard-maps", "100", "--workers", "2"],
        first=[["dataset", *_OTHER, "--maps", "1000", "--shard-maps", "50"]],
    ),
)
"""What `make crash` kills, and runs on disks that are too small."""
