"""Work shared out among processes: in order, a few batches ahead, stopped without a mess.

Workers are started anew (spawn) on every system and version of Python: nothing is inherited from threads, and no worker
holds a pipe that tells another one of its end. They hear of Ctrl-C from this process alone, wherever it was sent to.
"""

from __future__ import annotations

import _thread
import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures import wait as finished
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from itertools import islice
from multiprocessing.connection import Connection, wait
from typing import NoReturn, TypeVar

from rsegen.errors import WorkerLost
from rsegen.params.plugins import with_plugins

Item = TypeVar("Item")
Made = TypeVar("Made")

AHEAD = 3
"""Batches that are given out for each worker before the first of them is done."""

MOST = 61 if sys.platform == "win32" else 1024
"""Windows waits for no more than 63 things at once."""

_STOPS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1


def shared_out(
    work: Callable[[Sequence[Item]], Sequence[Made]], items: Iterable[Item], *, batch: int, workers: int
) -> Iterator[Made]:
    """What `work` makes of the items, in their order, `batch` of them at a time, each in one of the workers.

    What it raises is raised here; WorkerLost where a worker has ended. However this ends, no worker is left.
    """
    context = multiprocessing.get_context("spawn")
    told, tell = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(min(workers, MOST), context, _begin, (told,))
    try:
        yield from _in_order(
            partial(_submit, pool, partial(_undisturbed, with_plugins(work))), _batches(items, batch), workers
        )
    except BrokenProcessPool as error:
        raise WorkerLost("a worker was lost: it was killed, or ran out of memory; give fewer --workers") from error
    finally:
        tell.close()
        pool.shutdown(cancel_futures=True)
        told.close()


def _batches(items: Iterable[Item], batch: int) -> Iterator[tuple[Item, ...]]:
    rest = iter(items)
    return iter(lambda: tuple(islice(rest, batch)), ())


def _in_order(
    submit: Callable[[Sequence[Item]], Future[Sequence[Made]]], batches: Iterator[Sequence[Item]], workers: int
) -> Iterator[Made]:
    waiting = deque(map(submit, islice(batches, AHEAD * workers)))
    while waiting:
        yield from _result(waiting.popleft())
        waiting.extend(map(submit, islice(batches, 1)))


def _result(future: Future[Sequence[Made]]) -> Sequence[Made]:
    """Waits in small steps: on Windows nothing else lets Ctrl-C through."""
    while not finished([future], timeout=0.2).done:
        continue
    return future.result()


def _submit(
    pool: ProcessPoolExecutor, work: Callable[[Sequence[Item]], Sequence[Made]], batch: Sequence[Item]
) -> Future[Sequence[Made]]:
    with _unhurried(), _deaf():
        return pool.submit(work, batch)


@contextmanager
def _deaf() -> Iterator[None]:
    """What is started here hears no Ctrl-C, from its first instant on."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _unhurried() -> Iterator[None]:
    """Signals wait until this is over: a worker that is half started would complain.

    A mask would not do: threads of numerical libraries have none, and what they hear Python takes for its own.
    """
    here = threading.current_thread() is threading.main_thread()
    handlers = {each: signal.getsignal(each) for each in _STOPS if here}
    handlers = {each: handler for each, handler in handlers.items() if handler not in (signal.SIG_IGN, None)}
    heard: list[int] = []
    try:
        for each in handlers:
            signal.signal(each, lambda signal_, frame: heard.append(signal_))
        yield
    finally:
        for each, handler in handlers.items():
            signal.signal(each, handler)
        for each in heard[:1]:
            signal.raise_signal(each)


# In a worker.


def _begin(told: Connection) -> None:
    """A worker's first act: be deaf to Ctrl-C, and listen to the one who gives the work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_listen, args=(told,), daemon=True).start()


def _listen(told: Connection) -> None:
    """Where work is to stop, interrupt all that is still begun; where nobody is left to want it, end at once."""
    parent = multiprocessing.parent_process()
    gone = [parent.sentinel] if parent else []
    wait([told, *gone])
    while not wait(gone, 0.02):
        _thread.interrupt_main(signal.SIGINT)
    os._exit(1)


def _undisturbed(work: Callable[[Sequence[Item]], Sequence[Made]], batch: Sequence[Item]) -> Sequence[Made]:
    """The work, which may be interrupted once; what is around it, and its clearing up, may not."""

    def stop(signal_: int, frame: object) -> NoReturn:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, stop)
    try:
        return work(batch)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
