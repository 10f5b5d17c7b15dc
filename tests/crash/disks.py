"""Disks of other kinds than this machine's own, mounted for the trials: one of FUSE, and one of ext4 in a file.

a folder --bindfs--> FUSE, which cannot exchange two names        a file --mkfs.ext4, mount -o loop--> ext4, which can
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

_IMAGE = 2**29
"""Bytes of the file of an ext4 disk; a trial needs some MiB."""


class NotMounted(Exception):
    """A disk cannot be mounted here; its text says why."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Disk:
    """A disk that trials are made on; exchanges: whether it can exchange two names at once."""

    name: str
    exchanges: bool
    programs: Mapping[str, str]
    mount: Callable[[Path, Path], list[str]]

    def missing(self) -> str:
        """Why it cannot be mounted here, as far as can be seen; an empty text if it can."""
        if sys.platform != "linux":
            return "only Linux mounts it"
        if os.geteuid():
            return "only root may mount it"
        absent = [package for program, package in self.programs.items() if not shutil.which(program)]
        return f"apt-get install {' '.join(absent)}" if absent else ""

    @contextmanager
    def mounted(self) -> Iterator[Path]:
        """A folder on the disk, which is unmounted at the end; NotMounted if that fails."""
        if why := self.missing():
            raise NotMounted(why)
        with tempfile.TemporaryDirectory(prefix="rsegen-disk-") as name, ExitStack() as stack:
            source, place = Path(name, "source"), Path(name, "mounted")
            place.mkdir()
            _called(*self.mount(source, place))
            stack.callback(_called, "umount", str(place))
            yield place


def _of_fuse(source: Path, place: Path) -> list[str]:
    """The command that mounts a folder once more, by FUSE."""
    source.mkdir()
    return ["bindfs", str(source), str(place)]


def _of_image(source: Path, place: Path) -> list[str]:
    """The command that mounts a file, in which ext4 is made."""
    with source.open("wb") as file:
        file.truncate(_IMAGE)
    _called("mkfs.ext4", "-q", str(source))
    return ["mount", "-o", "loop", str(source), str(place)]


def _called(*command: str) -> None:
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise NotMounted(f"{command[0]}: {ended.stderr.strip() or f'exit code {ended.returncode}'}")


DISKS = (
    Disk(
        name="FUSE (bindfs)",
        exchanges=False,
        programs={"bindfs": "bindfs", "fusermount3": "fuse3", "umount": "mount"},
        mount=_of_fuse,
    ),
    Disk(
        name="ext4 (loop)",
        exchanges=True,
        programs={"mkfs.ext4": "e2fsprogs", "mount": "mount", "umount": "mount"},
        mount=_of_image,
    ),
)
"""Disks on which trials are made beside those on this machine's own."""
