"""Runs work in several processes: results in order, a few batches ahead, nothing left behind when it is stopped.

Workers are started with `spawn` on every system and version of Python: nothing is inherited from threads, and no worker
keeps another one's pipe open. Only this process handles Ctrl-C; it then tells the workers to stop.
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
"""Batches that each worker gets before the first of them is done."""

MOST = 61 if sys.platform == "win32" else 1024
"""Workers at most: Windows waits for no more than 63 handles at once."""

_STOP_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


def run_in_workers(
    work: Callable[[Sequence[Item]], Sequence[Made]], items: Iterable[Item], *, batch: int, workers: int
) -> Iterator[Made]:
    """The results of `work` for the items, in their order, `batch` items at a time in one of the workers.

    What it raises is raised here; WorkerLost if a worker has died. However this ends, no worker is left.
    """
    context = multiprocessing.get_context("spawn")
    stop_receiver, stop_sender = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(min(workers, MOST), context, _start_worker, (stop_receiver,))
    try:
        submit = partial(_submit, pool, partial(_interruptible, with_plugins(work)))
        yield from _in_order(submit, _batches(items, batch), workers)
    except BrokenProcessPool as error:
        raise WorkerLost("a worker was lost: it was killed, or ran out of memory; give fewer --workers") from error
    finally:
        stop_sender.close()
        pool.shutdown(cancel_futures=True)
        stop_receiver.close()


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
    """The result, waited for in small steps: otherwise Ctrl-C would have no effect on Windows."""
    while not finished([future], timeout=0.2).done:
        continue
    return future.result()


def _submit(
    pool: ProcessPoolExecutor, work: Callable[[Sequence[Item]], Sequence[Made]], batch: Sequence[Item]
) -> Future[Sequence[Made]]:
    with _defer_signals(), _block_sigint():
        return pool.submit(work, batch)


@contextmanager
def _block_sigint() -> Iterator[None]:
    """Processes that are started here never receive SIGINT."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _defer_signals() -> Iterator[None]:
    """Handles signals only afterwards: a worker that is still starting would print an error.

    A signal mask is not enough: threads of numerical libraries have none, and Python handles what they receive.
    """
    here = threading.current_thread() is threading.main_thread()
    handlers = {each: signal.getsignal(each) for each in _STOP_SIGNALS if here}
    handlers = {each: handler for each, handler in handlers.items() if handler not in (signal.SIG_IGN, None)}
    received: list[int] = []
    try:
        for each in handlers:
            signal.signal(each, lambda signal_, frame: received.append(signal_))
        yield
    finally:
        for each, handler in handlers.items():
            signal.signal(each, handler)
        for each in received[:1]:
            signal.raise_signal(each)


# In a worker.


def _start_worker(stop: Connection) -> None:
    """Runs first in a worker: ignore SIGINT, and watch the process that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_watch_parent, args=(stop,), daemon=True).start()


def _watch_parent(stop: Connection) -> None:
    """When the pipe is closed, interrupt the work; when the parent process is gone, end at once."""
    parent = multiprocessing.parent_process()
    gone = [parent.sentinel] if parent else []
    wait([stop, *gone])
    while not wait(gone, 0.02):
        _thread.interrupt_main(signal.SIGINT)
    os._exit(1)


def _interruptible(work: Callable[[Sequence[Item]], Sequence[Made]], batch: Sequence[Item]) -> Sequence[Made]:
    """The result of the work, which may be interrupted once; its cleaning up may not."""

    def stop(signal_: int, frame: object) -> NoReturn:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, stop)
    try:
        return work(batch)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
