"""The connection to a running simulation that a program keeps, with a simulator that notes who connects."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rsegen.errors import NothingRuns, ParameterError, SimulatorFailed
from rsegen.simulators import connecting
from rsegen.simulators.connecting import connected
from rsegen.simulators.patience import Patience


class Noted:
    """A simulator whose connections are noted, in the order in which they are made and ended."""

    address_variables = ("NOTED_ADDRESS",)

    def __init__(self, name: str) -> None:
        self.name = name
        self.asked: list[str] = []
        self.runs = True
        self.signs: list[float] = []
        self.made: list[SimpleNamespace] = []
        self.ended: list[SimpleNamespace] = []

    @contextmanager
    def connect(self, environment: Mapping[str, str], patience: Patience) -> Iterator[Any]:
        self.signs.append(patience.sign)
        self.asked.append(environment.get("NOTED_ADDRESS", "default"))
        if not self.runs:
            raise NothingRuns(f"{self.name}: nobody")
        self.made.append(SimpleNamespace(is_current=True, seconds=patience.seconds))
        yield self.made[-1]
        self.ended.append(self.made[-1])


@pytest.fixture
def simulators(monkeypatch: pytest.MonkeyPatch) -> tuple[Noted, Noted]:
    """Two simulators, of which both run, and no connection that is kept."""
    both = Noted("newer"), Noted("older")
    monkeypatch.setattr(connecting, "SIMULATORS", {simulator.name: simulator for simulator in both})
    monkeypatch.setattr(connecting, "_kept", {})
    return both


def use(timeout: float = 20.0) -> Any:
    with connected(None, timeout) as (_, live):
        return live


def test_a_connection_is_kept_and_ended_with_the_program(simulators: tuple[Noted, Noted]) -> None:
    assert use() is use() is use()
    newer, _ = simulators
    assert (len(newer.made), newer.ended) == (1, [])
    connecting._close_all()
    assert newer.ended == newer.made
    assert use() is newer.made[1]


@pytest.mark.parametrize("why", ["the server has ended", "another address", "another timeout", "it failed", "stopped"])
def test_another_one_is_made(why: str, simulators: tuple[Noted, Noted], monkeypatch: pytest.MonkeyPatch) -> None:
    first = use()
    if why == "the server has ended":
        first.is_current = False
    elif why == "another address":
        monkeypatch.setenv("GZ_PARTITION", "elsewhere")
    elif why in ("it failed", "stopped"):
        error = SimulatorFailed("lost") if why == "it failed" else KeyboardInterrupt()
        with pytest.raises(type(error)), connected(None, 20.0):
            raise error
        assert simulators[0].ended == [first]
    second = use(5.0 if why == "another timeout" else 20.0)
    assert second is not first
    assert simulators[0].ended == [first]


def test_a_mistake_of_the_user_ends_nothing(simulators: tuple[Noted, Noted]) -> None:
    first = use()
    with pytest.raises(ParameterError), connected(None, 20.0):
        raise ParameterError("name", "exists already")
    assert use() is first


def test_a_copy_in_another_process_is_left_alone(
    simulators: tuple[Noted, Noted], monkeypatch: pytest.MonkeyPatch
) -> None:
    first, other = use(), os.getpid() + 1
    monkeypatch.setattr(os, "getpid", lambda: other)
    assert use() is not first
    assert simulators[0].ended == []


def test_each_is_asked_for_a_moment_and_then_for_a_tenth_of_the_timeout(simulators: tuple[Noted, Noted]) -> None:
    for simulator in simulators:
        simulator.runs = False
    with pytest.raises(NothingRuns, match=r"^no simulation runs \(newer: nobody; older: nobody\); start one"):
        use(timeout=60)
    assert [simulator.signs for simulator in simulators] == [[0.3, 6.0], [0.3, 6.0]]
    simulators[1].runs = True
    assert use() is simulators[1].made[0]


def left_by(process: int, name: str, address: str, folder: Path, state: Path) -> None:
    """Write what `rsegen open` says of a simulation, as another process would have written it."""
    with connecting.announced(Noted(name), {"NOTED_ADDRESS": address}, folder):  # type: ignore[arg-type]
        own = state / f"simulation-{os.getpid()}.json"
        content = own.read_text()
    state.joinpath(f"simulation-{process}.json").write_text(content)


def test_what_was_opened_is_found_before_what_is_at_a_default_address(
    simulators: tuple[Noted, Noted], state_folder: Path, tmp_path: Path
) -> None:
    newer, older = simulators
    left_by(os.getppid(), "older", "opened", tmp_path / "maps" / "one", state_folder)
    left_by(999_999_999, "newer", "of a killed one", tmp_path, state_folder)
    assert use() is older.made[0]
    assert (newer.asked, older.asked) == ([], ["opened"])
    assert connecting.opened_folder(older) == [tmp_path / "maps"]  # type: ignore[arg-type]
    assert [path.name for path in state_folder.iterdir()] == [f"simulation-{os.getppid()}.json"]


def test_an_address_of_the_user_s_own_comes_first(
    simulators: tuple[Noted, Noted], state_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    newer, _ = simulators
    left_by(os.getppid(), "older", "opened", tmp_path, state_folder)
    monkeypatch.setenv("NOTED_ADDRESS", "mine")
    assert use() is newer.made[0]
    assert newer.asked == ["mine"]
    assert connecting.opened_folder(newer) == []  # type: ignore[arg-type]


@pytest.mark.parametrize(("chosen", "folders"), [("first", ["one"]), ("second", ["two"]), ("a third", [])])
def test_the_folder_of_a_simulation_is_known_at_the_address_that_was_printed(
    chosen: str,
    folders: list[str],
    simulators: tuple[Noted, Noted],
    state_folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    newer, _ = simulators
    left_by(os.getppid(), "newer", "first", tmp_path / "one" / "map", state_folder)
    left_by(os.getpid(), "newer", "second", tmp_path / "two" / "map", state_folder)
    monkeypatch.setenv("NOTED_ADDRESS", chosen)
    assert use() is newer.made[0]
    assert newer.asked == [chosen]
    assert connecting.opened_folder(newer) == [tmp_path / name for name in folders]  # type: ignore[arg-type]


@pytest.mark.parametrize("content", ["", "[]", "5", '{"simulator": "older"}', '{"simulator": "older", "address": 5}'])
def test_what_is_no_announcement_is_passed_over(
    content: str, simulators: tuple[Noted, Noted], state_folder: Path
) -> None:
    state_folder.mkdir()
    state_folder.joinpath(f"simulation-{os.getppid()}.json").write_text(content)
    assert use() is simulators[0].made[0]
    assert simulators[0].asked == ["default"]


def test_threads_use_it_one_after_the_other(simulators: tuple[Noted, Noted]) -> None:
    inside: list[int] = []

    def look() -> None:
        with connected(None, 20.0):
            inside.append(1)
            inside.append(-1)

    threads = [threading.Thread(target=look) for _ in range(8)]
    with connected(None, 20.0):
        for thread in threads:
            thread.start()
        assert inside == []
    for thread in threads:
        thread.join()
    assert inside == [1, -1] * 8
    assert len(simulators[0].made) == 1
