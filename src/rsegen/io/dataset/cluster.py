"""Makes the shards of a data set on a Dask cluster: one that is running, or a local one on this machine.

If a worker is lost, another one makes its shard again. Files appear by renaming, so it does no harm if two make it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack
from logging import CRITICAL
from typing import Any, TypeVar

from rsegen.errors import ParameterError, WorkerLost, pip_install
from rsegen.params.extras import CLUSTER
from rsegen.params.plugins import with_plugins

Made = TypeVar("Made")

LOCAL = "local"
PATIENCE = "10s"
"""How long to wait for a scheduler."""


def on_cluster(
    work: Callable[[int], Made], numbers: Sequence[int], *, scheduler: str, workers: int
) -> Generator[Made, None, None]:
    """The result of `work` for each number, in the order in which they are done; scheduler: an address, or `local`."""
    distributed = dask()
    with ExitStack() as opened:
        address: Any = scheduler
        if scheduler == LOCAL:
            cluster = distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=CRITICAL
            )
            address = opened.enter_context(cluster)
        try:
            client = opened.enter_context(distributed.Client(address, timeout=PATIENCE))
        except (OSError, ValueError) as error:
            raise ParameterError("scheduler", f"cannot connect to {scheduler}: {error}") from None
        futures = client.map(with_plugins(work), numbers, pure=False)
        try:
            for future, made in distributed.as_completed(futures, with_results=True):
                yield made
                future.release()  # or it would be made again if the worker that has it is lost
        except distributed.KilledWorker as error:
            raise WorkerLost(f"workers of the cluster were lost, one after the other: {error}") from None


def dask() -> Any:
    """Dask's distributed; a ParameterError that says how to install it, if it is missing."""
    try:
        import distributed
    except ImportError:
        raise ParameterError("scheduler", f"needs Dask: {pip_install([CLUSTER.name])}") from None
    return distributed
