"""Dask cluster: a given scheduler, or a local one with a worker a core, and tasks run on either."""

import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from alloc import AllocError
from alloc.errors import NotInstalled

if TYPE_CHECKING:
    from distributed import Client

T = TypeVar("T")

CONNECT_S = 6.0
"""Time for a scheduler to answer [s]."""

JOIN_S = 60.0
"""Time to wait for the first worker [s]."""


class ClusterError(AllocError):
    """A scheduler or its workers are not there, or fail; the message says which and what to do."""


@contextmanager
def cluster(scheduler: str | None, workers: int) -> "Iterator[Client]":
    """A client of the scheduler at an address, or of one on this machine with so many workers.

    Raises NotInstalled without Dask, and ClusterError where no scheduler answers within CONNECT_S.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        raise NotInstalled("Dask is not installed; pip install 'thrustbench[fleet]'") from None

    quiet = {
        "distributed.comm.timeouts.connect": f"{CONNECT_S} s",
        "distributed.logging.distributed": "error",
    }
    with dask.config.set(quiet), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if scheduler is None:
            # Dask never removes its folder of scratch files; it goes with the one around it.
            with (
                tempfile.TemporaryDirectory(prefix="thrustbench-", ignore_cleanup_errors=True) as folder,
                dask.config.set({"temporary-directory": folder}),
                LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    dashboard_address="127.0.0.1:0",
                    silence_logs=50,
                ) as own,
                Client(own) as client,
            ):
                yield client
            return
        try:
            client = Client(scheduler, timeout=CONNECT_S)
        except (OSError, ValueError, ImportError) as error:
            reason = str(error).splitlines()[0][:120] if str(error) else type(error).__name__
            raise ClusterError(
                f"--scheduler {scheduler}: no scheduler answers there ({reason}); 'dask scheduler' starts one"
            ) from None
        with client:
            yield client


def wait_for_workers(client: "Client") -> int:
    """Number of threads that work for this scheduler, once there is one; raises ClusterError after JOIN_S."""
    try:
        client.wait_for_workers(1, timeout=JOIN_S)
    except TimeoutError:
        address = client.scheduler.address if client.scheduler else "?"
        raise ClusterError(
            f"no worker joined {address} within {JOIN_S:g} s; start some with 'dask worker {address}'"
        ) from None
    return threads(client)


def threads(client: "Client") -> int:
    """Number of threads that work for the scheduler now."""
    return sum(client.nthreads().values())


def list_workers(client: "Client") -> dict[str, dict[str, Any]]:
    """Workers known to the scheduler, by their addresses.

    The scheduler itself is asked: ``scheduler_info`` may give what a refresh in the background left, which
    names no workers.
    """
    assert client.scheduler is not None, "the client is connected"
    identity: dict[str, dict[str, dict[str, Any]]] = client.sync(client.scheduler.identity, n_workers=-1)
    return identity["workers"]


def run_all(
    client: "Client", function: Callable[..., bytes], tasks: Sequence[T], *common: object
) -> Iterator[tuple[T, bytes]]:
    """Results of ``function(task's arguments)`` for each task, in the order in which they end.

    A few tasks for each thread are under way at any time, so neither side holds more than those. Dask gives
    the tasks of a worker that dies to others, and gives up on a task that has taken four workers with it.
    """
    from distributed import as_completed

    waiting = iter(tasks)
    of = {}

    def submit() -> bool:
        task = next(waiting, None)
        if task is None:
            return False
        future = client.submit(function, *common[:1], task, *common[1:], pure=False)
        of[future.key] = task
        running.add(future)
        return True

    running = as_completed(with_results=False)
    for _ in range(2 * max(threads(client), 1) + 2):
        submit()
    for future in running:
        task = of.pop(future.key)
        if future.status != "finished":
            raise ClusterError(_why(future))
        data = future.result()
        future.release()
        while len(of) < 2 * max(threads(client), 1) + 2 and submit():
            pass
        yield task, data


def _why(future: object) -> str:
    """Reason for a task's failure, in a line."""
    error = future.exception() if getattr(future, "status", "") == "error" else None  # type: ignore[attr-defined]
    if error is None:
        return "the scheduler has gone; start it again and go on with --resume"
    said = (str(error).splitlines() or [""])[0][:160]
    if isinstance(error, ModuleNotFoundError):
        return f"a worker lacks a package ({said}); pip install 'thrustbench[layouts]' there, then --resume"
    return f"a worker failed: {type(error).__name__}: {said}; mend that, then --resume"
