"""A search has the same trials whoever measures them and however often it is interrupted."""

import itertools
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.study.definitions import one_after_another
from tfra.study.search.search import Measured, Search, front
from tfra.study.search.space import Point, Space
from tfra.study.search.trials import COMPLETE, STOPPED, UNFIT, StoreError, Trial, Trials, sqlite

BITS = tuple(range(6, 19))
SPACE = Space({"coefficient": BITS, "operand.force": BITS, "coefficient.normal": BITS, "mac_lanes": (4, 8, 16)})
SEARCH = Search(SPACE, ("error", "bits"), generations=4, size=8, seed=5)


def measure(point: Point) -> Measured:
    """Something like an error and a cost, with designs that do not fit and designs that are given up."""
    if point["mac_lanes"] == 8 and point["coefficient"] == 6:
        return Measured(UNFIT, {}, "mac_lanes: 8 are too many")
    bits = point["coefficient"] + point["operand.force"] + 2 * point["coefficient.normal"]
    error = sum(2.0 ** -point[name] for name in ("coefficient", "operand.force", "coefficient.normal"))
    return Measured(STOPPED if bits < 30 else COMPLETE, {"error": error, "bits": float(bits + point["mac_lanes"])})


def backwards(measure: object, points: Sequence[Point]) -> Iterator[tuple[int, Measured]]:
    yield from reversed(list(one_after_another(measure, points)))  # type: ignore[arg-type]  # any object


def run(
    path: Path, search: Search = SEARCH, workers: object = one_after_another, most: int | None = None
) -> list[Trial]:
    """The table after a search of which ``most`` trials were seen."""
    trials = Trials(sqlite(path), "search")
    for _ in itertools.islice(search.run(measure, trials, workers), most):  # type: ignore[arg-type]  # any object
        pass
    return trials()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> list[Trial]:
    """The trials of a search that nothing interrupts."""
    return run(tmp_path_factory.mktemp("whole") / "trials.db")


def test_any_order_of_the_workers_gives_the_same_trials(tmp_path: Path, whole: list[Trial]) -> None:
    assert len(whole) == 32
    assert run(tmp_path / "backwards.db", workers=backwards) == whole


@pytest.mark.parametrize("seen", [1, 8, 13, 31])
def test_an_interrupted_search_continues(tmp_path: Path, whole: list[Trial], seen: int) -> None:
    assert len(run(tmp_path / "cut.db", most=seen)) == seen
    assert run(tmp_path / "cut.db") == whole


def test_what_is_in_the_table_is_not_measured_again(tmp_path: Path) -> None:
    run(tmp_path / "trials.db")
    asked: list[Point] = []

    def watched(measure: object, points: Sequence[Point]) -> Iterator[tuple[int, Measured]]:
        asked.extend(points)
        yield from one_after_another(measure, points)  # type: ignore[arg-type]  # any object

    assert len(run(tmp_path / "trials.db", workers=watched)) == 32
    assert asked == []
    run(tmp_path / "fresh.db", workers=watched)
    keys = [tuple(sorted(point.items())) for point in asked]
    assert len(set(keys)) == len(keys)


def test_another_seed_is_another_search(tmp_path: Path, whole: list[Trial]) -> None:
    other = run(tmp_path / "other.db", replace(SEARCH, seed=6, generations=1))
    assert [trial.indices for trial in other] != [trial.indices for trial in whole[:8]]


