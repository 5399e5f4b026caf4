"""The designs that a search finds: their errors on held-out frames, in RTL, and placed.

Named designs are ``base``, that of CONFIG; ``uniform``, the one with the fewest bits in all coefficients and operands
whose total error stays close to float's; and for each cost ``least_COST``, the trial with the least of it that is as
close.  Closeness is judged on the training frames; the table also has the errors on the held-out frames.
"""

import json
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import polars as pl

from tfra.model.choices import Formats
from tfra.model.fixed.design import Design
from tfra.runtime.processes import ToolError
from tfra.runtime.scratch import scratch, temporary
from tfra.study.errors.cascade import SIGNED
from tfra.study.frames.block import Part
from tfra.study.report.labels import CLOSE_PERCENT, HELD_OUT, PLACED, Tables
from tfra.study.search.costs import COSTS
from tfra.study.search.evaluate import CHANGE, Evaluation
from tfra.study.search.space import Space
from tfra.study.search.trials import COMPLETE, Trial
from tfra.study.tasks import Pieces
from tfra.synth.run import Run


@dataclass(frozen=True)
class Named:
    """A design, and its name in the tables, as a file and as a Verilog module."""

    name: str
    design: Design

    @classmethod
    def of(cls, base: Design, name: str, design: Design) -> "Named":
        """``design`` as a module with its own name, distinct from ``base``."""
        return cls(name, replace(design, name=f"{base.name[:40]}_{name}"))


def is_close(errors: Mapping[str, float]) -> bool:
    """Whether a total error is within ``CLOSE_PERCENT`` of float's."""
    return errors[CHANGE] <= CLOSE_PERCENT


def cheapest(trials: Iterable[Trial], costs: Sequence[str]) -> dict[str, Trial]:
    """For each cost the close trial with the least of it, then of the others, without repeated trials."""
    close = [trial for trial in trials if trial.state == COMPLETE and is_close(trial.values)]
    winners: dict[str, Trial] = {}
    for cost in costs if close else ():
        order = (cost, *(other for other in costs if other != cost), CHANGE)
        best = min(close, key=lambda trial: (*(trial.values[name] for name in order), trial.number))
        if best.number not in {trial.number for trial in winners.values()}:
            winners[f"least_{cost.lower()}"] = best
    return winners


def formats_text(formats: Formats) -> str:
    """Word lengths as text."""
    words = f"coefficients {formats.coefficient}, operands {formats.operand}, vectors {formats.vector_fraction} and "
    own = ", ".join(f"{signal} {bits}" for signal, bits in formats.signals)
    return f"{words}forces {formats.force_fraction} below one code" + (f"; {own}" if own else "")


@dataclass(frozen=True)
class RowTask(ABC):
    """A task whose ``jobs`` make a row each of one table with the task's name."""

    jobs: tuple[Any, ...]
    evaluation: Evaluation
    name: ClassVar[str]
    unit = "designs"

    @abstractmethod
    def row(self, job: Any) -> Mapping[str, Any]:
        """The row of a job, in plain values."""

    def __call__(self, job: Any) -> bytes:
        """The row as JSON."""
        return json.dumps(self.row(job)).encode()

    def tables(self, piece: Pieces) -> Tables:
        """The table."""
        rows = [json.loads(piece(number)) for number in range(len(self.jobs))]
        return {self.name: pl.DataFrame(rows, infer_schema_length=None)}


class Described(RowTask):
    """Errors and costs of named designs; the job None, the row ``float``, is float arithmetic on the same codes."""

    name = "designs"

    def row(self, job: Named | None) -> dict[str, Any]:
        """Errors on the training and the held-out frames, and costs."""
        parts = [replace(self.evaluation, part=part, costs=COSTS) for part in (Part.TRAIN, Part.HELD_OUT)]
        if job is None:
            trained, held_out = (part.exact() for part in parts)
            row: dict[str, Any] = {"name": "float", "formats": "double precision"}
            costs: Mapping[str, float | None] = dict.fromkeys(COSTS)
        else:
            trained, held_out = (part.errors(job.design, part.blocks) for part in parts)
            row = {"name": job.name, "formats": formats_text(job.design.formats)}
            costs = parts[0].cost_values(job.design)
        names = [name for name in (CHANGE, *SIGNED) if name == CHANGE or name in trained]
        row |= {name: trained.get(name) for name in names}
        row |= {f"{name}{HELD_OUT}": held_out.get(name) for name in names}
        return {**row, "within": is_close(held_out) if CHANGE in held_out else None, **costs}


class Uniform(RowTask):
    """Designs with so many bits in all coefficients and operands each, measured as the trials of a search are."""

    name = "uniform_trials"

    def row(self, job: int) -> dict[str, Any]:
        """The result of a length."""
        trial = self.evaluation(Space.uniform(self._plain, job))
        return {"bits": job, "state": trial.state, **trial.values, "reason": trial.reason}

    def fewest(self, table: pl.DataFrame) -> int | None:
        """The fewest bits that are close, of the table."""
        complete = table.filter(state=COMPLETE)
        close = complete.filter(pl.col(CHANGE) <= CLOSE_PERCENT) if len(complete) else complete
        return min(close["bits"], default=None)

    def design(self, bits: int) -> Design:
        """The design of a length."""
        return Space.design(self._plain, Space.uniform(self._plain, bits))

    @property
    def _plain(self) -> Design:
        """The base with no signal of its own length."""
        base = self.evaluation.base
        return replace(base, formats=replace(base.formats, signals=()))


@dataclass(frozen=True)
class Verified(RowTask):
    """Named designs in RTL, against the bit-accurate model, on the first frames held out."""

    frames: int
    simulator: str | None
    name = "verified"

    def row(self, job: Named) -> dict[str, Any]:
        """Words that were compared, and that differ."""
        from tfra.sim.verify import verify

        blocks = self.evaluation.frames.blocks(Part.HELD_OUT)
        noisy = np.concatenate([block.noisy for block in blocks])[: self.frames].astype(np.float64)
        limit = job.design.adc.full_scale
        report = verify(job.design, np.clip(noisy, -limit, limit), self.simulator, random=0)
        counts = {"rtl_frames": len(noisy), "rtl_words": report.compared, "rtl_differ": report.mismatches}
        return {"name": job.name, "simulator": report.simulator, **counts}


@dataclass(frozen=True)
class Placed(RowTask):
    """Named designs, placed and routed; one that does not fit the part, or on which the tools fail, states so."""

    seeds: int
    clock_mhz: float
    name = "placed"

    def row(self, job: Named) -> dict[str, Any]:
        """Resources, and the median frequency where the part's tools give one."""
        target = self.evaluation.target
        row: dict[str, Any] = {"name": job.name, "part": target.name, f"{PLACED}reason": None}
        try:
            with scratch(temporary()) as folder:
                run = Run(job.design, target, self.seeds, self.clock_mhz, lambda *_: None)
                report = run.write(folder / "fpga")
        except (ToolError, ValueError) as error:
            return row | {f"{PLACED}reason": str(error).splitlines()[0]}
        row |= {f"{PLACED}{name}": facts["used"] for name, facts in report["resources"].items()}
        if clock := report["clock"]:
            row |= {"fmax_mhz": clock["median_mhz"], "seeds": len(clock["seeds"])}
        return row
