"""Shares of memory and processors that control groups leave this process, in a container or a job of a cluster.

Source: Documentation/admin-guide of Linux, cgroup-v2.rst, cgroup-v1/memory.rst and scheduler/sched-bwc.rst.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_GROUPS, _OWN_GROUPS = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")

_MEMORY = {
    "memory.max": ("memory.current", "inactive_file"),
    "memory.limit_in_bytes": ("memory.usage_in_bytes", "total_inactive_file"),
}
"""Limit of a control group, its use, and what of that is freed on demand: names of cgroup v2 and v1."""


def free_memory() -> float:
    """Return the bytes that the control groups of this process leave it; infinitely many if none has a limit."""
    return min((_free_in(group) for group in _own_groups("memory")), default=math.inf)


def processors() -> float:
    """Return of how many processors this process may use the time; infinitely many if no group has a limit."""
    return min((_processors_in(group) for group in _own_groups("cpu")), default=math.inf)


def _own_groups(controller: str) -> Iterator[Path]:
    """Yield the folders of the control groups that this process is in, from the innermost to the root of each tree.

    A container may see its own group as the root, under which the path of the group does not exist.
    """
    with suppress(OSError):
        for line in _OWN_GROUPS.read_text("utf-8", "replace").splitlines():
            _, controllers, path = line.split(":", 2)
            if controllers and controller not in controllers.split(","):
                continue
            root = _GROUPS / controllers
            group = root / path.strip("/")
            for folder in (group, *group.parents):
                yield folder
                if folder == root:
                    break


def _free_in(group: Path) -> float:
    """Return the bytes of memory that a control group leaves its processes; infinitely many if it has no limit."""
    for limit, (used, on_demand) in _MEMORY.items():
        with suppress(OSError, ValueError):
            most = int((group / limit).read_text("ascii"))  # or `max`
            entries = dict(line.split() for line in (group / "memory.stat").read_text("ascii").splitlines())
            return max(0, most - int((group / used).read_text("ascii")) + int(entries.get(on_demand, 0)))
    return math.inf


def _processors_in(group: Path) -> float:
    """Return how many processors a control group has: its time in each period; infinitely many if it has no limit."""
    for names in (("cpu.max",), ("cpu.cfs_quota_us", "cpu.cfs_period_us")):
        with suppress(OSError, ValueError):
            quota, period = (int(word) for name in names for word in (group / name).read_text("ascii").split())
            if quota > 0 and period > 0:  # v1 says -1, v2 `max`, for no limit
                return quota / period
    return math.inf
