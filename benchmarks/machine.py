"""The machine in one line: what the seconds depend on, and nothing that says whose it is."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def machine() -> str:
    """Model of the CPU, cores and what they do already, Python and libraries."""
    libraries = ", ".join(f"{name} {_version(name)}" for name in ("numpy", "trimesh"))
    cores = f"{os.cpu_count()} cores, {os.getloadavg()[0]:.1f} of them busy before"
    return f"{_cpu()}, {cores}; {platform.system()}; Python {platform.python_version()}, {libraries}"


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        return platform.machine()
    return next((line.partition(": ")[2] for line in lines if line.startswith("model name")), platform.machine())


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
