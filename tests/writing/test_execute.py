"""Several workers make what one makes, and end when they should."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as finished
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import pytest

import rsegen
from rsegen import GeneratedMap, Recipe
from rsegen.errors import ParameterError, WorkerLost
from rsegen.formats.exports import ExportedMap
from rsegen.formats.heightmap import Heightmap
from rsegen.formats.occupancy import Occupancy
from rsegen.recipe.codec import decode
from rsegen.writing import execute as execute_module
from rsegen.writing import stop
from rsegen.writing.execute import Execution, execute
from rsegen.writing.programs import LaunchCommand, running
from tests.support.complaints import exit_code, the_line
from tests.support.long import long_unless
from tests.support.patience import PATIENCE
from tests.support.runs import (
    contents,
    ended,
    started,
    started_with_small_files,
    until_it_has,
    until_there,
    whole_maps_only,
)

OBSTACLE = ["--obstacle", "random levels=5", "--seed", "7"]
MANY = [*OBSTACLE, "--maps", "50000", "--workers", "2"]
RECIPE = Recipe(
    seed=7,
    maps=13,
    first_map=9_995,
    chunk_size=4,
    obstacles=[rsegen.Random(levels=3), rsegen.Peak(levels=5)],
)


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers are started however little there is to make."""
    monkeypatch.setattr(execute_module, "WORTHWHILE", 0.0)


@pytest.mark.slow
@pytest.mark.usefixtures("eager")
@pytest.mark.parametrize("mesh_type", ["single", "multi"])
def test_maps_are_the_same_for_any_number_of_workers(tmp_path: Path, mesh_type: str) -> None:
    recipe, told = decode({**RECIPE.entry(), "mesh_type": mesh_type}), []
    for workers in (1, 2, 3):
        seen: list[GeneratedMap] = []
        made = rsegen.generate(recipe, tmp_path / str(workers), workers=workers, progress=seen.append)
        assert tuple(seen) == made.maps
        assert [one.index for one in seen] == list(recipe.indices)
        told.append([(one.names, one.cells, one.extent, one.level_counts, one.warnings) for one in seen])
        assert all(path.is_file() for one in seen for path in one.files)
    assert told[0] == told[1] == told[2]
    assert contents(tmp_path / "1") == contents(tmp_path / "2") == contents(tmp_path / "3")


@pytest.mark.long(reason="tests/writing/test_execute.py has workers once for all commands")
@pytest.mark.slow
@pytest.mark.usefixtures("eager")
def test_exports_of_several_recipes_are_the_same_for_any_number_of_workers(tmp_path: Path) -> None:
    recipes, formats, told = [RECIPE, replace(RECIPE, name="other", seed=8)], [Heightmap(), Occupancy()], []
    names = [recipe.map_name(index) for recipe in recipes for index in recipe.indices]
    for workers in (1, 2, 3):
        seen: list[ExportedMap] = []
        folder = tmp_path / str(workers)
        made = rsegen.export_maps(recipes, folder, formats, workers=workers, progress=seen.append)
        assert tuple(seen) == made
        assert [one.folder for one in seen] == [folder / name for name in names]
        told.append([one.names for one in seen])
    assert told[0] == told[1] == told[2]
    assert contents(tmp_path / "1") == contents(tmp_path / "2") == contents(tmp_path / "3")


@pytest.mark.slow
@pytest.mark.usefixtures("eager")
def test_the_command_exports_with_as_many_workers_as_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    @contextmanager
    def here(workers: int) -> Iterator[tuple[Callable[..., Future[object]], int, Callable[[], None]]]:
        asked.append(workers)
        with ThreadPoolExecutor(1) as executor:
            yield executor.submit, workers, lambda: None

    monkeypatch.setattr(execute_module, "_processes", here)
    rsegen.save(RECIPE, tmp_path / "recipe.json")
    command: list[str | Path] = ["export", tmp_path / "recipe.json", "--to", "heightmap"]
    for workers in ("1", "2", "3"):
        assert exit_code(*command, "--workers", workers, "-o", tmp_path / workers) == 0
    assert asked == [2, 3]
    assert exit_code(*command, "--workers", "0", "-o", tmp_path / "none") == 2
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


def test_few_maps_start_no_worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execute_module, "_processes", lambda _: pytest.fail("workers were started"))
    assert len(rsegen.generate(RECIPE, tmp_path / "worlds", workers=8).maps) == 13
    assert len(rsegen.export_maps([RECIPE], tmp_path / "exported", [Heightmap()], workers=8)) == 13
    assert rsegen.export_maps([], tmp_path / "none", [Heightmap()], workers=8) == ()


def test_no_worker_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="workers: 0 is not"):
        rsegen.generate(RECIPE, tmp_path, workers=0)
    with pytest.raises(ParameterError, match="workers: 0 is not"):
        rsegen.export_maps([RECIPE], tmp_path, [Heightmap()], workers=0)


def exporting(folder: Path, recipe: Recipe) -> list[str | Path]:
    """A command that exports the maps of a recipe, which is put into a folder."""
    rsegen.save(recipe, folder / "recipe.json")
    return ["export", folder / "recipe.json", "--to", "occupancy,mjcf"]


