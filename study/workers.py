"""Who does the jobs of a study: this process, some that it starts, or those of a Dask cluster.

Sums of BLAS depend on how many threads share them.  So all workers have one thread each, and even a single one is a
process of its own: then results are the same, bit for bit, whoever makes them.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from typing import Protocol, TypeVar

Job = TypeVar("Job")
Done = TypeVar("Done")

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "POLARS_MAX_THREADS"), "1"
)
"""What NumPy and Polars must find in the environment when they are loaded."""


class Workers(Protocol):
    """Does jobs in any order: yields the place of each with its result, as they come.

    What is done, the jobs and their results travel between processes.
    """

    def __call__(self, do: Callable[[Job], Done], jobs: Sequence[Job]) -> Iterable[tuple[int, Done]]:
        """Do every one of ``jobs``."""


def one_after_another(do: Callable[[Job], Done], jobs: Sequence[Job]) -> Iterator[tuple[int, Done]]:
    """Workers that are this process."""
    for place, job in enumerate(jobs):
        yield place, do(job)


@contextmanager
def processes(count: int) -> Iterator[Workers]:
    """Workers that are ``count`` processes; they end with the block."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, mp_context=context)

    def work(do: Callable[[Job], Done], jobs: Sequence[Job]) -> Iterator[tuple[int, Done]]:
        places = {pool.submit(do, job): place for place, job in enumerate(jobs)}
        for future in as_completed(places):
            yield places[future], future.result()

    try:
        yield work
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def cluster(address: str, patience: float = 30.0) -> Iterator[Workers]:
    """Workers of the Dask scheduler at ``address``, which have this package at the same version and one thread each.

    Results leave the cluster as they come, so that a worker that dies takes none with it.  Raises ``ConnectionError``
    if no scheduler answers within ``patience`` seconds.
    """
    from distributed import Client
    from distributed import as_completed as arrived

    try:
        client = Client(address, timeout=patience)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise ConnectionError(f"no Dask scheduler answers at {address}: {str(error).splitlines()[0]}") from None

    def work(do: Callable[[Job], Done], jobs: Sequence[Job]) -> Iterator[tuple[int, Done]]:
        places = {client.submit(do, job, pure=False): place for place, job in enumerate(jobs)}
        for future in arrived(list(places)):  # type: ignore[no-untyped-call]
            yield places[future], future.result()
            future.release()

    with client:
        yield work
