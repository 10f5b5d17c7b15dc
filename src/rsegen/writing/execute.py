"""Run work on many items here, in worker processes, or on a Dask cluster: results in order, nothing left behind.

A few batches per worker are under way at any time. Workers are started with `spawn` on every system: nothing is
inherited from threads, and no worker keeps another one's pipe open. Signals that stop a run reach this process alone,
which lets the workers end. The result never depends on where, or in what batches, it is made. Cost: half a second per
worker at the start, so a short run stays in this process. What breaks it: a worker that the system kills for want of
memory, which ends the run (WorkerLost).
"""

from __future__ import annotations

import math
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError, Future
from concurrent.futures import wait as finished
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from rsegen.errors import ParameterError, WorkerLost
from rsegen.params.extras import CLUSTER, pip_install
from rsegen.params.plugins import with_plugins
from rsegen.params.sorts import Integer
from rsegen.writing import stop
from rsegen.writing.control_groups import processors

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

WORTHWHILE = 1.0
"""Seconds of work from which on workers gain more than they cost: each takes about half a second to start."""

BATCH = 0.2
"""Seconds of work that a worker is given at once: much more than the giving takes, little enough to see it move."""

AHEAD = 3
"""Batches that each worker gets before the first of them is done, so that none waits for this process.

More of them only keep more results in memory, and go on longer after Ctrl-C.
"""

_SHARES = 4
"""Batches per worker at least, if items are few: the last ones end at about the same time."""

_LOOK = 0.2
"""Seconds between two looks for a signal while a result is waited for: soon after Ctrl-C, at no cost."""

MOST = 61 if sys.platform == "win32" else 1024
"""Workers at most: Windows waits for no more than 63 handles at once."""

LOCAL = "local"
"""The address that stands for a Dask cluster of this machine."""

PATIENCE = "10s"
"""Time to wait for the scheduler of a cluster, as Dask takes it: long enough for one that is just starting."""

WORKERS = Integer(1, help="processes that make maps at the same time")

Item = TypeVar("Item")
Result = TypeVar("Result")

_Submit = Callable[..., Future[Any]]
"""Function that takes work and a batch of items, and promises the result."""


def cores() -> int:
    """Return how many cores this process may use: all of the machine, or fewer in a container or a job."""
    available = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
    return max(1, math.ceil(min(available, processors())))


@dataclass(frozen=True, kw_only=True, slots=True)
class Execution:
    """Workers or cluster of a run, and whether it waits for the disk: options of every command that makes many items.

    workers: processes at the most, if they are quicker   scheduler: the address of a Dask cluster whose workers see the
    same folder, or `local` for one of `workers` processes   sync: wait until the disk has the files
    """

    workers: Annotated[int, WORKERS] = 1
    scheduler: str | None = None
    sync: bool = True

    def __post_init__(self) -> None:
        WORKERS.check("workers", self.workers)
        if self.scheduler is not None:
            dask()


def execute(
    work: Callable[[Sequence[Item]], Result], items: Sequence[Item], seconds: float, execution: Execution
) -> Generator[Result, None, None]:
    """Yield the result of `work` for each batch of items, in their order.

    seconds: about how long one item takes. What `work` raises is raised here; WorkerLost if a worker has died.
    """
    # This process alone if workers would cost more than they gain.
    if items:
        is_short = execution.scheduler is None and len(items) * seconds < WORTHWHILE
        most = 1 if is_short else min(execution.workers, len(items))
        with executor_of(work, seconds, replace(execution, workers=most)) as results:
            yield from results(items)


@contextmanager
def executor_of(
    work: Callable[[Sequence[Item]], Result], seconds: float, execution: Execution
) -> Iterator[Callable[[Sequence[Item]], Iterator[Result]]]:
    """Yield a function that works as `execute`, for many calls: its workers stay until the end.

    The workers are a cluster's if a scheduler is given; with one worker it is this process alone.
    """
    most = min(execution.workers, MOST)
    if execution.scheduler is None and most <= 1:
        yield lambda items: _here(work, _batches(items, seconds, 1))
        return
    opened = _processes(most) if execution.scheduler is None else _cluster(execution.scheduler, most)
    with opened as (submit, workers, check):
        yield lambda items: _in_order(submit, with_plugins(work), _batches(items, seconds, workers), workers, check)


