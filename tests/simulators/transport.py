"""A world of Gazebo Sim's own transport library, with no simulation behind it (real/engine/transport.cc)."""

from __future__ import annotations

import os
import secrets
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest

from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.patience import Patience
from tests.support.missing import missing

PROGRAM = Path.home() / ".cache/rsegen/gazebo-engine/gazebo-transport"
PATIENCE = 30.0
NEEDS_ENGINE = pytest.mark.long(reason="packages of 1.7 GB, which scripts/gazebo-engine installs")


@contextmanager
def transport_world(name: str = "lab", partition: str = "") -> Iterator[Mapping[str, str]]:
    """The variables by which a world that has the ground alone is reached."""
    if not PROGRAM.exists():
        missing("no transport of Gazebo Sim: run scripts/gazebo-engine")
    partition = partition or f"test-{secrets.token_hex(4)}"
    address = {"IGN_PARTITION": partition, "IGN_IP": "127.0.0.1"}
    with subprocess.Popen([PROGRAM, name], env=os.environ | address, stdin=subprocess.PIPE) as server:
        assert server.stdin
        with server.stdin:
            yield {"GZ_PARTITION": partition, "GZ_IP": "127.0.0.1"}


@contextmanager
def connected_to(address: Mapping[str, str]) -> Iterator[LiveWorld]:
    """The world at these variables."""
    with SIMULATORS["sim"].connect(address, Patience(seconds=PATIENCE, sign=PATIENCE)) as live:
        yield live
