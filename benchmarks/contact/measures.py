"""What a running server uses."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import SimulatorFailed
from rsegen.simulators.server import Server


@dataclass(frozen=True, kw_only=True, slots=True)
class Usage:
    """Seconds of CPU so far, MB of memory."""

    cpu: float
    memory: float


def usage(server: Server) -> Usage:
    """From /proc, of which a server that is gone has no more to say."""
    try:
        stat = Path(f"/proc/{server.pid}/stat").read_text().rpartition(")")[2].split()
        status = Path(f"/proc/{server.pid}/status").read_text()
    except OSError as error:
        raise SimulatorFailed(str(error)) from error
    resident = re.search(r"VmRSS:\s+(\d+)", status)
    if not resident:
        raise SimulatorFailed("the server is dead")
    return Usage(cpu=(int(stat[11]) + int(stat[12])) / os.sysconf("SC_CLK_TCK"), memory=int(resident[1]) / 1024)
