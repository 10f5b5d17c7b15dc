"""The commands that are disturbed: what exists before, the command itself, and the one that continues it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.fuzz.seeds import cloud

_SMALL = ["--obstacle", "random levels=4", "--chunk-size", "3"]
_SEED, _OTHER_SEED = ["--seed", "7"], ["--seed", "8"]
_FOLDER = ["-o", "out"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Run:
    """A command; paths are relative to the folder of the trial, and `{inputs}` is that of the inputs.

    first: commands that have filled the folder before   damage: what is then removed
    goes_on: `resume` continues it with --resume, `again` by the same command, with --force if its output exists,
      `itself` by the same command
    depth: how many names below the folder `out` make a unit, which is old or new as a whole; 0: all of `out`
    shares: whether foreign things may lie in the folder `out`   syncs: whether it waits for the disk
    rare: whether it takes long, and has fewer trials
    """

    name: str
    command: Sequence[str]
    goes_on: str = "resume"
    first: Sequence[Sequence[str]] = ()
    damage: Callable[[Path], object] | None = None
    depth: int = 1
    shares: bool = True
    syncs: bool = True
    rare: bool = False

    def continued(self, *, exists: bool) -> list[str]:
        """The command that continues it; exists: whether a part of its output does."""
        flags = {"resume": ["--resume"], "again": ["--force"] * exists, "itself": []}
        more = [] if "--force" in self.command else flags[self.goes_on]
        return [*self.command, *(flag for flag in more if flag not in self.command)]

    def forced(self) -> list[str]:
        """The command that replaces what it has made."""
        kept = [word for word in self.command if word not in ("--resume", "--force")]
        return [*kept, "--force"]


def made_inputs(folder: Path) -> Path:
    """A folder with a point cloud, a table of heights, and a recipe with enough obstacles for workers."""
    folder.mkdir()
    np.savetxt(folder / "cloud.xyz", cloud(np.random.default_rng(3)), fmt="%.4f")
    np.savetxt(folder / "heights.csv", np.arange(12).reshape(3, 4) % 5 * 10, fmt="%d", delimiter=",")
    rows = "\n".join(f"  - {{kind: peak, levels: 3, first: [{i % 3}, 0], last: [2, 2]}}" for i in range(100))
    (folder / "many.yaml").write_text(f"chunk_size: 3\nobstacles:\n{rows}\n", "utf-8")
    return folder


def _removed(*names: str) -> Callable[[Path], object]:
    """Remove files and folders below a folder."""

    def remove(folder: Path) -> None:
        for name in names:
            path = folder / "out" / name
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    return remove


def _forced(
    name: str, command: Sequence[str], first: Sequence[Sequence[str]], *, depth: int = 1, rare: bool = False
) -> Run:
    """A command over what others have made."""
    return Run(name=f"{name} --force", command=[*command, "--force"], first=first, depth=depth, rare=rare)


def _maps(name: str, command: Sequence[str], damage: Sequence[str], *, rare: bool = False) -> list[Run]:
    """A command that makes maps, alone, over those of another seed, and resumed after a part was removed."""
    mine, other = [*command, *_SEED, *_FOLDER], [*command, *_OTHER_SEED, *_FOLDER]
    return [
        Run(name=name, command=mine),
        _forced(name, mine, [other], rare=rare),
        Run(name=f"{name} --resume", command=[*mine, "--resume"], first=[mine], damage=_removed(*damage), rare=rare),
    ]


def _files(name: str, *arguments: str, other: Sequence[str]) -> list[Run]:
    """A command that makes single files, alone and over those of another map."""
    command, rare = [name, *arguments], name != "view"  # a picture takes long
    return [
        Run(name=name, command=command, goes_on="again", rare=rare),
        _forced(name, command, [[name, *other]], rare=rare),
    ]


_GENERATE = ["generate", *_SMALL, "--maps", "4", "--workers", "1"]
_LARGE = ["--obstacle", "peak levels=4 first=2,2 last=7,7", "--chunk-size", "260", "--boundary", "none", *_SEED]
_HEIGHTMAP, _ROS2 = ["--to", "heightmap"], ["--to", "ros2 package=fields"]
_EXPORT = ["export", *_SMALL, *_SEED, "--maps", "3", *_FOLDER]
_DATASET = ["dataset", *_SMALL, "--maps", "20", "--shard-maps", "5"]
_TERRAIN = ["terrain", "peak", "figure-7", "--rows", "2", "--columns", "2"]
_SCAN = ["scan", "{inputs}/cloud.xyz"]
_BURGER = ["--robot", "burger"]
_EVEN = ["--obstacle", "peak levels=2 softness=100"]
_LEVEL = ["--obstacle", "random levels=2", "--chunk-size", "3"]
_ONE, _OTHER_ONE = [*_SMALL, *_SEED], [*_SMALL, *_OTHER_SEED]


def _datasets() -> list[Run]:
    mine, other = [*_DATASET, *_SEED, *_FOLDER], [*_DATASET, *_OTHER_SEED, *_FOLDER]
    many = ["dataset", "{inputs}/many.yaml", *_SEED, "--maps", "400", "--shard-maps", "40", "--metrics", "none"]
    damage = _removed("levels-00001.npy")
    return [
        Run(name="dataset", command=mine, shares=False),
        Run(name="dataset, workers", command=[*many, "--workers", "2", *_FOLDER], shares=False),
        Run(name="dataset --force", command=[*mine, "--force"], first=[other], depth=0, shares=False),
        Run(name="dataset --resume", command=[*mine, "--resume"], first=[mine], damage=damage, shares=False),
    ]


def _drives() -> list[Run]:
    """Drives in MuJoCo, and a rating, of which each trial is kept as soon as it is made."""
    drive = ["drive", *_LEVEL, "--no-predict", "--duration", "0.2", "--no-contacts", *_FOLDER]
    drives = ["drives", *_LEVEL, "--maps", "3", "--duration", "0.2", "--workers", "1", *_FOLDER]
    rate = ["rate", "burger", "--by", "prediction", "--trials", "8", "--chunk-size", "3", "--workers", "1", *_FOLDER]
    return [
        Run(name="drive", command=[*drive, *_SEED], goes_on="again", depth=0, shares=False, rare=True),
        _whole("drive", [*drive, *_SEED], [*drive, *_OTHER_SEED]),
        Run(name="drives", command=[*drives, *_SEED], goes_on="again", depth=0, shares=False, rare=True),
        _whole("drives", [*drives, *_SEED], [*drives, *_OTHER_SEED]),
        Run(name="rate", command=[*rate, *_SEED], goes_on="itself", shares=False, rare=True),
        _whole("rate", [*rate, *_SEED], [*rate, *_OTHER_SEED]),
    ]


def _whole(name: str, command: Sequence[str], other: Sequence[str]) -> Run:
    """A command whose folder is replaced as a whole, over what it made of another seed."""
    return Run(name=f"{name} --force", command=[*command, "--force"], first=[other], depth=0, shares=False, rare=True)


RUNS: Sequence[Run] = (
    *_maps("generate", _GENERATE, ["rse_0001", "rse_0002/levels.csv"]),
    _forced(
        "generate over more files",
        [*_GENERATE, *_SEED, *_FOLDER],
        [[*_GENERATE, *_OTHER_SEED, *_FOLDER, "--formats", "heightmap,arrays"]],
    ),
    Run(
        name="generate, workers",
        command=["generate", *_LARGE, "--maps", "4", "--workers", "2", *_FOLDER],
        rare=True,
    ),
    Run(name="generate --no-sync", command=[*_GENERATE, *_SEED, *_FOLDER, "--no-sync"], syncs=False),
    Run(
        name="generate, sidecars",
        command=[
            *["generate", *_ONE, "--maps", "2", "--workers", "1", *_FOLDER],
            *["--preview", "--sheet", "--formats", "heightmap"],
        ],
        rare=True,
    ),
    *_maps("series", ["series", *_SMALL, "--maps", "3", "--workers", "1"], ["rse_0001", "series.csv"], rare=True),
    Run(name="export", command=[*_EXPORT, *_HEIGHTMAP]),
    Run(
        name="export to worlds",
        command=[*_EXPORT, *_HEIGHTMAP],
        first=[["generate", *_ONE, "--maps", "4", *_FOLDER]],
        depth=2,
    ),
    _forced("export", [*_EXPORT, "--to", "heightmap pixels=2"], [[*_EXPORT, *_HEIGHTMAP]], depth=2),
    Run(name="export, joined", command=[*_EXPORT, *_ROS2]),
    _forced("export, joined", [*_EXPORT, "--to", "ros2 package=fields margin_cm=300"], [[*_EXPORT, *_ROS2]]),
    *_datasets(),
    *_drives(),
    *_maps("terrain", _TERRAIN, ["terrain_0000/levels.csv"]),
    *_files("sheet", *_ONE, "-o", "out/a.pdf", "--csv", "out/a.csv", other=[*_OTHER_ONE, "-o", "out/a.pdf"]),
    *_files("view", *_ONE, "-o", "out/a.html", other=[*_OTHER_ONE, "-o", "out/a.html"]),
    *_files("preview", *_ONE, "-o", "out/a.png", other=[*_OTHER_ONE, "-o", "out/a.png"]),
    *_files("metrics", *_ONE, *_BURGER, "-o", "out/a.png", other=[*_OTHER_ONE, *_BURGER, "-o", "out/a.png"]),
    *_files("spots", *_EVEN, *_SEED, "-o", "out/a.svg", other=[*_EVEN, *_OTHER_SEED, "-o", "out/a.svg"]),
    Run(
        name="compare",
        command=["compare", "out/rse_0000", "out/rse_0000", "-o", "out/a.png"],
        goes_on="again",
        rare=True,
        first=[["generate", *_ONE, *_FOLDER]],
    ),
    Run(name="scan", command=[*_SCAN, *_FOLDER], rare=True),
    _forced("scan", [*_SCAN, *_FOLDER], [[*_SCAN, "--fill-holes", *_FOLDER]], rare=True),
    Run(name="import", command=["import", "{inputs}/heights.csv", *_FOLDER]),
    _forced(
        "import",
        ["import", "{inputs}/heights.csv", *_FOLDER],
        [["import", "{inputs}/heights.csv", "--datum-cm=-10", *_FOLDER]],
    ),
    Run(name="examples", command=["examples", *_FOLDER], goes_on="again"),
    _forced("examples", ["examples", *_FOLDER], [["examples", *_FOLDER]]),
)
"""All commands that write without Gazebo."""

TURNS = [*[run for run in RUNS if not run.rare] * 3, *[run for run in RUNS if run.rare]]
"""The commands of the trials, in turns."""
