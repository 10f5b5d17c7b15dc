"""A Dask cluster makes the same bytes, also where one of its workers is killed in the middle."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import psutil
import pytest

from rsegen.input_files import JOURNAL
from rsegen.writing import execute
from tests.support.complaints import OBSTACLE, exit_code, the_line
from tests.support.long import long_unless
from tests.support.patience import PATIENCE
from tests.support.runs import contents, ended, started, until_it_has

MANY = ["dataset", *OBSTACLE, "--maps", "4000", "--shard-maps", "100"]

CLUSTER = """
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:
        print(cluster.scheduler_address, flush=True)
        input()
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a run without a cluster."""
    folder = tmp_path_factory.mktemp("whole")
    assert exit_code(*MANY, "--workers", "1", "-o", folder) == 0
    return contents(folder)


def shards(folder: Path) -> int:
    journal = folder / JOURNAL
    return (journal.read_text("utf-8").count("\n") - 1) // 2 if journal.is_file() else 0


def kill_a_worker(parent: int) -> None:
    children = psutil.Process(parent).children(recursive=True)
    titles = ("spawn_main", "dask worker")  # the second where setproctitle is installed
    worker = next(one for one in children if any(title in " ".join(one.cmdline()) for title in titles))
    worker.kill()


@pytest.mark.slow
@pytest.mark.long(reason="a worker is killed at any moment in make test")
def test_a_worker_that_is_killed_costs_nothing(tmp_path: Path, whole: dict[str, bytes]) -> None:
    folder = tmp_path / "set"
    process = started(*MANY, "--workers", "2", "--scheduler", "local", "-o", folder)
    until_it_has(process, lambda: shards(folder) >= 3)
    kill_a_worker(process.pid)
    code, err = ended(process)
    assert code == 0, err
    assert contents(folder) == whole


@contextmanager
def cluster(folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A cluster that runs in a process of its own, and its address."""
    (folder / "cluster.py").write_text(CLUSTER)
    process = subprocess.Popen(
        [sys.executable, folder / "cluster.py"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.communicate(None if process.poll() is not None else "\n", timeout=PATIENCE)


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Of a cluster that runs."""
    with cluster(tmp_path_factory.mktemp("cluster")) as (_, found):
        yield found


MOST = 5
"""Kills of a part of a cluster until one stops the run before it is complete."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "victim",
    long_unless(lambda one: one == "worker", ["client", "scheduler", "worker"], reason="another part of the cluster"),
)
def test_a_cluster_of_which_a_part_is_killed_at_any_moment_is_continued_to_the_same_bytes(
    victim: str, tmp_path: Path, whole: dict[str, bytes]
) -> None:
    rng = random.Random()  # noqa: S311  # moments, not secrets
    for trial in range(MOST):
        # Results of some shards are on their way, with which a run may be complete without its scheduler.
        at, delay = rng.randrange(1, 5 if victim == "scheduler" else 20), rng.uniform(0, 0.1)
        told = f"{victim} killed after {at} shards and {delay:.3f} s"
        stopped = kill_and_continue(victim, tmp_path / f"set {trial}", at, delay, told)
        assert contents(tmp_path / f"set {trial}") == whole, told
        if stopped or victim == "worker":
            return
    pytest.fail("no run was stopped before it was complete")


def kill_and_continue(victim: str, folder: Path, at: int, delay: float, told: str) -> bool:
    """Kill a part of a cluster some time after there are so many shards, and go on, on the cluster if it lives.

    Returns whether the run was stopped by it.
    """
    with cluster(folder.parent) as (server, where):
        process = started(*MANY, "--scheduler", where, "-o", folder)
        until_it_has(process, lambda: shards(folder) >= at)
        time.sleep(delay)
        if victim == "worker":
            kill_a_worker(server.pid)
        else:
            kill_with_children(server if victim == "scheduler" else process)
        code, err = ended(process)
        is_stopped = code != 0
        if victim == "client":  # the cluster may still work for it
            code, err = ended(started(*MANY, "--scheduler", where, "--resume", "-o", folder))
    if victim == "scheduler" and is_stopped:
        assert code == 1, f"{told}: {err}"
        assert f"the cluster at {where} was lost" in the_line(err), told
        code, err = ended(started(*MANY, "--workers", "1", "--resume", "-o", folder))
    assert code == 0, f"{told}: {err}"
    return is_stopped


def kill_with_children(process: subprocess.Popen[str]) -> None:
    parts = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
    for part in parts:
        with suppress(psutil.NoSuchProcess):
            part.kill()


@pytest.mark.slow
def test_a_cluster_that_runs_makes_the_same_bytes(address: str, tmp_path: Path, whole: dict[str, bytes]) -> None:
    process = started(*MANY, "--scheduler", address, "-o", tmp_path / "set")
    code, err = ended(process)
    assert code == 0, err
    assert contents(tmp_path / "set") == whole


@pytest.mark.slow
@pytest.mark.parametrize("command", ["series", "export"])
def test_a_cluster_makes_the_same_bytes_as_this_machine(tmp_path: Path, command: str, address: str) -> None:
    flags = [command, *OBSTACLE, "--maps", "4", *(["--to", "heightmap"] if command == "export" else [])]
    assert exit_code(*flags, "--workers", "1", "-o", tmp_path / "here") == 0
    code, err = ended(started(*flags, "--scheduler", address, "-o", tmp_path / "there"))
    assert code == 0, err
    assert contents(tmp_path / "here") == contents(tmp_path / "there")


@pytest.mark.slow
def test_a_worker_may_be_lost_just_after_its_result_has_come(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed.client import Future

    lost = []
    result: Any = Future._result

    async def and_is_lost(future: Any, **options: bool) -> object:
        value = await result(future, **options)
        future._state.lose()
        lost.append(future.key)
        return value

    monkeypatch.setattr(Future, "_result", and_is_lost)
    sums = list(execute.execute(sum, range(100), 0.05, execute.Execution(scheduler=address)))
    assert len(lost) == len(sums) > 1
    assert sum(sums) == sum(range(100))


@pytest.mark.slow
def test_a_scheduler_that_is_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(execute, "PATIENCE", "1s")
    for address in ("tcp://127.0.0.1:9", "no address"):
        assert exit_code(*MANY, "--scheduler", address, "-o", tmp_path / "set") == 2
        assert f"scheduler: cannot connect to {address}" in the_line(capsys.readouterr().err)
        assert list(tmp_path.iterdir()) == []


def test_without_dask(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert exit_code(*MANY, "--scheduler", "local", "-o", tmp_path / "set") == 2
    assert "pip install 'distributed" in the_line(capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []
