"""A Dask cluster makes the same bytes, also where one of its workers is killed in the middle."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from rsegen.input_files import JOURNAL
from rsegen.writing import execute
from tests.support.complaints import OBSTACLE, exit_code, the_line
from tests.support.patience import PATIENCE
from tests.support.runs import contents, ended, started, until_it_has

MANY = ["dataset", *OBSTACLE, "--maps", "8000", "--shard-maps", "200"]

CLUSTER = """
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:
        print(cluster.scheduler_address, flush=True)
        input()
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What is made without a cluster."""
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
def test_a_worker_that_is_killed_costs_nothing(tmp_path: Path, whole: dict[str, bytes]) -> None:
    folder = tmp_path / "set"
    process = started(*MANY, "--workers", "2", "--scheduler", "local", "-o", folder)
    until_it_has(process, lambda: shards(folder) >= 3)
    kill_a_worker(process.pid)
    code, err = ended(process)
    assert code == 0, err
    assert contents(folder) == whole


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """Of a cluster that runs."""
    (tmp_path / "cluster.py").write_text(CLUSTER)
    process = subprocess.Popen(
        [sys.executable, tmp_path / "cluster.py"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout
    yield process.stdout.readline().strip()
    process.communicate("\n", timeout=PATIENCE)


@pytest.mark.slow
def test_a_cluster_that_runs_makes_the_same_bytes(address: str, tmp_path: Path, whole: dict[str, bytes]) -> None:
    process = started(*MANY, "--scheduler", address, "-o", tmp_path / "set")
    code, err = ended(process)
    assert code == 0, err
    assert contents(tmp_path / "set") == whole


@pytest.mark.slow
@pytest.mark.long(reason="a cluster per command")
@pytest.mark.parametrize("command", ["series", "export"])
def test_a_cluster_makes_the_same_bytes_as_this_machine(tmp_path: Path, command: str) -> None:
    flags = [command, *OBSTACLE, "--maps", "12", *(["--to", "heightmap"] if command == "export" else [])]
    for name, where in (("here", ["--workers", "1"]), ("there", ["--workers", "2", "--scheduler", "local"])):
        code, err = ended(started(*flags, *where, "-o", tmp_path / name))
        assert code == 0, err
    assert contents(tmp_path / "here") == contents(tmp_path / "there")


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