@pytest.fixture(params=["generate", "export"])
def failing(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[str | Path]:
    """A command whose maps have files of more than a few kilobytes."""
    if request.param == "generate":
        return ["generate", *OBSTACLE, "--chunks", "5", "--maps", "200"]
    return exporting(tmp_path_factory.mktemp("recipe"), replace(RECIPE, maps=200, first_map=0, chunks=(12, 12)))


@pytest.fixture(params=["generate", "export"])
def many(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[str | Path]:
    """A command whose two workers are not soon done."""
    if request.param == "generate":
        return ["generate", *MANY]
    recipe = replace(RECIPE, maps=50_000, first_map=0)
    return [*exporting(tmp_path_factory.mktemp("recipe"), recipe), "--workers", "2"]


@pytest.mark.slow
def test_an_error_in_a_worker_is_reported_as_in_the_main_process(tmp_path: Path, failing: list[str | Path]) -> None:
    told = []
    for workers in "13":
        code, err = ended(started_with_small_files(*failing, "--workers", workers, "-o", tmp_path / "a" / "b"))
        told.append((code, the_line(err)))
        assert list(tmp_path.iterdir()) == []
    assert told[0] == told[1]
    assert told[0][0] == 1
    assert "b: cannot be written: File too large; nothing was changed" in told[0][1]


@pytest.mark.slow
@pytest.mark.usefixtures("eager")
def test_workers_cannot_make_a_folder_in_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    command: list[str | Path] = ["generate", *OBSTACLE, "--maps", "4", "--workers", "2", "-o", tmp_path / "file" / "a"]
    assert exit_code(*command) == 2
    assert "file/a: cannot be written: Not a directory" in the_line(capsys.readouterr().err)


def to_it_alone(process: int) -> None:
    os.kill(process, signal.SIGINT)


def to_its_workers_too(process: int) -> None:
    for worker in psutil.Process(process).children(recursive=True):
        worker.send_signal(signal.SIGINT)
    os.kill(process, signal.SIGINT)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("maps", "send"),
    long_unless(
        lambda case: case[0] == 1,
        [(0, to_its_workers_too), (1, to_it_alone), (1, to_its_workers_too), (20, to_it_alone)],
        reason="another moment",
    ),
)
def test_ctrl_c_ends_all_workers_and_leaves_whole_maps(
    tmp_path: Path, many: list[str | Path], send: Callable[[int], None], maps: int
) -> None:
    process = started(*many, "-o", tmp_path / "out")
    until_there(process, tmp_path, 1 if maps == 0 else 0)
    until_there(process, tmp_path / "out", maps)
    workers = psutil.Process(process.pid).children(recursive=True)
    send(process.pid)
    code, err = ended(process)
    assert code == 130
    assert the_line(err).startswith("rsegen: stopped")
    assert not psutil.wait_procs(workers, timeout=PATIENCE)[1]
    made = list(tmp_path.glob("out/*"))
    assert not made or whole_maps_only(tmp_path / "out")
    assert not made or f"stopped; {len(made)} of 50000 maps are complete in {tmp_path / 'out'}; the same command" in err


@pytest.mark.slow
def test_ctrl_c_stops_in_the_middle_of_a_large_map(tmp_path: Path) -> None:
    flags = ["--chunks", "40", "--mesh-type", "multi", "--maps", "20", "--workers", "2"]
    process = started("generate", *OBSTACLE, *flags, "-o", tmp_path / "out")
    until_it_has(process, lambda: list(tmp_path.glob("out/.rsegen/new/*/*.world")))
    to_it_alone(process.pid)
    code, err = ended(process)
    assert code == 130
    assert the_line(err).startswith("rsegen: stopped")
    assert not list(tmp_path.glob("out/.*"))
    assert not (tmp_path / "out").exists() or whole_maps_only(tmp_path / "out")


def long_result(batch: Sequence[int]) -> bytes:
    return bytes(100_000_000 * len(batch))


@pytest.mark.slow
def test_workers_end_in_the_middle_of_long_results() -> None:
    results = execute(long_result, range(40), 10.0, Execution(workers=2))
    assert len(next(results)) == 100_000_000
    workers = [one for one in psutil.Process().children() if "spawn_main" in " ".join(one.cmdline())]
    assert len(workers) >= 2
    results.close()  # while the other worker sends its own: this waited for the rest of it for ever
    assert not any(worker.is_running() for worker in workers)


def half_a_result(batch: Sequence[int]) -> None:
    """In a worker: begin to send a result, and be killed. A few bytes stand for what does not fit into a pipe."""
    frame = sys._getframe()
    while "result_queue" not in frame.f_locals:
        assert frame.f_back is not None
        frame = frame.f_back
    queue = frame.f_locals["result_queue"]
    queue._wlock.acquire()  # as whoever sends has it
    os.write(queue._writer.fileno(), b"\0\0\1\0half")  # of 256 bytes
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="its pipes have messages, which come whole or not at all")
def test_a_worker_that_is_killed_while_it_sends_its_result_is_lost() -> None:
    """The pool's own thread waits for the rest of the result: a run that lost a worker so never ended."""
    with pytest.raises(WorkerLost, match="a worker was lost: it was killed"):
        list(execute(half_a_result, range(2), 10.0, Execution(workers=2)))
    assert not [one for one in psutil.Process().children() if "spawn_main" in " ".join(one.cmdline())]


