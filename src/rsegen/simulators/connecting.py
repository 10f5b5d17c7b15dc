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
    """A connection that is kept: its world, the variables and timeout it was made with, and the process that made it.

    folder: the folder of the map with which `rsegen open` began the simulation, None if something else began it
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
        if not runs:  # the process that wrote it was killed
            with suppress(OSError):
                path.unlink()
            continue
        with suppress(OSError, ValueError, TypeError, KeyError):
            content = json.loads(path.read_text("utf-8"))
            for simulator in simulators:
                if simulator.name == content["simulator"]:
                    announced_address = content["address"]
                    names = (name for name in simulator.address_variables if name in announced_address)
                    address = {name: str(announced_address[name]) for name in names}
                    yield _Place(simulator, address, Path(content["folder"]))


def _places(simulators: Sequence[Simulator]) -> Iterator[_Place]:
    """Yield the places where a simulation may run, in the order in which they are asked."""
    addressed = [
        simulator for simulator in simulators if any(name in os.environ for name in simulator.address_variables)
    ]
    others = [simulator for simulator in simulators if simulator not in addressed]
    opened = list(_announced(simulators))
    for simulator in addressed:
        at_it = (place.folder for place in opened if place.simulator is simulator and _is_set(place.address))
        yield _Place(simulator, folder=next(at_it, None))
    yield from (place for place in opened if place.simulator in others)
    yield from map(_Place, others)


def _is_set(address: Mapping[str, str]) -> bool:
    """Return whether the user's variables say this address, in those of its variables that they set."""
    own = {name: os.environ[name] for name in address if name in os.environ}
    return bool(own) and own.items() <= address.items()


@contextmanager
def connected(name: str | None, timeout: float) -> Iterator[tuple[Simulator, LiveWorld]]:
    """Connect to the running simulator, of that name if given, and its world; NothingRuns if none runs.

    timeout: seconds without an answer after which a server is given up (`Patience`). One thread at a time.
    """
    simulators = list(SIMULATORS.values()) if name is None else [SIMULATORS.named(name, "simulator")]
    with _one_at_a_time:
        # A fork has its parent's connections, which are of no use to it; other variables may mean another server.
        for connection in [_kept[simulator.name] for simulator in simulators if simulator.name in _kept]:
            is_ours = connection.made_with == _made_with(timeout) and connection.process == os.getpid()
            if is_ours and connection.live.is_current:
                break
            _close(connection)  # its server has gone, or is another one
        else:
            connection = _new_connection(simulators, timeout)
        try:
            yield connection.simulator, connection.live
        except BaseException as error:
            if not isinstance(error, UserError):  # a mistake of the user leaves the connection as it was
                _close(connection)
            raise


def opened_folder(simulator: Simulator) -> list[Path]:
    """Return the folder of maps from which `rsegen open` began the connected simulation, if it did."""
    connection = _kept.get(simulator.name)
    return [connection.folder.parent] if connection and connection.folder else []


def _new_connection(simulators: Sequence[Simulator], timeout: float) -> _Connection:
    """Connect to the first simulation that answers, and keep the connection; NothingRuns, with all reasons, if none."""
    # A quick round first, as most simulators do not run; then one with the time that a busy server may need.
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
    """Return the timeout and the variables on which a connection depends."""
    return timeout, {name: value for name, value in os.environ.items() if name.startswith(_PREFIXES)}


def _close(connection: _Connection) -> None:
    """Forget a connection, and close it unless another process, from which this one was forked, has made it."""
    if _kept.get(connection.simulator.name) is connection:
        del _kept[connection.simulator.name]
    if connection.process == os.getpid():
        connection.end.close()


@atexit.register
def _close_all() -> None:
    for connection in list(_kept.values()):
        _close(connection)
