"""A study from its file to its report: the same bytes for any workers and after any end, and nothing done twice."""

import hashlib
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import polars as pl
import pytest
from distributed import LocalCluster

from tests.study.definitions import one_after_another
from tests.study.test_studyfile import CONFIG, GOOD
from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.hdl.cores import microarchitecture
from tfra.runtime.errors import InputError
from tfra.study.run import run
from tfra.study.search import costs
from tfra.study.search.evaluate import CHANGE
from tfra.study.studyfile import load_study
from tfra.study.workers import ONE_THREAD, cluster

STUDY = (
    GOOD
    + """
[uniform]
bits = [8, 12, 18]

[converter]
bits = [10, 14]
noise_share_of_peak = [0.0, 0.01]

[sensitivity]
shorter = [1]

[variants]
steps = [50]
plateau_tolerance = [1.0]

[search]
generations = 2
size = 6
"""
)


class Heard:
    """A reporter that remembers: jobs there already, and jobs done, by task."""

    def __init__(self) -> None:
        self.there: dict[str, int] = {}
        self.done: dict[str, int] = {}

    @contextmanager
    def __call__(self, name: str, unit: str, jobs: int, there: int) -> Iterator[Any]:
        self.there[name], self.done[name] = there, 0

        def advance() -> None:
            self.done[name] += 1

        yield advance
        assert self.there[name] + self.done[name] == jobs


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    (folder / "skin.toml").write_text(CONFIG + "[architecture]\nmac_lanes = 4\n")
    (folder / "study.toml").write_text(STUDY)
    return folder


@pytest.fixture(scope="module")
def report(place: Path) -> Path:
    """The report by this process alone, which knows resources without elaborating cores."""
    quick = SimpleNamespace(total={"LUT": 20_000, "FF": 15_000, "BRAM": 50})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(costs, "estimate", lambda design, family: quick)
        alone(place, "out", "work")
    return place / "out"


@pytest.fixture(scope="module")
def real(place: Path) -> Path:
    """The same with all that takes long."""
    alone(place, "real", "real.work")
    return place / "real"


def alone(place: Path, out: str, work: str, study: str = "study") -> Heard:
    """A study by this process alone."""
    heard = Heard()
    run(load_study(place / f"{study}.toml"), place / out, place / work, nullcontext(one_after_another), "me", heard)
    return heard


def table(report: Path, name: str) -> pl.DataFrame:
    return pl.read_parquet(report / "tables" / f"{name}.parquet")


