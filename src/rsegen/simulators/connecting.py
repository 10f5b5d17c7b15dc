r"""The running simulation at the address in the user's variables, and the connection to it that a program keeps.

    rsegen.spawn, respawn, remove --> connected --> the kept connection, while its server is still there
                                          \-------> else a new one: simulator after simulator is asked, at its address

Idea: one client for each server and program, closed when the program ends. Gazebo Classic's master keeps some sockets
of every client that ever was, and a server of Gazebo Sim may lose its first response to a new one; so a program that
spawns all night must not connect each time. Cost: a kept connection to Gazebo Classic gets five messages a second, one
to Gazebo Sim seventy, which nobody decodes; a call takes 0.1 s to see that its server is the only one. What breaks it:
a call that fails leaves a connection in a state that nobody knows; it is closed, and the next call begins anew.
"""

from __future__ import annotations

import atexit
import os
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from rsegen.errors import NothingRuns, UserError
from rsegen.simulators.base import SIMULATORS, Simulator
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.patience import Patience

_FIRST, _SECOND = 0.3, 0.1
"""Seconds in which a running server must answer when each simulator is asked at first, as most do not run; then the
share of the timeout."""

_PREFIXES = ("GZ_", "IGN_", "GAZEBO_")
"""Beginnings of the variables that say where a server is, and how to speak with it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Connection:
    """A connection that is kept: its world, and what it was made with, by which process."""

    simulator: Simulator
    live: LiveWorld
    end: ExitStack
    made_with: object
    process: int


_kept: dict[str, _Connection] = {}
_one_at_a_time = threading.RLock()


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


def _new_connection(simulators: Sequence[Simulator], timeout: float) -> _Connection:
    reasons: list[str] = []
    for sign in (_FIRST, max(_FIRST, _SECOND * timeout)):
        reasons.clear()
        for simulator in simulators:
            end = ExitStack()
            try:
                live = end.enter_context(simulator.connect(os.environ, Patience(seconds=timeout, sign=sign)))
            except NothingRuns as error:
                reasons.append(str(error))
                continue
            _kept[simulator.name] = _Connection(
                simulator=simulator, live=live, end=end, made_with=_made_with(timeout), process=os.getpid()
            )
            return _kept[simulator.name]
    raise NothingRuns(f"no simulation runs ({'; '.join(reasons)}); start one, as with rsegen.open('DIR', shared=True)")


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
