"""The description of this computer, and its load: what else was going on while a server had its own figures."""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
from contextlib import suppress
from pathlib import Path


def busy() -> float:
    """Seconds so far in which the machine's processors worked, by the number of them."""
    import psutil

    times = psutil.cpu_times()
    idle = times.idle + getattr(times, "iowait", 0.0)
    guests = getattr(times, "guest", 0.0) + getattr(times, "guest_nice", 0.0)  # Linux counts them as time of users too
    return float(sum(times) - idle - guests) / (os.cpu_count() or 1)


def gpu_load() -> float | None:
    """Return the load of the busiest GPU just now, 0..1; None if none tells it (NVIDIA's do, AMD's on Linux)."""
    loads = [int(percent) for percent in re.findall(r"^\d+$", _nvidia() or _amd(), re.MULTILINE)]
    return max(loads) / 100 if loads else None


def description() -> dict[str, str]:
    """Processor, cores, memory, system and load of this computer."""
    import psutil

    table = Path("/proc/cpuinfo")
    named = re.search(r"model name\s*:\s*(.+)", table.read_text()) if table.exists() else None
    return {
        "processor": named[1] if named else platform.processor() or platform.machine(),
        "cores": str(os.cpu_count()),
        "memory": f"{psutil.virtual_memory().total / 2**30:.1f} GB",
        "system": platform.platform(),
        "load before": " ".join(f"{load:.1f}" for load in os.getloadavg()) if hasattr(os, "getloadavg") else "?",
    }


def _nvidia() -> str:
    """Return the loads in percent, a line each; empty without the command."""
    command = shutil.which("nvidia-smi")
    if not command:
        return ""
    asked = [command, "--query-gpu=utilization.gpu", "--format=csv,noheader,nounits"]
    with suppress(OSError, subprocess.SubprocessError):
        answer = subprocess.run(asked, capture_output=True, text=True, timeout=5, check=True)  # noqa: S603  # no shell
        return answer.stdout
    return ""


def _amd() -> str:
    """Return the loads in percent, a line each, from the files of AMD's driver."""
    files = sorted(Path("/sys/class/drm").glob("card*/device/gpu_busy_percent"))
    with suppress(OSError):
        return "".join(file.read_text() for file in files)
    return ""
