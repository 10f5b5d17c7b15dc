"""Answers that a shell gets at Tab."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path


def completed(line: str, folder: Path) -> set[str]:
    """Return the answers of argcomplete to a shell in a folder, which reads them from file descriptor 8."""
    out = folder / ".out"
    command = f"exec {shlex.quote(sys.executable)} -m rsegen 8>{shlex.quote(str(out))} 9>/dev/null"
    words = {"COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE": "1", "_ARGCOMPLETE_IFS": "\n"}
    subprocess.run(["bash", "-c", command], env=os.environ | words, cwd=folder, check=True)
    return {text.rstrip() for text in out.read_text("utf-8").split("\n")}
