"""A study from its file to its report: tasks one after the other, each in pieces that workers compute."""

import math
import resource
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import polars as pl

from tfra.codegen.config.write import config_text
from tfra.families import DEFAULT
from tfra.report.html import page, paragraph
from tfra.report.table import Table
from tfra.runtime.digest import digest
from tfra.runtime.errors import InputError
from tfra.runtime.outputs import output_directory
from tfra.runtime.store import Store, put, work_folder
from tfra.study.designs import Described, Named, Placed, Synthesised, Uniform, Verified, cheapest, front
from tfra.study.errors.comparisons import converters, sensitivity, uniform, variants
from tfra.study.errors.variation import Variation
from tfra.study.frames.block import parquet
from tfra.study.frames.frameset import FrameSet
from tfra.study.report.page import render
from tfra.study.report.summary import summary
from tfra.study.schema import SearchSection, StudyDocument, UniformSection
from tfra.study.search.evaluate import CHANGE, Evaluation, TooFewError
from tfra.study.search.search import EmptySpaceError, Search, trial_table
from tfra.study.search.space import Space
from tfra.study.search.trials import StoreError, Trial, Trials, public, sqlite
from tfra.study.studyfile import StudyFile
from tfra.study.tasks import Comparison, Errors, Estimators, Signals, Task
from tfra.study.workers import Workers, fingerprint

PARTIAL = "partial.html"
"""The results so far, in the working folder."""

PAGE_EVERY = 15.0
"""Seconds between two partial pages: one takes a few."""

Reporter = Callable[[str, str, int, int], AbstractContextManager[Callable[[], None]]]
"""Function of a task's name and unit, the number of its jobs, and of those finished; returns the callback for each
finished job."""


def run(
    study: StudyFile,
    out: Path,
    folder: Path,
    workers: AbstractContextManager[Workers],
    worker_text: str,
    reporter: Reporter,
    trials: str | None = None,
) -> dict[str, Any]:
    """Make the report of ``study`` in ``out``; return its ``answer`` in lines of words, and its ``designs``.

    Work is stored in ``folder``, trials in the table at the URL ``trials`` if one is given; ``worker_text`` describes
    the workers.  Raises ``InputError`` for bad input, which leaves ``out`` as it was; finished work stays.
    """
    with output_directory(out, "study", [*study.inputs, folder / "study.json"]) as fresh:
        with workers as pool, work_folder(folder, "study", fingerprint()):
            result = Run(study, folder, pool, reporter, trials or sqlite(folder / "trials.sqlite"))
            result.run_tasks()
        result.write(fresh)
        (fresh / "times.html").write_text(times_page(result.times, worker_text), encoding="utf-8")
    designs = result.tables["designs"].rows(named=True) if "designs" in result.tables else []
    return {"answer": "\n".join(summary(result.tables, study.design)).replace("`", ""), "designs": designs}


