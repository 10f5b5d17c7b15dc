"""Folders that a page shows in the file manager of the machine where its server runs."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from shutil import which
from typing import TypedDict

from rsegen.page.calls import call_of_host
from rsegen.page.host import Host
from rsegen.writing.programs import has_screen

_OPENERS = {"darwin": "open", "win32": "explorer"}
"""Programs that open a folder, by platform; elsewhere it is that of freedesktop.org."""


class ShownFolder(TypedDict):
    """A folder, as a path to copy, and whether a file manager was opened on it."""

    path: str
    is_open: bool


@call_of_host
def show_folder(host: Host, *, path: str) -> ShownFolder:
    """Open the file manager on a folder, or on that of a file; only a person who sits at this machine sees it."""
    place = host.places.inside(path)
    folder = place if place.is_dir() else place.parent
    opener = which(_OPENERS.get(sys.platform, "xdg-open"))
    is_open = False
    if opener and has_screen() and not os.environ.get("SSH_CONNECTION"):
        with suppress(OSError):
            quiet = subprocess.DEVNULL
            subprocess.Popen(  # noqa: S603  # no shell, and the folder is one of ours
                [opener, str(folder)], stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True
            )
            is_open = True
    return {"path": str(folder), "is_open": is_open}
