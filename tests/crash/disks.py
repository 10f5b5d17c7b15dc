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
        """Reason why it cannot be mounted here, as far as can be seen; an empty text if it can."""
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


_SFTP = "/usr/lib/openssh/sftp-server"


def _of_sftp(source: Path, place: Path) -> list[str]:
    """The command that mounts a folder by SFTP, as from another machine, whose server is asked without a network."""
    source.mkdir()
    command = source.with_name("ssh")  # sshfs starts it in place of ssh, with the arguments of ssh
    command.write_text(f"#!/bin/sh\nexec {_SFTP}\n", "utf-8")
    command.chmod(0o700)
    help_text = subprocess.run(["sshfs", "--help"], capture_output=True, text=True, check=False).stdout
    # Some versions keep links that lead upwards from being read, which the trials have beside the output.
    links = ["-o", "no_contain_symlinks"] * ("no_contain_symlinks" in help_text)
    return ["sshfs", "-o", f"ssh_command={command}", *links, f"none:{source}", str(place)]


def _of_image(*make: str) -> Callable[[Path, Path], list[str]]:
    """The command that mounts a file, in which a command makes the disk."""

    def mount(source: Path, place: Path) -> list[str]:
        with source.open("wb") as file:
            file.truncate(_IMAGE)
        _called(*make, str(source))
        return ["mount", "-o", "loop", str(source), str(place)]

    return mount


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
        name="FUSE (sshfs)",
        exchanges=False,
        programs={
            "sshfs": "sshfs",
            _SFTP: "openssh-sftp-server",
            "fusermount3": "fuse3",
            "umount": "mount",
        },
        mount=_of_sftp,
    ),
    Disk(
        name="ext4 (loop)",
        exchanges=True,
        programs={"mkfs.ext4": "e2fsprogs", "mount": "mount", "umount": "mount"},
        mount=_of_image("mkfs.ext4", "-q"),
    ),
    Disk(
        name="XFS (loop)",
        exchanges=True,
        programs={"mkfs.xfs": "xfsprogs", "mount": "mount", "umount": "mount"},
        mount=_of_image("mkfs.xfs", "-q"),
    ),
    Disk(
        name="Btrfs (loop)",
        exchanges=True,
        programs={"mkfs.btrfs": "btrfs-progs", "mount": "mount", "umount": "mount"},
        mount=_of_image("mkfs.btrfs", "-q"),
    ),
)
"""Disks on which trials are made beside those on this machine's own."""