def _here(work: Callable[[Sequence[Item]], Result], batches: Iterator[Sequence[Item]]) -> Iterator[Result]:
    """Yield the results of batches that this process works on."""
    for batch in batches:
        stop.check()
        yield work(batch)


def _batches(items: Sequence[Item], seconds: float, workers: int) -> Iterator[Sequence[Item]]:
    # About `BATCH` seconds each, and with several workers so small that each gets some of few items.
    size = max(1, math.ceil(BATCH / seconds if workers == 1 else min(BATCH / seconds, len(items) / workers / _SHARES)))
    return (items[start : start + size] for start in range(0, len(items), size))


def _in_order(
    submit: _Submit,
    work: Callable[[Sequence[Item]], Result],
    batches: Iterator[Sequence[Item]],
    workers: int,
    check: Callable[[], object],
) -> Iterator[Result]:
    """Yield the results in the order of the batches, of which a few per worker are under way.

    check: called now and then while a result is waited for; it raises where none will come any more
    """
    # The oldest batch is waited for while the next ones are worked on; each result makes room for one batch more.
    waiting = deque(_submitted(submit, work, batch) for batch in islice(batches, AHEAD * workers))
    while waiting:
        yield _result(waiting.popleft(), check)
        waiting.extend(_submitted(submit, work, batch) for batch in islice(batches, 1))


def _submitted(submit: _Submit, work: Callable[[Sequence[Item]], Result], batch: Sequence[Item]) -> Future[Result]:
    with stop.held(), _no_signals_for_new_processes():
        return submit(work, batch)


def _result(future: Future[Result], check: Callable[[], object]) -> Result:
    """Return the result, waited for in small steps, between which a signal stops the run.

    A KeyboardInterrupt inside of `wait` may leave the lock of the future held, for which the pool's thread would wait
    for ever; on Windows Ctrl-C would have no effect there.
    """
    while True:
        with stop.held():
            if finished([future], timeout=_LOOK).done:
                return future.result()
        check()


# Processes of this machine.


@contextmanager
def _processes(workers: int) -> Iterator[tuple[_Submit, int, Callable[[], None]]]:
    """Yield what submits to processes, how many there are, and a check that all still are; at the end none is left."""
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing.connection import wait

    context = multiprocessing.get_context("spawn")
    with stop.held(), _no_signals_for_new_processes():
        _start_tracker()
        receiver, sender = context.Pipe(duplex=False)
        pool = ProcessPoolExecutor(workers, context, _start_worker, (receiver,))

    def check() -> None:
        # A worker that is killed in the middle of a result leaves the pool's thread to wait for the rest of it for
        # ever, and the other workers for their turn to send theirs.
        if wait([worker.sentinel for worker in [*pool._processes.values()]], timeout=0):
            raise BrokenProcessPool

    try:
        yield pool.submit, workers, check
    except BaseException as error:
        sender.close()
        # A worker may end in the middle of a long result. The pool's thread would wait for the rest of it for ever, as
        # this process holds the sending end of that pipe too; once that is closed, it reads the end of the file.
        pool._result_queue._writer.close()  # type: ignore[attr-defined]
        if isinstance(error, BrokenProcessPool):
            raise WorkerLost("a worker was lost: it was killed, or ran out of memory; use fewer workers") from error
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        sender.close()
        receiver.close()


def _start_tracker() -> None:
    """Start Python's process that frees the semaphores of this one and its workers, however they end.

    If this process is killed, it would print on the terminal how many there are, which is of use to nobody.
    """
    if sys.platform == "win32":
        return
    from multiprocessing import resource_tracker

    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = f"{before},{_QUIET}" if before else _QUIET
    try:
        resource_tracker.ensure_running()
    finally:
        if before is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = before


_QUIET = "ignore:resource_tracker:UserWarning"
"""The filter of the warning of multiprocessing/resource_tracker.py, as `python -W` takes it."""

