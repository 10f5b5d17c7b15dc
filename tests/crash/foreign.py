"""Things of others in the folder of a trial: next to the output, in it, and in the place of what is replaced."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path

NAMES = ("rse_0000.old", "notes.txt", "mine", "file.txt", "folder")
"""Content that `add_foreign` puts into the output folder."""


def add_foreign(trial: Path, *, shared: bool) -> None:
    """Things of others: outside of the folder, next to the output folder, and in it if it may be shared."""
    outside, root = trial / "outside", trial / "root"
    (outside / "folder").mkdir(parents=True)
    (outside / "file.txt").write_text("outside\n", "utf-8")
    (outside / "folder" / "file.txt").write_text("outside, in a folder\n", "utf-8")
    (root / "beside.txt").write_text("beside\n", "utf-8")
    _picture_with_recipe(root / "pictures")
    if not shared:
        return
    out = root / "out"
    (out / "rse_0000.old").mkdir(parents=True)
    (out / "rse_0000.old" / "levels.csv").write_text("1,2\n", "utf-8")
    (out / "notes.txt").write_text("notes\n", "utf-8")
    (out / "notes.txt").chmod(0o640)
    _picture_with_recipe(out / "mine")
    (out / "file.txt").symlink_to("../../outside/file.txt")
    (out / "folder").symlink_to("../../outside/folder")


def _picture_with_recipe(folder: Path) -> None:
    """A folder that rsegen might take for its own: an empty recipe.json beside a picture."""
    folder.mkdir()
    (folder / "recipe.json").touch()
    (folder / "preview.png").write_bytes(b"a picture of others\n")


def put_foreign(path: Path, what: str, rng: random.Random) -> None:
    """Put a link or a folder in the place of what rsegen wrote, change one of its files, or add one."""
    if what == "a change":
        file = rng.choice(sorted(one for one in path.rglob("*") if one.is_file() and "rsegen" not in one.name))
        file.write_bytes(file.read_bytes() + b"mine\n")
        return
    if what == "a file more":
        (path / "mine.txt").write_text("mine\n", "utf-8")
        return
    if path.is_dir():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)
    if what == "a link":
        path.symlink_to(os.path.relpath(_outside_of(path), path.parent))
    else:
        _picture_with_recipe(path)


def _outside_of(path: Path) -> Path:
    return next(above for above in path.parents if above.name == "root").parent / "outside" / "folder"
