"""Who measures the points of a generation: this process, or some that it starts."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

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
