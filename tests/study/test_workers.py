"""Workers have one thread each, errors of jobs come out, and a scheduler that does not answer is an error."""

import os

import pytest

from tfra.study.workers import ONE_THREAD, SchedulerError, cluster, processes


def threads(name: str) -> str | None:
    return os.environ[name]


def test_processes_have_one_thread_and_no_other_process_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("POLARS_MAX_THREADS", raising=False)
    with processes(2) as workers:
        results = dict(workers(threads, list(ONE_THREAD)))
        assert results == dict.fromkeys(range(len(ONE_THREAD)), "1")
        assert dict(workers(threads, ["OMP_NUM_THREADS"])) == {0: "1"}
        with pytest.raises(KeyError, match="NOTHING"):
            list(workers(threads, ["NOTHING"]))
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "POLARS_MAX_THREADS" not in os.environ


def test_a_scheduler_that_does_not_answer() -> None:
    with (
        pytest.raises(SchedulerError, match=r"^no Dask scheduler answers at tcp://127.0.0.1:9: ") as error,
        cluster("tcp://127.0.0.1:9", patience=0.2),
    ):
        pass
    assert "\n" not in str(error.value)
