r"""The running simulation, and the connection to it that a program keeps.

    rsegen.spawn, respawn, remove --> connected --> the kept connection, while its server is still there
                                          \-------> else a new one, to the first that answers:
                                                    at the address in the user's variables, if they have one;
                                                    what `rsegen open` began and has not ended, the newest first;
                                                    simulator after simulator at its default address

`rsegen open` gives each server an address of its own, so that none disturbs another. It announces it in a file of the
user's state folder as long as it runs, so the next shell finds it without a flag.

Idea of keeping: one client for each server and program, closed when the program ends. Gazebo Classic's master keeps
some sockets of every client that ever was, and a server of Gazebo Sim may lose its first response to a new one; so a
program that spawns all night must not connect each time. Cost: a kept connection to Gazebo Classic gets five messages a
second, one to Gazebo Sim seventy, which nobody decodes; a call takes 0.1 s to see that its server is the only one. What
breaks it: a call that fails leaves a connection in a state that nobody knows; it is closed, and the next call begins
anew.
"""

from __future__ import annotations

import atexit
import json
import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from rsegen.errors import NothingRuns, UserError
from rsegen.simulators.base import SIMULATORS, Simulator
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.patience import Patience
from rsegen.writing.user_state import state_file, state_files, write_state

_FIRST, _SECOND = 0.3, 0.1
"""Seconds in which a running server must answer when each simulator is asked at first, as most do not run; then the
share of the timeout."""

_PREFIXES = ("GZ_", "IGN_", "GAZEBO_")
"""Beginnings of the variables that say where a server is, and how to speak with it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Connection:
    """A connection that is kept: its world, and what it was made with, by which process.

    folder: that of the map that `rsegen open` began it with
    """

    simulator: Simulator
    live: LiveWorld
    end: ExitStack
    folder: Path | None
    made_with: object
    process: int


_kept: dict[str, _Connection] = {}
_one_at_a_time = threading.RLock()


_ANNOUNCED = "simulation"
"""The name under which `rsegen open` announces where its server is."""


@contextmanager
def announced(simulator: Simulator, address: Mapping[str, str], folder: Path) -> Iterator[None]:
    """Let other processes of the user find a server at an address, variables of its simulator, and its map's folder."""
    content = {"simulator": simulator.name, "address": dict(address), "folder": str(folder.resolve())}
    try:
        write_state(_ANNOUNCED, content)
    except OSError:  # on a disk that is full or cannot be written to it is found by its variables alone
        yield
        return
    try:
        yield
    finally:
        with suppress(OSError):
            state_file(_ANNOUNCED).unlink()


class _Place(NamedTuple):
    """Place where a simulation may run: the variables of its address, and the folder of the map that it began with."""

    simulator: Simulator
    address: Mapping[str, str] = MappingProxyType({})
    folder: Path | None = None


def _announced(simulators: Sequence[Simulator]) -> Iterator[_Place]:
    """Yield the simulations that `rsegen open` runs, the newest first."""
    for path, runs in state_files(_ANNOUNCED):
        if not runs:
            with suppress(OSError):
                path.unlink()
            continue
        with suppress(OSError, ValueError, TypeError, KeyError):
            content = json.loads(path.read_text("utf-8"))
            for simulator in simulators:
                if simulator.name == content["simulator"]:
                    given = content["address"]
                    own = {name: str(given[name]) for name in simulator.address_variables if name in given}
                    yield _Place(simulator, own, Path(content["folder"]))


def _places(simulators: Sequence[Simulator]) -> Iterator[_Place]:
    """Yield where a simulation may run, in the order in which it is asked."""
    named = [each for each in simulators if any(name in os.environ for name in each.address_variables)]
    yield from map(_Place, named)
    yield from _announced([each for each in simulators if each not in named])
    yield from (_Place(each) for each in simulators if each not in named)


@contextmanager
def connected(name: str | None, timeout: float) -> Iterator[tuple[Simulator, LiveWorld]]:
    """Connect to the running simulator, of that name if given, and its world; NothingRuns if none runs.

    timeout: seconds without an answer after which a server is given up (`Patience`). One thread at a time.
    """
    simulators = list(SIMULATORS.values()) if name is None else [SIMULATORS.named(name, "simulator")]
    with _one_at_a_time:
        for kept in [_kept[simulator.name] for simulator in simulators if simulator.name in _kept]:
            if kept.made_with == _made_with(timeout) and kept.process == os.getpid() and kept.live.is_current:
                connection = kept
                break
            _close(kept)  # its server has gone, or is another one
        else:
            connection = _new_connection(simulators, timeout)
        try:
            yield connection.simulator, connection.live
        except BaseException as error:
            if not isinstance(error, UserError):
                _close(connection)
            raise


def opened_folder(simulator: Simulator) -> list[Path]:
    """Return the folder of the maps with one of which `rsegen open` began the connected simulation, if it did."""
    kept = _kept.get(simulator.name)
    return [kept.folder.parent] if kept and kept.folder else []


def _new_connection(simulators: Sequence[Simulator], timeout: float) -> _Connection:
    reasons: list[str] = []
    for sign in (_FIRST, max(_FIRST, _SECOND * timeout)):
        reasons.clear()
        for simulator, address, folder in _places(simulators):
            end = ExitStack()
            try:
                variables = os.environ | dict(address)
                live = end.enter_context(simulator.connect(variables, Patience(seconds=timeout, sign=sign)))
            except NothingRuns as error:
                reasons.append(str(error))
                continue
            _kept[simulator.name] = _Connection(
                simulator=simulator,
                live=live,
                end=end,
                folder=folder,
                made_with=_made_with(timeout),
                process=os.getpid(),
            )
            return _kept[simulator.name]
    raise NothingRuns(f"no simulation runs ({'; '.join(reasons)}); start one, for example with rsegen.open('DIR')")


def _made_with(timeout: float) -> object:
    """Return what a connection depends on."""
    return timeout, {name: value for name, value in os.environ.items() if name.startswith(_PREFIXES)}


def _close(connection: _Connection) -> None:
    """Close a connection, or leave it alone if it is a copy of that of another process."""
    if _kept.get(connection.simulator.name) is connection:
        del _kept[connection.simulator.name]
    if connection.process == os.getpid():
        connection.end.close()


@atexit.register
def _close_all() -> None:
    for connection in list(_kept.values()):
        _close(connection)
