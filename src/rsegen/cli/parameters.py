"""Parameters that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from rsegen.params.command import Shell
from rsegen.params.sorts import FilePath, Flag, Integer, Reference

Force = Annotated[bool, Flag(help="overwrite the file, or a folder that rsegen wrote and nobody has changed")]

Resume = Annotated[
    bool,
    Flag(help="continue a stopped run: keep what is complete, make the rest; needs the same recipe, seed and options"),
]

Workers = Annotated[
    int,
    Integer(1, help="number of processes that run in parallel"),
    Shell(metavar="N", default="the number of cores"),
]

Scheduler = Annotated[
    str | None,
    Reference(
        "tcp://HOST:PORT, or local",
        help="run on a Dask cluster, whose workers must share this folder: tcp://HOST:PORT, or local for --workers "
        "processes here; needs rsegen[cluster]",
    ),
    Shell(metavar="ADDRESS"),
]

Sync = Annotated[
    bool,
    Flag(help="wait until files are on disk"),
    Shell(
        help="do not wait until files are on disk: a little faster for many small maps; after a power failure some may "
        "be empty, and --resume makes them again"
    ),
]

OutputFolder = Annotated[
    str | Path, FilePath(help="folder to write into"), Shell(("-o", "--output"), "DIR", required=True)
]

MapReference = Annotated[
    int | str | None,
    Reference("an index or a name", help="index or name of the map", types=(str, int)),
    Shell(metavar="INDEX", default="the first"),
]
