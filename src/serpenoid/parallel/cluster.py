"""The same on a Dask cluster: of this machine (`local:8`), or whose scheduler has an address (`tcp://host:8786`).

The scheduler gives the tasks of a worker that died to another one. Workers need this package, in the same version, and
where tasks write files also the same folders.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from serpenoid.errors import InputError
from serpenoid.parallel.local import interrupts_held
from serpenoid.parallel.retry import RETRIES
from serpenoid.version import __version__

if TYPE_CHECKING:
    from distributed import Client

T = TypeVar("T")
LOCAL = "local:"
CONNECT_S = 15


def on_cluster(function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], address: str) -> Iterator[tuple[int, T]]:
    """(index, `function(*task)`) as they are finished."""
    with connected(address) as client:
        from distributed import as_completed
        from distributed.scheduler import KilledWorker

        futures = {client.submit(function, *task, pure=False, retries=RETRIES): i for i, task in enumerate(tasks)}
        try:
            for future in as_completed(list(futures)):
                index = futures.pop(future)
                yield index, future.result()
        except KilledWorker as error:
            raise InputError(f"{address}: {error}. Too little memory? Give each worker more.") from None
        finally:
            client.cancel(list(futures))


@contextmanager
def connected(address: str) -> Iterator[Client]:
    """A client of the cluster, every worker of which has this package."""
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise InputError("--cluster needs Dask: pip install dask distributed.") from None
    for chatty in ("distributed", "distributed.nanny", "distributed.worker"):
        logging.getLogger(chatty).setLevel(logging.ERROR)
    if address.startswith(LOCAL):
        count = _count(address)
        with ExitStack() as held:
            with interrupts_held():  # Dask that is stopped half begun ends in tracebacks
                of_workers = {"threads_per_worker": 1, "processes": True, "dashboard_address": ":0"}
                cluster = held.enter_context(LocalCluster(count, **of_workers))
                client = held.enter_context(Client(cluster))
            yield client
        return
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        raise InputError(f"--cluster {address}: no scheduler answers there ({error}).") from None
    with client:
        _check(client, address)
        yield client


def _count(address: str) -> int:
    text = address.removeprefix(LOCAL)
    if not text.isdigit() or int(text) < 1:
        raise InputError(f"--cluster {address}: write local:N with the number of workers, or a scheduler's address.")
    return int(text)


def _check(client: Client, address: str) -> None:
    """InputError where there are no workers, or one has another version of this package."""
    versions = client.run(_version)
    if not versions:
        raise InputError(f"--cluster {address}: the scheduler has no workers. Start some: dask worker {address}.")
    others = {worker: found for worker, found in versions.items() if found != __version__}
    if others:
        worker, found = next(iter(others.items()))
        raise InputError(
            f"--cluster {address}: worker {worker} has serpenoid {found or 'not at all'}, not {__version__}."
        )


def _version() -> str | None:
    try:
        from serpenoid.version import __version__ as found
    except ImportError:
        return None
    return found
