"""Commands in this process, and readers of files that no command calls alone, by names such as @robot."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tests.support.patience import until


def called(argv: tuple[str, ...]) -> object:
    """The exit code of a command, or of a reader."""
    edge: Any = sys.modules["rsegen.cli.edge"]
    try:
        if argv and argv[0] in READERS:
            READERS[argv[0]](*argv[1:])
            return 0
        return edge.main(list(argv))
    except SystemExit as end:
        return end.code
    except Exception as error:  # as the edge of the command line does
        if argv and argv[0] in READERS:
            return edge.failed(error, 2)
        raise


def _read_robot(name: str) -> None:
    from rsegen.robots.files.sdf_file import from_file

    robot = from_file(name)
    robot.model("r", "classic")
    _ = list(robot.notes("sim")), list(robot.spawn_notes("classic")), robot.file("r", "sim")
    robot.command("r", 0.1, 0.2, "classic")


def _read_plan(name: str) -> None:
    from rsegen.experiments.plan import load_plan

    plan = load_plan(name)
    _ = [row.label for row in plan.rows], plan.cells, next(plan.order(), None)


def _read_journal(name: str) -> None:
    from rsegen.experiments.run import read_entries
    from rsegen.writing.journal import read_journal
    from tests.fuzz.seeds import PLAN

    folder = Path(name).parent
    read_entries(read_journal(folder), folder, len(PLAN["rows"]))


def _read_summary(name: str) -> None:
    from rsegen.experiments.run import load_summary

    load_summary(Path(name))


def _read_data_set(name: str) -> None:
    from rsegen import Dataset

    found = Dataset(name)
    _ = repr(found), len(found), found.levels[0], found.levels[[0, -1]], found.metrics, list(found)
    _ = found.recipe_numbers, [found.recipe_of(place) for place in range(min(len(found), 10))]


def _talk(wire: str, name: str) -> None:
    from tests.fuzz import wires

    number = int(Path(name).read_text("ascii"))
    threads, sockets = threading.active_count(), open_sockets()
    (wires.talk_to_classic if wire == "classic" else wires.talk_to_sim)(number)
    until(lambda: threading.active_count() <= threads and open_sockets() <= sockets)


def _talk_to_page(name: str) -> None:
    from tests.fuzz import pages

    pages.talk(int(Path(name).read_text("ascii")))


def _scan_field(name: str) -> None:
    from tests.fuzz import fields

    fields.scan_of(int(Path(name).read_text("ascii")))


def open_sockets() -> int:
    """Number of sockets that this process has."""
    folder = Path("/proc/self/fd")
    return sum(
        os.readlink(folder / name).startswith("socket:") for name in os.listdir(folder) if (folder / name).exists()
    )


READERS: Mapping[str, Callable[[str], None]] = {
    "@robot": _read_robot,
    "@plan": _read_plan,
    "@journal": _read_journal,
    "@summary": _read_summary,
    "@dataset": _read_data_set,
    "@classic": lambda name: _talk("classic", name),
    "@sim": lambda name: _talk("sim", name),
    "@page": _talk_to_page,
    "@field": _scan_field,
}
"""Readers that no command calls alone."""
