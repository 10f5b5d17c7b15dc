"""What a running server uses, and the record that it leaves."""

from __future__ import annotations

import os
import re
import time
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import SimulatorFailed
from rsegen.simulators.server import Server

Record = list[tuple[float, dict[str, list[float]]]]
"""Second and poses (x, y, z, roll, pitch, yaw) of models, to three digits, which is all that Gazebo writes."""

IDLE = 0.2
"""Processors in use, below which a server stands still."""

_STATE = re.compile(r"<sim_time>(\d+) (\d+)</sim_time>(.*?)</state>", re.DOTALL)
_MODEL = re.compile(r"<model name='([^']+)'>\s*<pose>([^<]+)</pose>")


@dataclass(frozen=True, kw_only=True, slots=True)
class Usage:
    """Seconds of CPU so far, MB of memory."""

    cpu: float
    memory: float


def when_idle(server: Server) -> Usage:
    """What the server has used when it stands still again."""
    calm, before = 0, usage(server)
    while calm < 3:
        time.sleep(0.4)
        now = usage(server)
        calm = calm + 1 if now.cpu - before.cpu < IDLE * 0.4 else 0
        before = now
    return before


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


def record(text: str) -> Record:
    """State by state, the models that are told."""
    return [
        (
            int(seconds) + int(nanos) / 1e9,
            {name: [float(number) for number in pose.split()] for name, pose in _MODEL.findall(models)},
        )
        for seconds, nanos, models in _STATE.findall(text)
    ]