def test_generations_get_better(tmp_path: Path) -> None:
    """Of the last generations more are within reach of the front of all than of the first, which are random."""
    trials = run(tmp_path / "trials.db", Search(SPACE, ("error", "bits"), generations=6, size=16, seed=3))
    best = [one.values for one in front(trials, SEARCH.objectives)]

    near = [
        trial.state == COMPLETE and any(all(trial.values[n] <= 1.3 * one[n] for n in SEARCH.objectives) for one in best)
        for trial in trials
    ]
    assert sum(near[-32:]) > sum(near[:32])


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5), st.integers(0, 5)), max_size=30))
def test_the_front_is_what_nobody_dominates(values: list[tuple[int, int, int]]) -> None:
    names = ("a", "b", "c")
    trials = [Trial(n, COMPLETE, {}, dict(zip(names, map(float, v), strict=True))) for n, v in enumerate(values)]

    def beaten(n: int) -> bool:
        return any(
            all(a <= b for a, b in zip(other, values[n], strict=True)) and (other != values[n] or m < n)
            for m, other in enumerate(values)
            if m != n
        )

    assert [trial.number for trial in front(trials, names)] == [n for n in range(len(values)) if not beaten(n)]


def test_trials_that_were_stopped_are_on_no_front() -> None:
    assert front([Trial(0, STOPPED, {}, {"a": 0.0}), Trial(1, COMPLETE, {}, {"a": 1.0})], ("a",))[0].number == 1


def test_searches_in_one_table_do_not_meet_and_the_first_writer_counts(tmp_path: Path) -> None:
    url = sqlite(tmp_path / "trials.db")
    for value in (0.1, 0.2):
        Trials(url, "one").add(Trial(0, COMPLETE, {"operand": 1}, {"a": value}), 1.0)
    assert Trials(url, "two")() == []
    assert Trials(url, "one")() == [Trial(0, COMPLETE, {"operand": 1}, {"a": 0.1})]


def test_a_locked_table_keeps_its_trials(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tfra.study.search.trials.PATIENCE", 0.1)
    trials, trial = Trials(sqlite(tmp_path / "trials.db"), "one"), Trial(0, COMPLETE, {})
    trials.add(trial, 1.0)
    with closing(sqlite3.connect(tmp_path / "trials.db")) as other:
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(StoreError, match=r"^database is locked$"):
            trials.add(replace(trial, number=1), 1.0)
    assert trials() == [trial]


@pytest.mark.parametrize(
    ("url", "line"),
    [
        ("sqlite:////nowhere/at/all/trials.db", "unable to open database file"),
        ("no url", "a URL sqlite:///FILE or postgresql://HOST/DATABASE is needed"),
        ("oracle://here", "a URL sqlite:///FILE or postgresql://HOST/DATABASE is needed"),
    ],
)
def test_a_table_out_of_reach(url: str, line: str) -> None:
    with pytest.raises(StoreError, match=line) as error:
        Trials(url, "one")
    assert "\n" not in str(error.value)


def test_a_broken_table(tmp_path: Path) -> None:
    (tmp_path / "trials.db").write_bytes(b"not a database, but long enough to look like one" * 100)
    with pytest.raises(StoreError, match="file is not a database"):
        Trials(sqlite(tmp_path / "trials.db"), "one")


@pytest.mark.parametrize("content", ["CAST(x'FF' AS TEXT)", f"'{'[' * 100_000}'", f"""'{{"{"x" * 3000}": 1}}'"""])
def test_a_damaged_trial(tmp_path: Path, content: str) -> None:
    file = tmp_path / "trials.db"
    trials = Trials(sqlite(file), "one")
    trials.add(Trial(0, COMPLETE, {"a": 1}), 1.0)
    with closing(sqlite3.connect(file)) as other, other:
        other.execute(f"UPDATE trials SET content = {content}")
    with pytest.raises(StoreError) as told:
        trials()
    assert len(str(told.value)) < 300


def test_a_table_with_a_damaged_message(tmp_path: Path) -> None:
    """SQLite tells of the schema's bytes, which are no text."""
    file = tmp_path / "trials.db"
    Trials(sqlite(file), "one")
    with closing(sqlite3.connect(file)) as other:
        other.execute("PRAGMA journal_mode = DELETE")
    file.write_bytes(file.read_bytes().replace(b"CREATE TABLE trials", b"CREATE T\xffBLE trials"))
    with pytest.raises(StoreError):
        Trials(sqlite(file), "one")
