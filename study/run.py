"""A study from its file to its report: tasks one after the other, each in pieces that workers compute."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import polars as pl

from tfra.codegen.config.write import config_text
from tfra.runtime.errors import InputError
from tfra.runtime.outputs import output_directory
from tfra.runtime.store import Store, put, work_folder
from tfra.sim.run import digest
from tfra.study.designs import Described, Named, Placed, Uniform, Verified, chosen, named
from tfra.study.errors.converter import converters
from tfra.study.errors.sensitivity import UNIFORM, sensitivity, uniform
from tfra.study.errors.variants import variants
from tfra.study.errors.variation import Comparison, Variation
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import FrameSet
from tfra.study.report.page import render
from tfra.study.report.summary import summary
from tfra.study.schema import SearchSection, StudyDocument
from tfra.study.search.evaluate import CHANGE, Evaluation, TooFewError
from tfra.study.search.search import EmptySpaceError, Search, front
from tfra.study.search.space import Space
from tfra.study.search.trials import StoreError, Trial, Trials, public, sqlite
from tfra.study.studyfile import StudyFile
from tfra.study.tasks import Compared, Errors, Signals, Task, parquet
from tfra.study.times import Timed, times
from tfra.study.workers import Workers, fingerprint
from tfra.synth.targets import ECP5

PARTIAL = "partial.html"
"""The results so far, in the working folder."""

SHOW_EVERY = 15.0
"""Seconds between two partial pages: one takes a few."""

Reporter = Callable[[str, str, int, int], AbstractContextManager[Callable[[], None]]]
"""Function of a task's name and unit, the number of its jobs, and of those finished; returns the callback for each
finished job."""


def run(
    study: StudyFile,
    out: Path,
    folder: Path,
    workers: AbstractContextManager[Workers],
    who: str,
    reporter: Reporter,
    trials: str | None = None,
) -> dict[str, Any]:
    """Make the report of ``study`` in ``out``; return its ``answer`` in words, and its ``designs``.

    Work is kept in ``folder``, trials in the table at the URL ``trials`` if one is given; ``who`` are the workers in
    words.  Raises ``InputError`` for bad input, which leaves ``out`` as it was and keeps what is finished.
    """
    with output_directory(out, "study", [*study.inputs, folder / "study.json"]) as fresh:
        with workers as do, work_folder(folder, "study", fingerprint()):
            made = Run(study, folder, do, reporter, trials or sqlite(folder / "trials.sqlite"))
            made.everything()
        _write(fresh, study, made)
        (fresh / "times.html").write_text(times(made.timed, who), encoding="utf-8")
    designs = made.tables["designs"].rows(named=True) if "designs" in made.tables else []
    return {"answer": summary(made.tables, study.design).replace("`", ""), "designs": designs}


def _write(fresh: Path, study: StudyFile, made: Run) -> None:
    for folder in ("tables", *(["designs"] if made.designs else [])):  # an empty one would have no seal
        (fresh / folder).mkdir()
    for name, table in made.tables.items():
        (fresh / "tables" / f"{name}.parquet").write_bytes(parquet(table))
    for each in made.designs:
        comment = f"Design `{each.name}` of the study {study.path.name}."
        text = config_text(each.design, study.project.layer, comment)
        (fresh / "designs" / f"{each.name}.toml").write_text(text)
    (fresh / "index.html").write_text(render(made.tables, study.design, title(study)), encoding="utf-8")


def title(study: StudyFile) -> str:
    """Of the report."""
    return f"Word lengths and errors of {study.design.name}"


@dataclass
class Run:
    """What is there of a study: ``tables`` by name, the ``designs`` that were found, and how long tasks took.

    Frames, finished pieces and trials are stored in ``folder`` at once.
    """

    study: StudyFile
    folder: Path
    workers: Workers
    reporter: Reporter
    trials: str
    tables: dict[str, pl.DataFrame] = field(default_factory=dict)
    designs: list[Named] = field(default_factory=list)
    timed: list[Timed] = field(default_factory=list)
    shown: float = field(default_factory=time.perf_counter)

    def everything(self) -> None:
        """Run all tasks of the file."""
        frames = self._frames()
        self._do(Errors(self.study.design, frames))
        self._require_errors()
        self._do(Signals(self.study.design, frames))
        for name, variations in self._variations():
            self._do(Compared(name, Comparison(frames, Part.TRAIN, variations)))
        if section := self.study.document.search:
            self._search(section, frames)

    def _frames(self) -> FrameSet:
        frames = FrameSet.create(self.folder / "frames", self.study.definition)
        missing = frames.missing()
        count = sum(frames.definition.blocks(part) for part in Part)
        with self._timing("frames", "blocks", count, count - len(missing)) as advance:
            for _ in self.workers(_Write(frames), missing):
                advance()
        return frames

    def _require_errors(self) -> None:
        """Raise if all frames of a part are left out, because no design could be judged."""
        for part, frames, of in (
            self.tables["flagged"].filter(status="left_out").select("part", "frames", "of").iter_rows()
        ):
            if frames == of:
                flags = self.tables["flagged"].filter(pl.col("status") != "left_out", part=part)
                most = flags.sort("frames", descending=True)["status"][0].replace("_", " ")
                reason = f"all {of:,} frames of {part} are flagged, most of them as {most}: no errors can be told"
                raise InputError(self.study.path, "frames", reason)

    def _variations(self) -> Iterator[tuple[str, tuple[Variation, ...]]]:
        """What designs are compared with that of CONFIG, by the name of their table."""
        document, design = self.study.document, self.study.design
        family = self.study.target.family if self.study.target else ECP5
        if document.uniform:
            yield "uniform", uniform(design, document.uniform.bits, family)
        if document.converter:
            yield "converter", converters(design, document.converter.bits, document.converter.noise_share_of_peak)
        if document.sensitivity:
            yield "sensitivity", sensitivity(design, family, document.sensitivity.shorter)
        if document.variants:
            yield "variants", variants(design, document.variants.steps, document.variants.plateau_tolerance)

    def _search(self, section: SearchSection, frames: FrameSet) -> None:
        """Look for word lengths, and measure what was found."""
        base, target = self.study.design, self.study.target
        assert target is not None
        costs = tuple(section.costs)
        evaluation = Evaluation(base, frames, costs, target, tuple(section.errors), section.give_up_percent)
        lengths = self.study.document.uniform.bits if self.study.document.uniform else UNIFORM
        plain = Uniform(tuple(lengths), replace(evaluation, limit=math.inf))
        self._do(plain)
        bits = plain.chosen(self.tables[plain.name])
        space = self.study.space or Space.around(base, bits or base.formats.operand, min(target.family.multiplier))
        search = Search(space, (CHANGE, *costs), section.generations, section.size, section.seed)
        found = self._trials("trials", search, evaluation)
        if section.baseline:
            self._trials("baseline", replace(search, sampler="random"), evaluation)
        winners = [
            named(base, name, Space.design(base, space.point(trial.indices)))
            for name, trial in chosen(found, costs).items()
        ]
        self.designs = [*([named(base, "uniform", plain.design(bits))] if bits else []), *winners]
        self._describe(evaluation, winners)

    def _describe(self, evaluation: Evaluation, winners: Sequence[Named]) -> None:
        """The table of the designs that were found, beside that of CONFIG and float arithmetic."""
        document = self.study.document
        self._do(Described((Named("base", self.study.design), *self.designs), evaluation))
        if document.verify and winners:
            self._do(Verified(tuple(winners), evaluation, document.verify.frames, document.verify.simulator))
            self._join("verified")
        if document.place and self.designs:
            clock = document.place.clock_mhz or evaluation.target.clock_mhz
            self._do(Placed(tuple(self.designs), evaluation, document.place.seeds, clock))
            self._join("placed")

    def _join(self, name: str) -> None:
        """Put the columns of a table beside those of the designs."""
        more = self.tables.pop(name)
        self._add({"designs": self.tables["designs"].join(more, on="name", how="left", maintain_order="left")})

    def _trials(self, name: str, search: Search, evaluation: Evaluation) -> list[Trial]:
        """Do a search, and make its table."""
        with self._told():
            endless = replace(search, generations=0)  # a longer one begins with the same trials
            stored = Trials(self.trials, digest(fingerprint(), repr(endless), repr(evaluation)))
            count = search.generations * search.size
            there = {trial.number for trial in stored() if trial.number < count}
            with self._timing(name, "trials", count, len(there)) as advance:
                for trial in search.run(evaluation, stored, self.workers):
                    if trial.number not in there:
                        advance()
            found = [trial for trial in stored() if trial.number < count]
        self._add({name: table_of(found, search, evaluation.held)})
        return found

    def _do(self, task: Task) -> None:
        """Run the missing jobs of a task, and add its tables."""
        key = digest(fingerprint(), repr(task))
        pieces, jobs = Store(self.folder / "pieces" / f"{task.name}-{key}", key), task.jobs
        pieces.create()
        there = pieces.names()
        missing = [number for number in range(len(jobs)) if _name(number) not in there]
        with self._told(), self._timing(task.name, task.unit, len(jobs), len(jobs) - len(missing)) as advance:
            for place, data in self.workers(task, [jobs[number] for number in missing]):
                pieces.put(_name(missing[place]), data)
                advance()
            made = task.tables(lambda number: pieces.get(_name(number)))
        self._add(made)

    def _add(self, tables: Mapping[str, pl.DataFrame]) -> None:
        """Add tables, and show the page of what is there so far."""
        self.tables |= tables
        pending = [name for name in _wanted(self.study.document) if name not in self.tables]
        if pending and time.perf_counter() - self.shown > SHOW_EVERY:
            page = render(self.tables, self.study.design, title(self.study), pending)
            put(self.folder, PARTIAL, page.encode())
            self.shown = time.perf_counter()

    @contextmanager
    def _told(self) -> Iterator[None]:
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
    def _timing(self, name: str, unit: str, jobs: int, there: int) -> Iterator[Callable[[], None]]:
        start = time.perf_counter()
        with self.reporter(name, unit, jobs, there) as advance:
            yield advance
        self.timed.append(Timed(name, unit, jobs, there, time.perf_counter() - start))


@dataclass(frozen=True)
class _Write:
    """Makes a block of frames and stores it."""

    frames: FrameSet

    def __call__(self, block: tuple[Part, int]) -> None:
        self.frames.write(*block)


def _name(number: int) -> str:
    return f"{number:06d}"


def _wanted(document: StudyDocument) -> list[str]:
    """Names of the tables that a study makes, in order."""
    names = [*Errors.makes, *Signals.makes]
    names += [name for name in ("uniform", "converter", "sensitivity", "variants") if getattr(document, name)]
    if document.search:
        names += ["trials", *(["baseline"] if document.search.baseline else []), "designs"]
    return names


def table_of(trials: Sequence[Trial], search: Search, held: Sequence[str]) -> pl.DataFrame:
    """A row each trial: what was chosen, objectives, the errors that are held, and whether it is on the front."""
    best = {trial.number for trial in front(trials, search.objectives)}
    rows = [
        {
            "number": trial.number,
            "generation": trial.number // search.size,
            "state": trial.state,
            **search.space.point(trial.indices),
            **{name: trial.values.get(name) for name in (*search.objectives, *held)},
            "front": trial.number in best,
            "reason": trial.reason,
        }
        for trial in trials
    ]
    return pl.DataFrame(rows, infer_schema_length=None)
