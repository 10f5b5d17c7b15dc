"""The description of this computer, and the CPU time and memory of a process."""

from __future__ import annotations

import os
import platform
import re
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import SimulatorFailed


@dataclass(frozen=True, kw_only=True, slots=True)
class Usage:
    """CPU time in seconds so far, and memory in MB."""

    cpu: float
    memory: float


def usage(pid: int) -> Usage:
    """The usage of a process with those that it has started; SimulatorFailed if it has ended."""
    import psutil

    try:
        process = psutil.Process(pid)
        found = [(each.cpu_times(), each.memory_info()) for each in (process, *process.children(recursive=True))]
    except psutil.Error:
        raise SimulatorFailed("the simulator is gone") from None
    cpu = sum(times.user + times.system for times, _ in found)
    return Usage(cpu=cpu, memory=sum(memory.rss for _, memory in found) / 2**20)


def description() -> dict[str, str]:
    """Processor, cores, memory, system and load of this computer."""
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
