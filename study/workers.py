"""Workers for the jobs of a study: this process, processes that it starts, or those of a Dask cluster.

Sums of BLAS depend on the number of threads.  So every worker has one thread, and even a single worker is a separate
process: then results are the same, bit for bit, for all workers.
"""

import ctypes
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from typing import Protocol, TypeVar

from tfra import codegen, families, hdl, model, recordings, runtime, study, synth
from tfra.runtime.digest import digest, sources

Job = TypeVar("Job")
Done = TypeVar("Done")

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "POLARS_MAX_THREADS"), "1")
"""Environment variables that NumPy and Polars need when they are loaded."""

_PDEATHSIG = 1
"""Of prctl(2)."""


class Workers(Protocol):
    """Runs jobs in any order: yields the index of each with its result as it arrives.

    The function, the jobs and their results must be picklable.
    """

    def __call__(self, do: Callable[[Job], Done], jobs: Sequence[Job]) -> Iterable[tuple[int, Done]]:
        """Do every one of ``jobs``."""


class SchedulerError(RuntimeError):
    """A cluster can't be used; the message says why in one line."""


class LostWorkerError(RuntimeError):
    """A worker died before its job was finished; the message states so in one line."""


@contextmanager
def processes(count: int) -> Iterator[Workers]:
    """``count`` processes as workers; they end with the block, and with this process however it ends."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, mp_context=context, initializer=_serve, initargs=(os.getpid(),))

    def work(do: Callable[[Job], Done], jobs: Sequence[Job]) -> Iterator[tuple[int, Done]]:
        try:
            yield from _results(pool, do, jobs)
        except BrokenProcessPool:
            raise LostWorkerError("a worker process was killed: is there enough memory?") from None

    try:
        yield work
    except BaseException:  # what they do now is in vain
        for worker in multiprocessing.active_children():
            worker.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _results(pool: Executor, do: Callable[[Job], Done], jobs: Sequence[Job]) -> Iterator[tuple[int, Done]]:
    """Number and result of each job as it arrives; the result is no longer kept then."""
    numbers = {pool.submit(do, job): number for number, job in enumerate(jobs)}
    for future in as_completed(list(numbers)):
        yield numbers.pop(future), future.result()


def _serve(parent: int) -> None:
    """Prepare a worker: it is killed when ``parent`` dies, and leaves Ctrl-C to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    ctypes.CDLL(None, use_errno=True).prctl(_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it died before
        os._exit(1)


@contextmanager
def cluster(address: str, patience: float = 30.0) -> Iterator[Workers]:
    """Workers of the Dask scheduler at ``address``, which have this very package and one thread each.

    Results leave the cluster as they arrive, so a worker that dies loses none.  Raises ``SchedulerError``
    if no scheduler answers within ``patience`` seconds, if it has no workers, or if one of them has other sources or
    settings.
    """
    from distributed import Client, KilledWorker
    from distributed.comm.core import CommClosedError

    try:
        client = Client(address, timeout=patience)  # type: ignore[no-untyped-call]  # Dask has no types
    except (OSError, ValueError) as error:
        raise SchedulerError(f"no Dask scheduler answers at {address}: {str(error).splitlines()[0]}") from None

    def work(do: Callable[[Job], Done], jobs: Sequence[Job]) -> Iterator[tuple[int, Done]]:
        try:
            yield from _results(executor, do, jobs)
        except KilledWorker:
            raise LostWorkerError("a job has killed one worker after the other: is there enough memory?") from None
        except (CancelledError, CommClosedError):
            raise LostWorkerError(f"the Dask scheduler at {address} has gone.") from None

    executor = client.get_executor(pure=False)  # type: ignore[no-untyped-call]  # Dask has no types
    with client:
        identities = client.run(_identity)
        if not identities:
            raise SchedulerError(f"the Dask scheduler at {address} has no workers")
        for worker, (its, threads) in identities.items():
            if its != fingerprint():
                raise SchedulerError(f"the Dask worker {worker} has other sources of tfra")
            if threads != "1":
                raise SchedulerError(f"the Dask worker {worker} may use many threads: start it with OMP_NUM_THREADS=1")
        yield work


def _identity() -> tuple[str, str | None]:
    """State that must be equal for all workers: the sources, and threads of BLAS."""
    return fingerprint(), os.environ.get("OMP_NUM_THREADS")


@cache
def fingerprint() -> str:
    """Version and sources of everything that determines the results."""
    return digest(version("tfra"), *sources(codegen, families, hdl, model, recordings, runtime, study, synth))
