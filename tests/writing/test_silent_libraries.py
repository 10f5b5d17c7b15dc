"""Silence of libraries ends with the reading: in any number of threads, the process has its own stderr again."""

from __future__ import annotations

import os
import sys
import warnings
from threading import Event, Thread

import pytest

from rsegen.input_files import silent_libraries


def test_stderr_and_warnings_are_back_after_two_threads_whose_reading_overlaps() -> None:
    stderr, filters = os.fstat(2), list(warnings.filters)
    is_inside, may_end = Event(), Event()

    def read_longer() -> None:
        with silent_libraries():
            is_inside.set()
            may_end.wait(10)

    thread = Thread(target=read_longer)
    with silent_libraries():
        thread.start()
        is_inside.wait(0.2)  # in vain: the other thread waits for this one
    may_end.set()
    thread.join()
    assert os.path.samestat(os.fstat(2), stderr)
    assert warnings.filters == filters


def test_reading_inside_reading_is_silent_and_waits_for_nobody() -> None:
    stderr = os.fstat(2)
    with silent_libraries(), silent_libraries():
        assert os.path.samestat(os.fstat(2), os.stat(os.devnull))
    assert os.path.samestat(os.fstat(2), stderr)


@pytest.mark.skipif(sys.platform == "win32", reason="no forks")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_child_that_is_forked_while_a_thread_reads_has_stderr_and_reads_too() -> None:
    stderr, is_inside = os.fstat(2), Event()

    def read_longer() -> None:
        with silent_libraries():
            is_inside.set()
            Event().wait(0.2)

    thread = Thread(target=read_longer)
    thread.start()
    is_inside.wait()
    child = os.fork()
    if not child:
        is_right = os.path.samestat(os.fstat(2), stderr)
        other = Thread(target=lambda: silent_libraries().__enter__(), daemon=True)  # it waits for ever at worst
        other.start()
        other.join(5)
        os._exit(0 if is_right and not other.is_alive() else 1)
    thread.join()
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
