"""What a computer is, and what a process of it uses."""

from __future__ import annotations

import os
import platform
import re
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import SimulatorFailed


@dataclass(frozen=True, kw_only=True, slots=True)
class Usage:
    """Seconds of CPU so far, and MB of memory."""

    cpu: float
    memory: float


def usage(pid: int) -> Usage:
    """What a process has used; SimulatorFailed where it is gone."""
    import psutil

    try:
        process = psutil.Process(pid)
        times, memory = process.cpu_times(), process.memory_info()
    except psutil.Error:
        raise SimulatorFailed("the simulator is gone") from None
    return Usage(cpu=times.user + times.system, memory=memory.rss / 2**20)


def description() -> dict[str, str]:
    """What computer it is, in words."""
    import psutil

    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "memory": f"{psutil.virtual_memory().total / 2**30:.1f} GB",
        "system": platform.platform(),
        "load before": " ".join(f"{load:.1f}" for load in os.getloadavg()) if hasattr(os, "getloadavg") else "?",
    }


def _processor() -> str:
    path = Path("/proc/cpuinfo")
    named = re.search(r"model name\s*:\s*(.+)", path.read_text()) if path.exists() else None
    return named[1] if named else platform.processor() or platform.machine()
