"""A Dask cluster measures what one process does, even if a worker dies."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster

from tests.study.search.test_search import SEARCH, measure, run
from tfra.study.search.search import Measured
from tfra.study.search.space import Point
from tfra.study.search.trials import Trials, sqlite
from tfra.study.workers import ONE_THREAD, SchedulerError, cluster, processes


@pytest.fixture
def two() -> Iterator[Any]:
    """A scheduler and two workers, processes each."""
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit=None
    ) as found:
        yield found


def threads(name: str) -> str | None:
    return os.environ.get(name)


@pytest.mark.parametrize("count", [1, 2])
def test_processes_have_one_thread_and_no_other_process_does(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("POLARS_MAX_THREADS", raising=False)
    with processes(count) as workers:
        found = dict(workers(threads, list(ONE_THREAD)))
        assert found == dict.fromkeys(range(len(ONE_THREAD)), "1")
        assert dict(workers(threads, ["OMP_NUM_THREADS"])) == {0: "1"}
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "POLARS_MAX_THREADS" not in os.environ


def test_what_goes_wrong_in_a_process_comes_out() -> None:
    with pytest.raises(ZeroDivisionError), processes(1) as workers:
        list(workers(divide, [1, 0]))


def divide(number: int) -> float:
    return 1 / number


def slow(point: Point) -> Measured:
    time.sleep(0.05)
    return measure(point)


@pytest.mark.long
def test_a_worker_may_die(tmp_path: Path, two: Any) -> None:
    """The trials are those of one process, and none is stored twice."""
    trials = Trials(sqlite(tmp_path / "trials.db"), "search")
    seen = []
    with cluster(two.scheduler_address) as workers:
        for trial in SEARCH.run(slow, trials, workers):
            seen.append(trial.number)
            if len(seen) == 5:
                os.kill(next(iter(two.workers.values())).pid, signal.SIGKILL)
    assert sorted(seen) == list(range(32))
    assert trials() == run(tmp_path / "alone.db")


def reach(address: str) -> None:
    with cluster(address, patience=1.0):
        pass


def test_nobody_answers() -> None:
    with pytest.raises(SchedulerError, match=r"^no Dask scheduler answers at tcp://127.0.0.1:9: ") as error:
        reach("tcp://127.0.0.1:9")
    assert "\n" not in str(error.value)


def test_an_address_that_is_none() -> None:
    with pytest.raises(SchedulerError, match=r"^no Dask scheduler answers at nobody://: "):
        reach("nobody://")
