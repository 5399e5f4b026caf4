"""Who measures the points of a generation: this process, some that it starts, or those of a Dask cluster."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager

from distributed import Client
from distributed import as_completed as arrived

from tfra.study.search import Measure, Measured, Workers, one_after_another
from tfra.study.space import Point


def processes(count: int) -> Workers:
    """Workers that are ``count`` processes, started for each generation; one is this process itself."""

    def work(measure: Measure, points: Sequence[Point]) -> Iterator[tuple[int, Measured]]:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(min(count, max(1, len(points))), mp_context=context) as pool:
            places = {pool.submit(measure, point): place for place, point in enumerate(points)}
            try:
                for future in as_completed(places):
                    yield places[future], future.result()
            finally:
                pool.shutdown(wait=False, cancel_futures=True)

    return one_after_another if count == 1 else work


@contextmanager
def cluster(address: str, patience: float = 30.0) -> Iterator[Workers]:
    """Workers of the Dask scheduler at ``address``, which have this package at the same version.

    Results leave the cluster as they come, so that a worker that dies takes none with it.  Raises ``ConnectionError``
    if no scheduler answers within ``patience`` seconds.
    """
    try:
        client = Client(address, timeout=patience)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise ConnectionError(f"no Dask scheduler answers at {address}: {str(error).splitlines()[0]}") from None

    def work(measure: Measure, points: Sequence[Point]) -> Iterator[tuple[int, Measured]]:
        places = {client.submit(measure, point, pure=False): place for place, point in enumerate(points)}
        for future in arrived(list(places)):  # type: ignore[no-untyped-call]
            yield places[future], future.result()
            future.release()

    with client:
        yield work