_STOP_SIGNALS = frozenset(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


@contextmanager
def _no_signals_for_new_processes() -> Iterator[None]:
    """Let processes that are started inside be born with the signals blocked that a terminal sends to all."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _STOP_SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_worker(parent_stops: Connection) -> None:
    """Run first in a worker: let signals do nothing, and end it when the process that started it is gone, or stops.

    They are caught, not ignored or blocked, as what a worker starts would inherit that, and could not be ended by them.
    """
    import multiprocessing
    import threading
    from multiprocessing.connection import wait

    import psutil  # noqa: F401  # not when the worker has to end: an import may wait for another one

    def watch() -> None:
        parent = multiprocessing.parent_process()
        wait([parent_stops, *([parent.sentinel] if parent else [])])
        _end_helpers()
        os._exit(1)  # what it was writing is staged, and removed by its parent

    for stop_signal in _STOP_SIGNALS:
        signal.signal(stop_signal, lambda *_: None)
    # They were blocked when the process was born, before it had these handlers.
    if sys.platform != "win32":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _STOP_SIGNALS)
    threading.Thread(target=watch, daemon=True).start()


def _end_helpers() -> None:
    """End what libraries have started in this worker, such as GLFW's look at its version: it would print a traceback.

    Programs that rsegen starts have sessions of their own, which are ended by their watchdogs.
    """
    import psutil

    with suppress(psutil.Error, OSError):
        for child in psutil.Process().children(recursive=True):
            if sys.platform == "win32" or os.getsid(child.pid) == os.getsid(0):
                child.kill()


# A cluster.


@contextmanager
def _cluster(scheduler: str, workers: int) -> Iterator[tuple[_Submit, int, Callable[[], None]]]:
    """Yield what submits to a Dask cluster, how many workers it has, and a check that the cluster is still there.

    A worker that is lost is replaced by another.
    """
    import asyncio

    distributed = dask()
    from logging import CRITICAL

    from distributed.comm.core import CommClosedError

    # Without its scheduler, a client fails at what waits for it, or when it is closed.
    lost = (CancelledError, asyncio.CancelledError, CommClosedError)
    try:
        with ExitStack() as opened:  # closes the client, then our own cluster
            address: Any = scheduler
            if scheduler == LOCAL:
                address = opened.enter_context(
                    distributed.LocalCluster(
                        n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=CRITICAL
                    )
                )
            try:
                client = opened.enter_context(distributed.Client(address, timeout=PATIENCE))
            except (OSError, ValueError) as error:
                raise ParameterError("scheduler", f"cannot connect to {scheduler}: {error}") from None

            def check() -> None:
                # A result that is on its way while the scheduler ends wakes nobody.
                if client.status != "running":
                    raise CommClosedError

            yield partial(_submit_to, client), max(workers, sum(client.ncores().values())), check
    except distributed.KilledWorker as error:
        raise WorkerLost(f"workers of the cluster were lost, one after the other: {error}") from None
    except lost:
        raise WorkerLost(f"the cluster at {scheduler} was lost: its scheduler ended, or is unreachable") from None


def _submit_to(client: Any, work: Callable[[Sequence[Item]], Result], batch: Sequence[Item]) -> Future[Result]:
    """Submit a batch to a cluster.

    Dask's own executor asks for the state of work after its result has come, and takes the result for an error where a
    worker was lost in between.
    """
    # pure=False: Dask would take a second call with the same items for the first one, whose staged files are gone.
    theirs, ours = client.submit(work, batch, pure=False), Future[Result]()

    async def pass_on() -> None:
        try:
            ours.set_result(await theirs)
        except BaseException as error:
            ours.set_exception(error)

    client.loop.add_callback(pass_on)
    return ours


def dask() -> Any:
    """Return Dask's distributed; a ParameterError that says how to install it, if it is missing."""
    try:
        import distributed
    except ImportError:
        raise ParameterError("scheduler", f"needs Dask: {pip_install([CLUSTER.name])}") from None
    return distributed