def with_a_helper(batch: Sequence[int]) -> None:
    """In a worker: as GLFW does when it is imported, which MuJoCo does."""
    helper = "print(1, flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", helper], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as asked:
        assert asked.stdout
        asked.stdout.readline()
        if batch[0]:
            time.sleep(PATIENCE)
        asked.kill()


@pytest.mark.slow
def test_what_a_library_started_in_a_worker_ends_without_a_word(capfd: pytest.CaptureFixture[str]) -> None:
    results = execute(with_a_helper, range(8), 10.0, Execution(workers=2))
    next(results)
    own, end = psutil.Process(), time.monotonic() + PATIENCE
    while not (helpers := [one for one in own.children(recursive=True) if "input()" in " ".join(one.cmdline())]):
        assert time.monotonic() < end
    time.sleep(0.5)  # until it waits for an answer
    results.close()
    assert not psutil.wait_procs(helpers, timeout=PATIENCE)[1]
    assert capfd.readouterr().err == ""


POLITE = 'trap "echo asked >>told; exit 0" INT; echo begun >>told; while :; do sleep 0.05; done'


def end_politely(folders: Sequence[str]) -> list[int]:
    """In a worker: the process that has started and ended servers."""
    for folder in map(Path, folders):
        launch = LaunchCommand(command=("/bin/sh", "-c", POLITE), environment={}, folder=folder)
        with running(launch, subprocess.DEVNULL):
            end = time.monotonic() + PATIENCE
            while not (folder / "told").exists() and time.monotonic() < end:
                time.sleep(0.01)
    return [os.getpid()]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="sessions of processes are POSIX")
def test_a_server_of_a_worker_is_asked_before_it_is_killed(tmp_path: Path) -> None:
    """Workers must not hand on to servers that signals are blocked or ignored: records of drives were cut by it."""
    folders = [tmp_path / name for name in "ab"]
    for folder in folders:
        folder.mkdir()
    processes = execute(end_politely, [*map(str, folders)], 20.0, Execution(workers=2))
    assert os.getpid() not in [one for batch in processes for one in batch]
    assert [(folder / "told").read_text() for folder in folders] == ["begun\nasked\n"] * 2


@pytest.mark.slow
@pytest.mark.parametrize("many", ["generate"], indirect=True)
def test_a_killed_worker_is_reported_and_leaves_nothing(tmp_path: Path, many: list[str | Path]) -> None:
    process = started(*many, "-o", tmp_path / "out")
    until_there(process, tmp_path / "out", 50)
    *_, worker = (one for one in psutil.Process(process.pid).children() if "spawn_main" in " ".join(one.cmdline()))
    worker.kill()
    code, err = ended(process)
    assert (code, the_line(err)) == (
        1,
        "rsegen: a worker was lost: it was killed, or ran out of memory; use fewer workers",
    )
    assert whole_maps_only(tmp_path / "out")


@pytest.mark.slow
@pytest.mark.parametrize("many", ["generate"], indirect=True)
def test_workers_end_in_silence_when_their_parent_is_killed(tmp_path: Path, many: list[str | Path]) -> None:
    process = started(*many, "-o", tmp_path / "out")
    until_there(process, tmp_path / "out", 50)
    workers = psutil.Process(process.pid).children(recursive=True)
    process.kill()
    assert ended(process)[1] == ""
    assert len(workers) >= 2
    assert not psutil.wait_procs(workers, timeout=PATIENCE)[1]


def test_a_signal_while_a_result_is_waited_for_stops_the_run_after_the_look(monkeypatch: pytest.MonkeyPatch) -> None:
    """A KeyboardInterrupt inside of it could leave a lock held, for which the pool's thread would wait for ever."""
    done, looks = Future[int](), []
    done.set_result(3)

    def wait(*given: Any, **named: Any) -> Any:
        stop.ask()
        looks.append(stop.STATE.held)
        return finished(*given, **named)

    monkeypatch.setattr(execute_module, "finished", wait)
    monkeypatch.setattr(stop.STATE, "asked", False)
    with pytest.raises(KeyboardInterrupt):
        execute_module._result(done, lambda: None)
    assert looks == [True]


def test_a_result_that_will_never_come_is_waited_for_until_its_cluster_is_gone() -> None:
    """Dask's executor forgets a result that was on its way when the scheduler ended."""
    looks: list[int] = []

    def check() -> None:
        looks.append(len(looks))
        if len(looks) == 2:
            raise ConnectionError("gone")

    with pytest.raises(ConnectionError, match="gone"):
        execute_module._result(Future[int](), check)
    assert looks == [0, 1]
