"""A page drives a robot in a real Gazebo, plays what was recorded, and leaves nothing when it is stopped."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from rsegen.page import commands, playback
from rsegen.page import host as hosting
from rsegen.page.host import Host
from rsegen.simulation.simulators import Installation
from tests.support.patience import until


@pytest.fixture
def host(tmp_path: Path, gazebo_classic: Installation) -> Any:
    made = Host(folder=tmp_path)
    yield made
    made.jobs.close()


def now(host: Host, job: dict[str, Any]) -> dict[str, Any]:
    return next(each for each in host.jobs.listed() if each["id"] == job["id"])


def test_a_drive_of_a_page_is_played_as_gazebo_recorded_it(host: Host) -> None:
    doc = hosting.open(host, what="peak")["doc"]
    values = {"robot": "burger", "duration": 2, "simulator": "classic", "seed": 3}
    job = commands.run(host, doc=doc, command="drive", values=values, output="drive")
    until(lambda: now(host, job)["state"] != "running")
    done = now(host, job)
    assert (done["state"], done["done"], done["total"]) == ("done", 2, 2)
    assert {"path": "drive", "name": "drive", "kind": "drive"} in done["files"]
    (robot,) = playback.playback(host, path="drive")["robots"]
    recorded = np.loadtxt(host.folder / "drive" / f"{robot['name']}.csv", delimiter=",", skiprows=1)
    assert np.array_equal(np.column_stack([robot["seconds"], robot["poses"]]), recorded)
    assert robot["robot"] == "burger"


def test_a_drive_that_is_cancelled_leaves_no_server_and_no_folder(host: Host) -> None:
    doc = hosting.open(host, what="peak")["doc"]
    values = {"duration": 500, "simulator": "classic"}
    job = commands.run(host, doc=doc, command="drive", values=values, output="drive")
    until(lambda: bool(now(host, job)["done"]))
    commands.cancel(host, job=job["id"])
    until(lambda: now(host, job)["state"] == "cancelled")
    assert not psutil.Process().children(recursive=True)
    assert list(host.folder.iterdir()) == []
