"""rsegen info: how large a map is, what stands in it, what it costs."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator

from rsegen.cli.flags import Subparsers, add_target_recipe_flags
from rsegen.cli.targets import add_target_flags, is_of_flags, scene_of
from rsegen.errors import ParameterError
from rsegen.exporters.map_summary import MapSummary, map_summary
from rsegen.exporters.numbers import lengths_in
from rsegen.run.journal import verify


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "info",
        description="Print the size of a map, its number of blocks of each level, and its cost in faces and bytes.",
    )
    add_target_flags(command)
    group = command.add_argument_group("output")
    group.add_argument("--json", action="store_true", help="print it as JSON")
    group.add_argument(
        "--verify",
        action="store_true",
        help="compare every file in DIR, and in the maps in it, with the sizes and checksums that rsegen recorded",
    )
    add_target_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print it."""
    if arguments.verify:
        _verify(arguments)
        return
    found = map_summary(scene_of(arguments))
    print(json.dumps(_summary(found), indent=2) if arguments.json else "\n".join(_report(found)))


def _verify(arguments: argparse.Namespace) -> None:
    """Compare a folder with its records, and say what was compared."""
    if arguments.target is None or arguments.map is not None or is_of_flags(arguments):
        raise ParameterError("--verify", "needs a folder that rsegen wrote, and no recipe")
    found = verify(arguments.target)
    unlisted = [str(path) for path in found.unlisted]
    if arguments.json:
        print(json.dumps({"folders": found.folders, "files": found.files, "unlisted": unlisted}, indent=2))
        return
    print(f"{_many(found.files, 'file')} in {_many(found.folders, 'folder')} as rsegen wrote them")
    for path in unlisted:
        print(f"not written by rsegen: {path}")


def _summary(found: MapSummary) -> dict[str, object]:
    return {
        "name": found.name,
        "seed": found.seed,
        "size": list(found.cells),
        "size_m": list(found.extent),
        "unit_cm": found.unit_cm,
        "levels": list(found.level_counts),
        "level_counts": found.level_counts,
        "fingerprint": found.fingerprint,
        "mesh_type": found.mesh_type,
        "models": found.models,
        "collisions": found.collisions,
        "faces": found.faces,
        "bytes": found.bytes,
        "warnings": list(found.warnings),
    } | ({"plugins": found.plugins} if found.plugins else {})


def _report(found: MapSummary) -> Iterator[str]:
    (n_x, n_y), (along_x, along_y) = found.cells, found.extent
    blocks = sum(found.level_counts.values())
    yield f"{found.name}, seed {found.seed}"
    yield f"size     {n_x} x {n_y} cells with frames, {along_x:g} x {along_y:g} m"
    written = lengths_in(found.units)
    in_levels = f"in levels of {written.level(1, found.unit_cm)} {written.unit}"
    yield f"blocks   {blocks:,} {in_levels}, fingerprint {found.fingerprint}"
    for level, count in found.level_counts.items():
        high = written.level(level, found.unit_cm)
        yield f"  level {level:>3}  {high:>7} {written.unit}  {count:>9,}  {count / blocks:6.1%}"
    costs = (_many(found.models, "model"), _many(found.collisions, "collision"), _many(found.faces, "face"))
    cost = f"{', '.join(costs)}, {found.bytes:,} bytes"
    yield f"costs    mesh type {found.mesh_type}: {cost}"
    for kind, source in found.plugins.items():
        yield f"plug-in  {kind} of {source}"
    for text in found.warnings:
        yield f"warning: {text}"


def _many(count: int, what: str) -> str:
    return f"{count:,} {what}{'' if count == 1 else 's'}"
