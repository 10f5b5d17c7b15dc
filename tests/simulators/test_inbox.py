"""Messages that are kept, and decoded when somebody looks at them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from threading import Timer
from typing import Any

import pytest

from rsegen.errors import SimulatorFailed
from rsegen.simulators.inbox import Inbox
from rsegen.simulators.patience import Patience
from rsegen.simulators.wire import SIM

SHORT = Patience(seconds=0.05)
CLOCK = {"iterations": 3}


def decoding(name: str, content: bytes) -> Callable[[], dict[str, Any]]:
    return partial(SIM.decode, name, content)


def test_a_message_of_zeros_alone_is_a_message_and_one_that_is_none_is_passed_over() -> None:
    inbox = Inbox("Gazebo Sim", SHORT)
    for content in (SIM.encode("WorldStatistics", CLOCK), b"", b"\xff"):
        inbox.add("stats", decoding("WorldStatistics", content))
    assert inbox.messages("stats") == [CLOCK, {}]
    assert inbox.last("stats") == {}
    assert inbox.wait_for_message("stats", lambda clock: clock["iterations"] > 1) == CLOCK
    assert inbox.wait_for_message("stats", lambda _: True) == {}


def test_nobody_decodes_what_nobody_looks_at() -> None:
    inbox = Inbox("Gazebo Sim", SHORT)
    inbox.add("poses", lambda: pytest.fail("was decoded"))
    inbox.add("stats", decoding("WorldStatistics", b""))
    assert inbox.messages("stats") == [{}]


def test_waiting_ends_with_patience_or_with_the_server() -> None:
    inbox = Inbox("Gazebo Sim", SHORT)
    with pytest.raises(SimulatorFailed, match=r"^Gazebo Sim: no message on stats within 0.05 s$"):
        inbox.wait_for_message("stats", lambda _: True)
    inbox.fail("the server has ended")
    inbox.patience = Patience()
    with pytest.raises(SimulatorFailed, match=r"^Gazebo Sim: the server has ended$"):
        inbox.wait_for_message("stats", lambda _: True)


def test_a_count_is_waited_for_as_long_as_it_grows() -> None:
    def send(*counts: int) -> None:
        for count in counts:
            inbox.add("stats", decoding("WorldStatistics", SIM.encode("WorldStatistics", {"iterations": count})))

    def iterations(clock: Mapping[str, Any]) -> int:
        return int(clock["iterations"])

    inbox = Inbox("Gazebo Sim", Patience())
    send(1)
    later = Timer(0.05, send, (5, 12))
    later.start()
    assert inbox.wait_until("stats", iterations, 12) == {"iterations": 12}
    later.join()
    inbox.patience = SHORT
    with pytest.raises(SimulatorFailed, match=r"^Gazebo Sim: no message on stats within 0.05 s$"):
        inbox.wait_until("stats", iterations, 13)
