"""The trials of `make crash` find what is lost: a kill, a full disk, a power failure, a unit that is half written."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.crash.commands import made_inputs
from tests.crash.injection import MODES, Injection, compiled, missing
from tests.crash.judging import End, differences, left_hidden, neither_old_nor_new, tree, visible, wrong_end
from tests.crash.server import Server
from tests.crash.trials import RUN_BY_NAME, cut_power, undisturbed

SMALL = RUN_BY_NAME["generate"]
_WRITE = 15
"""A call that opens a file in the folder of staged files: without it there is no map."""
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(missing()), reason=missing() or "nothing is missing"),
]


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    folder = tmp_path_factory.mktemp("crash")
    with Server(folder / "server", folder / "control", compiled(folder), made_inputs(folder / "inputs")) as server:
        yield server


@pytest.fixture
def root(server: Server, tmp_path: Path) -> Path:
    """The folder in which the server runs commands, with what one has made in `out`."""
    undisturbed(SMALL, server, tmp_path / "before", shared=False)
    return server.root


def test_the_calls_of_a_run_are_the_same_every_time(server: Server, tmp_path: Path) -> None:
    first, second = (undisturbed(SMALL, server, tmp_path / name, shared=True) for name in "ab")
    assert first.calls == second.calls > 50
    assert first.whole == second.whole


def test_the_calls_of_workers_are_counted(server: Server, root: Path) -> None:
    assert server.run([*RUN_BY_NAME["generate, workers"].command[:-1], "new"]).by_workers > 10


@pytest.mark.parametrize("mode", [mode for mode in MODES if mode not in ("count", "stop", "interrupt")])
def test_an_injected_call_fails_as_requested(server: Server, root: Path, mode: str) -> None:
    command = [*SMALL.command[:-1], "new"]
    end = server.run(command, Injection(mode=mode, k=_WRITE, error=errno.EIO))
    assert bool(end.signal) == mode.startswith("kill")
    assert end.code != 0
    assert end.call
    if mode in ("full", "fail", "short"):
        assert {"full": "No space", "fail": "Input/output", "short": "Input/output"}[mode] in end.err


def test_a_stopped_run_goes_on(server: Server, root: Path) -> None:
    end = server.run([*SMALL.command[:-1], "new"], Injection(mode="stop", k=20))
    assert end.stopped
    assert server.second(["--version"]).code == 0
    assert server.go_on().code == 0


def test_unsynced_data_is_lost_in_a_power_failure(server: Server, root: Path) -> None:
    for more, loses in ([], False), (["--no-sync"], True):
        output = root / f"new{loses}"
        calls = server.run([*SMALL.command[:-1], f"dry{loses}", *more]).calls
        end = server.run([*SMALL.command[:-1], output.name, *more], Injection(mode="kill", k=calls, power=True))
        cut_power(root, end)
        assert end.signal
        assert any(not path.stat().st_size for path in output.rglob("*.csv")) == loses


@pytest.mark.long(reason="each call of a run is killed")
def test_maps_are_old_or_new_after_a_kill_at_any_call_of_a_disk_that_cannot_exchange(
    server: Server, tmp_path: Path
) -> None:
    generate = ["generate", "peak", "--maps", "2", "--workers", "1", "-o", "out"]
    replaced, before = [*generate, "--seed", "2", "--force"], tmp_path / "before"
    shutil.rmtree(server.trial, ignore_errors=True)
    server.root.mkdir(parents=True)
    assert server.run([*generate, "--seed", "1", "--formats", "arrays"]).code == 0
    shutil.copytree(server.trial, before)
    try:
        server.lacks = {"no_exchange": errno.EINVAL}
        calls, whole, aside = server.run(replaced).calls, visible(tree(server.trial)), 0
        for k in range(1, calls + 1):
            shutil.rmtree(server.trial)
            shutil.copytree(before, server.trial)
            assert server.run(replaced, Injection(mode="kill", k=k)).signal
            is_aside = any(not (server.root / "out" / f"peak_000{number}").exists() for number in range(2))
            assert server.run(["info", "out", "--verify"]).code == is_aside
            assert server.run(replaced).code == 0
            now = tree(server.trial)
            assert differences(visible(now), whole) == left_hidden(now) == []
            aside += is_aside
    finally:
        server.lacks = {}
    assert aside == 2


def test_half_of_a_unit_and_a_false_message_are_found(tmp_path: Path) -> None:
    states = {}
    for state in ("old", "new", "now"):
        unit = tmp_path / state / "root" / "out" / "rse_0000"
        unit.mkdir(parents=True)
        for i, name in enumerate("ab"):
            (unit / name).write_text("new" if state == "now" and i else state)
        states[state] = tree(tmp_path / state)
    old, new, now = ({path[5:]: file for path, file in found.items()} for found in states.values())
    assert not list(neither_old_nor_new(old, old, new, 1))
    assert not list(neither_old_nor_new(new, old, new, 1))
    assert len(list(neither_old_nor_new(now, old, new, 1))) == 1
    end = End(code=1, signal=0, stopped=False, err="rsegen: out: cannot be written: no space; nothing was left there\n")
    assert not list(wrong_end(end, states["old"], states["old"], states["new"], interrupted=False))
    assert "false" in next(wrong_end(end, states["old"], states["now"], states["new"], interrupted=False))