def content(report: Path) -> dict[str, str]:
    """Hashes of all files but the times, and the manifest, which has their hash."""
    files = [file for file in report.rglob("*.*") if file.name not in ("times.html", "tfra-manifest.json")]
    return {str(file.relative_to(report)): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


def test_everything_is_there(report: Path) -> None:
    names = {"errors", "flagged", "flips", "stages", "decisions", "ranges", "uniform", "converter", "sensitivity"}
    names |= {"lengths", "variants", "uniform_trials", "trials", "baseline", "designs"}
    assert {path.stem for path in (report / "tables").iterdir()} == names
    assert "Still to come" not in (report / "index.html").read_text()
    times = (report / "times.html").read_text()
    assert "processes" not in times
    assert ">1 block<" in times
    assert not re.search(r">1 \w+s<", times)


def test_designs_found_are_configs_of_cores(report: Path) -> None:
    designs = table(report, "designs")
    files = {path.stem for path in (report / "designs").iterdir()}
    assert files == set(designs["name"]) - {"float", "base"}
    for name in files:
        design = load(report / "designs" / f"{name}.toml").design
        microarchitecture(design).check()
        row = designs.row(by_predicate=pl.col("name") == name, named=True)
        assert row["coefficient_kbit"] == design.coefficient_bits / 1000
        assert row["latency_cycles"] == microarchitecture(design).latency


def test_what_is_found_is_the_least_that_is_close(report: Path) -> None:
    trials = table(report, "trials").filter(pl.col("state") == "complete", pl.col(CHANGE) <= 5)
    designs = table(report, "designs")
    found = designs.filter(name="least_coefficient_kbit")
    if len(trials):
        assert found["coefficient_kbit"].item() == trials["coefficient_kbit"].min()
        assert found[CHANGE].item() <= 5
    plain = table(report, "uniform_trials").filter(pl.col("state") == "complete", pl.col(CHANGE) <= 5)
    assert designs.filter(name="uniform")[CHANGE].item() == plain.sort("bits")[CHANGE][0]


def test_finished_work_is_not_done_again(place: Path, report: Path) -> None:
    heard = alone(place, "again", "work")
    assert set(heard.done.values()) == {0}
    assert content(place / "again") == content(report)


@pytest.mark.long
def test_a_longer_search_begins_where_the_shorter_ended(place: Path, report: Path) -> None:
    """Errors and comparisons are there; the search has another description."""
    (place / "longer.toml").write_text(STUDY.replace("generations = 2", "generations = 3"))
    heard = alone(place, "longer", "work", "longer")
    assert heard.done["trials"] == 6
    assert heard.done["sensitivity"] == heard.done["errors"] == heard.done["frames"] == 0


KILLED = """
import sys
from pathlib import Path
from tests.study.test_run import Killer
from tfra.study.run import run
from tfra.study.studyfile import load_study
from tfra.study.workers import processes
folder, jobs = Path(sys.argv[1]), int(sys.argv[2])
run(load_study(folder / "study.toml"), folder / "end", folder / "end.work", processes(2), "", Killer(jobs, folder))
"""


class Killer:
    """A reporter that kills its process after so many jobs, and leaves the numbers of its workers in a file."""

    def __init__(self, jobs: int, folder: Path) -> None:
        self.left, self.file = jobs, folder / "workers"

    @contextmanager
    def __call__(self, name: str, unit: str, jobs: int, there: int) -> Iterator[Any]:
        yield self.advance

    def advance(self) -> None:
        self.left -= 1
        if not self.left:
            self.file.write_text(" ".join(str(child.pid) for child in multiprocessing.active_children()))
            os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.long
def test_two_kills_change_nothing(place: Path, real: Path) -> None:
    for jobs in (5, 14):
        command = [sys.executable, "-c", KILLED, str(place), str(jobs)]
        done = subprocess.run(command, cwd=Path(__file__).parents[2], check=False)
        assert done.returncode == -signal.SIGKILL
        assert not (place / "end").exists()
        workers = (place / "workers").read_text().split()
        assert len(workers) == 2
        for worker in workers:
            with suppress(OSError):  # it has gone, or is waited for until it has ended
                while Path(f"/proc/{worker}/stat").read_text().rpartition(")")[2].split()[0] != "Z":
                    time.sleep(0.01)
    heard = alone(place, "end", "end.work")
    assert content(place / "end") == content(real)
    assert sum(heard.there.values()) >= 19


def complaint(study: Path, out: Path, work: Path, **more: Any) -> str:
    with pytest.raises(InputError) as caught:
        run(load_study(study), out, work, nullcontext(one_after_another), "me", Heard(), **more)
    assert not out.exists()
    return str(caught.value).replace(f"{study.parent}/", "")


def test_a_table_that_can_not_be_reached_keeps_its_password(place: Path, report: Path, tmp_path: Path) -> None:
    for url, named in (("postgresql://me:secret@nowhere/x", "postgresql://me:***@nowhere/x: "), ("no url", "no url: ")):
        line = complaint(place / "study.toml", tmp_path / "out", place / "work", trials=url)
        assert line.startswith(named)
        assert "secret" not in line


def test_frames_that_are_all_degenerate(place: Path, tmp_path: Path) -> None:
    """Contacts far below the threshold."""
    (place / "faint.toml").write_text(GOOD.replace("{from = 20.0, to = 150.0}", "0.01"))
    line = complaint(place / "faint.toml", tmp_path / "out", tmp_path / "work")
    assert line == (
        "faint.toml: frames: all 400 frames of train are flagged, most of them as no contact: no errors can be told"
    )


def test_a_space_where_nothing_fits(place: Path, report: Path, tmp_path: Path) -> None:
    search = "[uniform]\nbits = [8, 12, 18]\n[search]\ngenerations = 1\nsize = 4\n"
    space = "[search.space]\nmac_lanes = {from = 5, to = 7}\n"
    (place / "empty.toml").write_text(GOOD + search + space)
    line = complaint(place / "empty.toml", tmp_path / "out", place / "work")
    assert line.startswith("empty.toml: search.space: none of 4 points fits together; of the last, architecture.mac_")


def test_workers_of_a_scheduler_are_its_own(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more = ["--out", str(tmp_path / "out"), "--scheduler", "tcp://x:1", "--workers", "2"]
    assert main(["study", str(place / "study.toml"), *more]) == 2
    assert capsys.readouterr().err == "--workers: is for local processes: a scheduler has its own workers\n"


@pytest.mark.long
def test_a_cluster_makes_the_same_bytes(place: Path, real: Path) -> None:
    """One of its workers is killed in the middle."""
    os.environ.update(ONE_THREAD)
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as two:
        victim = next(iter(two.workers.values())).pid
        heard = Heard()

        @contextmanager
        def killing(name: str, unit: str, jobs: int, there: int) -> Iterator[Any]:
            with heard(name, unit, jobs, there) as advance:
                if name == "trials":
                    os.kill(victim, signal.SIGKILL)
                yield advance

        study = load_study(place / "study.toml")
        run(study, place / "dask", place / "dask.work", cluster(two.scheduler_address), "dask", killing)
    assert content(place / "dask") == content(real)