@dataclass
class Run:
    """Results of a study so far: ``tables`` by name, the ``designs`` of the search, and the ``times`` of tasks.

    Frames, finished pieces and trials are stored in ``folder`` at once.
    """

    study: StudyFile
    folder: Path
    workers: Workers
    reporter: Reporter
    trials: str
    tables: dict[str, pl.DataFrame] = field(default_factory=dict)
    designs: list[Named] = field(default_factory=list)
    times: list[tuple[str, str, int, float, float | None]] = field(default_factory=list)
    last_page: float = field(default_factory=time.perf_counter)

    def run_tasks(self) -> None:
        """Run all tasks of the file."""
        design, frames = self.study.design, self._make_frames()
        self._run_task(Errors(design, frames))
        self._require_errors()
        self._run_task(Signals(design, frames))
        if self.study.beside:
            self._run_task(Estimators(((self.study.project.path.stem, design), *self.study.beside), frames))
        for name, variations in self._variations():
            self._run_task(Comparison(name, frames, variations))
        if section := self.study.document.search:
            self._search(section, frames)

    def write(self, out: Path) -> None:
        """Write the page, the tables and the designs of the search into the folder ``out``."""
        for folder in ("tables", *(["designs"] if self.designs else [])):  # an empty one would have no seal
            (out / folder).mkdir()
        for name, table in self.tables.items():
            (out / "tables" / f"{name}.parquet").write_bytes(parquet(table))
        weights = self.study.weights
        for each in self.designs:
            comment = f"Design `{each.name}` of the study {self.study.path.name}."
            text = config_text(each.design, self.study.project.layer, comment, weights.name if weights else None)
            (out / "designs" / f"{each.name}.toml").write_text(text)
        if weights and self.designs:
            (out / "designs" / weights.name).write_bytes(weights.read_bytes())
        (out / "index.html").write_text(self._page(), encoding="utf-8")

    def _page(self, pending: Sequence[str] = ()) -> str:
        design = self.study.design
        return render(self.tables, design, f"Word lengths and errors of {design.name}", pending)

    def _make_frames(self) -> FrameSet:
        definition = self.study.definition
        frames = FrameSet.create(self.folder / f"frames-{definition.hash[:16]}", definition)
        missing, count = frames.missing(), len(definition.all_blocks())
        with self._progress("frames", "blocks", count, count - len(missing)) as advance:
            for _ in self.workers(frames.write, missing):
                advance()
        return frames

    def _require_errors(self) -> None:
        """Raise if all frames of a part are left out, because no design could be judged."""
        flagged = self.tables["flagged"]
        for part, frames, of in flagged.filter(status="left_out").select("part", "frames", "of").iter_rows():
            if frames == of:
                flags = flagged.filter(pl.col("status") != "left_out", part=part)
                most = flags.sort("frames", descending=True)["status"][0].replace("_", " ")
                reason = f"all {of:,} frames of {part} are flagged, most of them as {most}: no errors can be told"
                raise InputError(self.study.path, "frames", reason)

    def _variations(self) -> Iterator[tuple[str, tuple[Variation, ...]]]:
        """The designs that are compared with that of CONFIG, by the name of their table."""
        document, design = self.study.document, self.study.design
        family = self.study.target.family if self.study.target else DEFAULT
        if document.uniform:
            yield "uniform", uniform(design, document.uniform.bits, family)
        if document.converter:
            yield "converter", converters(design, document.converter.bits, document.converter.noise_share_of_peak)
        if document.sensitivity:
            yield "sensitivity", sensitivity(design, family, document.sensitivity.shorter)
        if document.variants:
            yield "variants", variants(design, document.variants.steps, document.variants.plateau_tolerance)

    def _search(self, section: SearchSection, frames: FrameSet) -> None:
        """Look for word lengths, and measure the designs that win."""
        base, target, document = self.study.design, self.study.target, self.study.document
        assert target is not None
        costs = tuple(section.costs)
        evaluation = Evaluation(base, frames, costs, target, tuple(section.errors), section.give_up_percent)
        plain = Uniform(tuple((document.uniform or UniformSection()).bits), replace(evaluation, limit=math.inf))
        self._run_task(plain)
        bits, cell = plain.fewest(self.tables[plain.name]), target.family.multiplier
        start = bits or base.formats.operand
        space = self.study.space or Space.around(base, start, min(cell.widths) if cell else start)
        search = Search(space, (CHANGE, *costs), section.generations, section.size, section.seed)
        trials = self._run_search("trials", search, evaluation)
        if section.baseline:
            self._run_search("baseline", replace(search, sampler="random"), evaluation)
        winners = tuple(self._named(space, *item) for item in cheapest(trials, costs).items())
        found = [*([Named.of(base, "uniform", plain.design(bits))] if bits else []), *winners]
        more = front(trials, costs[0], document.synth.front) if document.synth else {}
        self.designs = [*found, *(self._named(space, *item) for item in more.items())]
        compared = Named("base", base), *self.designs
        self._run_task(Described((None, *compared), evaluation))
        if document.verify and winners:
            self._run_task(Verified(winners, evaluation, document.verify.frames, document.verify.simulator))
            self._join_designs("verified")
        if document.synth:
            self._run_task(Synthesised(compared, evaluation))
            self._join_designs("synthesised")
        if document.place and found:
            clock = document.place.clock_mhz or target.clock_mhz
            self._run_task(Placed(tuple(found), evaluation, document.place.seeds, clock))
            self._join_designs("placed")

    def _named(self, space: Space, name: str, trial: Trial) -> Named:
        """The design of a trial."""
        return Named.of(self.study.design, name, Space.design(self.study.design, space.point(trial.indices)))

    def _join_designs(self, name: str) -> None:
        """Put the columns of a table beside those of the designs."""
        more, designs = self.tables.pop(name), self.tables["designs"]
        new = more.select("name", *(column for column in more.columns if column not in designs.columns))
        self._add({"designs": designs.join(new, on="name", how="left", maintain_order="left")})

    def _run_search(self, name: str, search: Search, evaluation: Evaluation) -> list[Trial]:
        """Do a search, and make its table."""
        with self._as_input_error():
            endless = replace(search, generations=0)  # a longer one begins with the same trials
            stored = Trials(self.trials, digest(fingerprint(), repr(endless), repr(evaluation)))
            count = search.generations * search.size
            finished = {trial.number for trial in stored() if trial.number < count}
            with self._progress(name, "trials", count, len(finished)) as advance:
                for trial in search.run(evaluation, stored, self.workers):
                    if trial.number not in finished:
                        advance()
            trials = [trial for trial in stored() if trial.number < count]
        self._add({name: trial_table(trials, search, evaluation.quantities)})
        return trials

    def _run_task(self, task: Task) -> None:
        """Run the missing jobs of a task, and add its tables."""
        key = digest(fingerprint(), repr(task))
        pieces, jobs = Store(self.folder / "pieces" / f"{task.name}-{key}", key), task.jobs
        pieces.create()
        finished = pieces.names()
        missing = [number for number in range(len(jobs)) if _piece_name(number) not in finished]
        with (
            self._as_input_error(),
            self._progress(task.name, task.unit, len(jobs), len(jobs) - len(missing)) as advance,
        ):
            for position, data in self.workers(task, [jobs[number] for number in missing]):
                pieces.put(_piece_name(missing[position]), data)
                advance()
            tables = task.tables(lambda number: pieces.get(_piece_name(number)))
        self._add(tables)

    def _add(self, tables: Mapping[str, pl.DataFrame]) -> None:
        """Add tables, and write the page of all tables so far."""
        self.tables |= tables
        pending = [name for name in _table_names(self.study.document) if name not in self.tables]
        if pending and time.perf_counter() - self.last_page > PAGE_EVERY:
            put(self.folder, PARTIAL, self._page(pending).encode())
            self.last_page = time.perf_counter()

    @contextmanager
    def _as_input_error(self) -> Iterator[None]:
        """Turn errors of frames, space or the table of trials into ``InputError``."""
        try:
            yield
        except TooFewError as error:
            raise InputError(self.study.path, "frames", str(error).partition(": ")[2]) from None
        except EmptySpaceError as error:
            raise InputError(self.study.path, "search.space", str(error)) from None
        except StoreError as error:
            raise InputError(public(self.trials), "", str(error)) from None

    @contextmanager
    def _progress(self, name: str, unit: str, jobs: int, finished: int) -> Iterator[Callable[[], None]]:
        """Report a task, and measure its time; yields the callback for each finished job."""
        start = time.perf_counter()
        unit = unit.removesuffix("s") if jobs == 1 else unit
        with self.reporter(name, unit, jobs, finished) as advance:
            yield advance
        seconds, done = time.perf_counter() - start, jobs - finished
        rate = round(done / seconds, 2) if done else None
        self.times.append((name, f"{jobs:,} {unit}", finished, round(seconds, 1), rate))


def times_page(times: Sequence[tuple[str, str, int, float, float | None]], workers: str) -> str:
    """How long the tasks took, on a page of its own, because the rest of a report is the same in every run."""
    header = ("task", "jobs", "finished before", "time / s", "jobs a second")
    kilobytes = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    total = sum(seconds for *_, seconds, _ in times)
    words = f"Done by {workers}: {total:,.1f} s in all. Memory of the largest process: {kilobytes / 1024:,.0f} MB."
    return page("Times of the study", [paragraph(words), Table("Times", header, times).html()], [])


def _piece_name(number: int) -> str:
    return f"{number:06d}"


def _table_names(document: StudyDocument) -> list[str]:
    """Names of the tables that a study makes, in order."""
    names = [*Errors.makes, *Signals.makes, *(Estimators.makes if document.beside else [])]
    names += [name for name in ("uniform", "converter", "sensitivity", "variants") if getattr(document, name)]
    if document.search:
        names += ["trials", *(["baseline"] if document.search.baseline else []), "designs"]
    return names
