"""A study from its file to its report: tasks one after the other, each in pieces that workers compute."""

import math
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import polars as pl

from tfra.codegen.config.write import config_text
from tfra.families import DEFAULT
from tfra.runtime.digest import digest
from tfra.runtime.errors import InputError
from tfra.runtime.outputs import output_directory
from tfra.runtime.store import work_folder
from tfra.study.designs import Described, Named, Placed, Synthesised, Uniform, Verified, cheapest, front
from tfra.study.errors.comparisons import converters, sensitivity, uniform, variants
from tfra.study.errors.variation import Variation
from tfra.study.frames.frameset import FrameSet
from tfra.study.report.page import render
from tfra.study.report.summary import summary
from tfra.study.running import Reporter, Running, times_page
from tfra.study.schema import SearchSection, StudyDocument, UniformSection
from tfra.study.search.evaluate import CHANGE, Evaluation, TooFewError
from tfra.study.search.search import EmptySpaceError, Search, trial_table
from tfra.study.search.space import Space
from tfra.study.search.trials import StoreError, Trial, Trials, public, sqlite
from tfra.study.skins.run import SkinRun
from tfra.study.skins.studyfile import SkinStudy
from tfra.study.studyfile import StudyFile
from tfra.study.tasks import Comparison, Errors, Estimators, Signals
from tfra.study.workers import Workers, fingerprint


def run(
    study: StudyFile | SkinStudy,
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
            result: Running
            if isinstance(study, SkinStudy):
                result = SkinRun(study, folder, pool, reporter)
            else:
                result = Run(study, folder, pool, reporter, trials=trials or sqlite(folder / "trials.sqlite"))
            result.run_tasks()
        result.write(fresh)
        (fresh / "times.html").write_text(times_page(result.times, worker_text), encoding="utf-8")
    designs = result.tables["designs"].rows(named=True) if "designs" in result.tables else []
    return {"answer": "\n".join(result.answer()).replace("`", ""), "designs": designs}


@dataclass
class Run(Running):
    """A study of one array.

    ``designs`` are those of the search, whose trials are stored in the table at the URL ``trials`` at once.
    """

    study: StudyFile
    trials: str = ""
    designs: list[Named] = field(default_factory=list)

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

    def answer(self) -> list[str]:
        """Conclusions."""
        return summary(self.tables, self.study.design)

    def write(self, out: Path) -> None:
        """Write the page, the tables and the designs of the search into the folder ``out``."""
        super().write(out)
        if self.designs:  # an empty folder would have no seal
            (out / "designs").mkdir()
        weights = self.study.weights
        for each in self.designs:
            comment = f"Design `{each.name}` of the study {self.study.path.name}."
            text = config_text(each.design, self.study.project.layer, comment, weights.name if weights else None)
            (out / "designs" / f"{each.name}.toml").write_text(text)
        if weights and self.designs:
            (out / "designs" / weights.name).write_bytes(weights.read_bytes())

    def _page(self, pending: Sequence[str] = ()) -> str:
        design = self.study.design
        return render(self.tables, design, f"Word lengths and errors of {design.name}", pending)

    def _table_names(self) -> list[str]:
        return _table_names(self.study.document)

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


def _table_names(document: StudyDocument) -> list[str]:
    """Names of the tables that a study makes, in order."""
    names = [*Errors.makes, *Signals.makes, *(Estimators.makes if document.beside else [])]
    names += [name for name in ("uniform", "converter", "sensitivity", "variants") if getattr(document, name)]
    if document.search:
        names += ["trials", *(["baseline"] if document.search.baseline else []), "designs"]
    return names
