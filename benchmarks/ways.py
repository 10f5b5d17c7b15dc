"""The works that are measured: grids to files, whole commands. Names only; nothing heavy is imported here."""

from __future__ import annotations

import sys
from dataclasses import dataclass

SIZES = (10, 80, 320, 1000)
LARGEST = 4000


@dataclass(frozen=True, kw_only=True, slots=True)
class Way:
    """One way from a grid to a file: `function` of the file `writers/module.py`, and where it ends being bearable."""

    name: str
    title: str
    module: str
    function: str
    faces: str = "rectangles"
    ending: str = "obj"
    largest: int = 1000
    largest_full: int = 1000


@dataclass(frozen=True, kw_only=True, slots=True)
class Command:
    """One whole program, of maps of `size` blocks a side; FOLDER among the arguments is an empty folder."""

    name: str
    title: str
    arguments: tuple[str, ...]
    size: int = 0
    count: int = 1


FOLDER = "FOLDER"

_BOX_A_BLOCK = "trimesh, one creation.box per block, OBJ"

WAYS = (
    Way(
        name="loop",
        title="pure-Python loop, 8 vertices and 6 faces per block, OBJ",
        module="loop",
        function="boxes_obj",
    ),
    Way(
        name="merged",
        title="**rsegen, merged surface, OBJ**",
        module="ours",
        function="merged_obj",
        largest_full=LARGEST,
    ),
    Way(
        name="watertight",
        title="rsegen, watertight, OBJ",
        module="ours",
        function="watertight_obj",
        faces="triangles",
        largest=320,
        largest_full=320,
    ),
    Way(name="blocks", title="rsegen, 8 vertices and 6 faces per block, OBJ", module="ours", function="blocks_obj"),
    Way(
        name="multi",
        title="rsegen `multi`, a box model per block, SDF",
        module="ours",
        function="multi_world",
        ending="world",
        largest=320,
        largest_full=320,
    ),
    Way(
        name="box",
        title=_BOX_A_BLOCK,
        module="boxes",
        function="one_by_one",
        faces="triangles",
        largest=80,
        largest_full=320,
    ),
    Way(
        name="numpy-obj",
        title="vectorised numpy boxes, trimesh OBJ",
        module="boxes",
        function="at_once",
        faces="triangles",
        largest=320,
    ),
    Way(
        name="numpy-stl",
        title="vectorised numpy boxes, trimesh STL",
        module="boxes",
        function="at_once",
        faces="triangles",
        ending="stl",
    ),
    Way(
        name="isaaclab",
        title="IsaacLab random_grid_terrain, trimesh OBJ",
        module="isaaclab",
        function="random_grid",
        faces="triangles",
        largest=320,
    ),
)

MATRICES = Command(
    name="matrices",
    title="`rsegen.build`, matrices in memory",
    arguments=(sys.executable, "-m", "benchmarks.matrices"),
    size=10,
    count=5000,
)


def commands(maps: int) -> tuple[Command, ...]:
    """Every whole program, one of which makes that many maps."""
    return (
        _python("python", "python -c pass", "pass"),
        _python("numpy", 'python -c "import numpy"', "import numpy"),
        _python("import", 'python -c "import rsegen"', "import rsegen"),
        Command(name="help", title="`rsegen --help`", arguments=(sys.executable, "-m", "rsegen", "--help")),
        worlds("single", 10),
        worlds("single", 80),
        worlds("multi", 320),
        worlds("single", 1000),
        worlds("single", 10, count=maps),
    )


def _python(name: str, title: str, code: str) -> Command:
    return Command(name=name, title=f"`{title}`", arguments=(sys.executable, "-c", code))


def worlds(mesh_type: str, size: int, count: int = 1) -> Command:
    """The command that makes complete worlds."""
    wanted = f"--chunk-size 10 --chunks {size // 10} --boundary none --mesh-type {mesh_type} --maps {count} --seed 1"
    arguments = ("generate", *wanted.split(), "--obstacle", "random levels=6", "-o", FOLDER)
    return Command(
        name="maps" if count > 1 else mesh_type,
        title=f"`rsegen generate --mesh-type {mesh_type}`",
        arguments=(sys.executable, "-m", "rsegen", *arguments),
        size=size,
        count=count,
    )
