"""The designs that a search finds: their errors on held-out frames, in RTL, and placed.

Named designs are ``base``, that of CONFIG; ``uniform``, the one with the fewest bits in all coefficients and operands
whose total error stays close to float's; and for each cost ``least_COST``, the trial that takes least of it and is as
close.  Closeness is judged on the training frames; the table also shows the held-out frames.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import polars as pl

from tfra.model.choices import Formats
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.runtime.processes import ToolError
from tfra.runtime.scratch import scratch, temporary
from tfra.study.errors.cascade import SIGNED
from tfra.study.frames.block import Part
from tfra.study.report.labels import CLOSE_PERCENT
from tfra.study.search.evaluate import CHANGE, COSTS, Evaluation
from tfra.study.search.space import Space
from tfra.study.search.trials import COMPLETE, Trial
from tfra.synth.run import Run


@dataclass(frozen=True)
class Named:
    """A design, and its name in the tables, as a file and as a Verilog module."""

    name: str
    design: TfraDesign


def close(values: Mapping[str, float]) -> bool:
    """Whether a total error is within ``CLOSE_PERCENT`` of float's."""
    return values[CHANGE] <= CLOSE_PERCENT


def chosen(trials: Iterable[Trial], costs: Sequence[str]) -> dict[str, Trial]:
    """For each cost the close trial that takes least of it, then of the others, without repeated trials."""
    good = [trial for trial in trials if trial.state == COMPLETE and close(trial.values)]
    found: dict[str, Trial] = {}
    for cost in costs if good else ():
        order = (cost, *(other for other in costs if other != cost), CHANGE)
        best = min(good, key=lambda trial: (*(trial.values[name] for name in order), trial.number))
        if best.number not in {trial.number for trial in found.values()}:
            found[f"least_{cost.lower()}"] = best
    return found


def named(base: TfraDesign, name: str, design: TfraDesign) -> Named:
    """``design`` as a module with its own name, distinct from ``base``."""
    return Named(name, replace(design, name=f"{base.name[:40]}_{name}"))


def said(formats: Formats) -> str:
    """Word lengths as text."""
    words = f"coefficients {formats.coefficient}, operands {formats.operand}, vectors {formats.vector_fraction} and "
    own = ", ".join(f"{signal} {bits}" for signal, bits in formats.signals)
    return f"{words}forces {formats.force_fraction} below one code" + (f"; {own}" if own else "")


@dataclass(frozen=True)
class Described:
    """The table of named designs.  A row named ``float`` has the errors of float arithmetic on the same codes."""

    designs: tuple[Named, ...]
    evaluation: Evaluation
    name = "designs"
    unit = "designs"
    makes = ("designs",)

    @property
    def jobs(self) -> range:
        """Float arithmetic, then each design."""
        return range(1 + len(self.designs))

    def __call__(self, job: int) -> bytes:
        """The row of a design."""
        parts = [replace(self.evaluation, part=part, costs=COSTS) for part in (Part.TRAIN, Part.HELD_OUT)]
        if not job:
            trained, held_out = (each.exact() for each in parts)
            return _row("float", "double precision", trained, held_out, dict.fromkeys(COSTS))
        design = self.designs[job - 1].design
        trained, held_out = (each.errors(design, each.frames.definition.blocks(each.part)) for each in parts)
        return _row(self.designs[job - 1].name, said(design.formats), trained, held_out, parts[0].taken(design))

    def tables(self, piece: Callable[[int], bytes]) -> Mapping[str, pl.DataFrame]:
        """The table."""
        return {self.name: pl.DataFrame([json.loads(piece(job)) for job in self.jobs], infer_schema_length=None)}


@dataclass(frozen=True)
class Uniform:
    """Designs with ``bits`` in all coefficients and operands each, measured as the trials of a search are."""

    bits: tuple[int, ...]
    evaluation: Evaluation
    name = "uniform_trials"
    unit = "designs"
    makes = ("uniform_trials",)

    @property
    def jobs(self) -> range:
        """The lengths."""
        return range(len(self.bits))

    def __call__(self, job: int) -> bytes:
        """The result of a length."""
        found = self.evaluation(Space.uniform(_plain(self.evaluation.base), self.bits[job]))
        return json.dumps(
            {"bits": self.bits[job], "state": found.state, **found.values, "reason": found.reason}
        ).encode()

    def tables(self, piece: Callable[[int], bytes]) -> Mapping[str, pl.DataFrame]:
        """The table."""
        return {self.name: pl.DataFrame([json.loads(piece(job)) for job in self.jobs], infer_schema_length=None)}

    def chosen(self, table: pl.DataFrame) -> int | None:
        """The fewest bits that are close, of the :meth:`tables`."""
        good = table.filter(pl.col("state") == COMPLETE)
        good = good.filter(pl.col(CHANGE) <= CLOSE_PERCENT) if len(good) else good
        return min(good["bits"], default=None)

    def design(self, bits: int) -> TfraDesign:
        """The design of a length."""
        base = _plain(self.evaluation.base)
        return Space.design(base, Space.uniform(base, bits))


def _plain(base: TfraDesign) -> TfraDesign:
    """``base`` with no signal of its own length."""
    return replace(base, formats=replace(base.formats, signals=()))


def _row(
    name: str,
    words: str,
    trained: Mapping[str, float],
    held_out: Mapping[str, float],
    costs: Mapping[str, float | None],
) -> bytes:
    errors = {key: trained.get(key) for key in (CHANGE, *SIGNED) if key == CHANGE or key in trained}
    beside = {f"{key}_held_out": held_out.get(key) for key in errors}
    within = {"within": close(held_out) if CHANGE in held_out else None}
    return json.dumps({"name": name, "formats": words, **errors, **beside, **within, **costs}).encode()


@dataclass(frozen=True)
class Verified:
    """Named designs in RTL, against the bit-accurate model, on the first frames held out."""

    designs: tuple[Named, ...]
    evaluation: Evaluation
    frames: int
    simulator: str | None
    name = "verified"
    unit = "designs"
    makes = ("verified",)

    @property
    def jobs(self) -> range:
        """The designs."""
        return range(len(self.designs))

    def __call__(self, job: int) -> bytes:
        """The row of a design."""
        from tfra.sim.verify import verify

        each, source = self.designs[job], self.evaluation.frames
        blocks = source.blocks(Part.HELD_OUT)
        noisy = np.concatenate([block.noisy for block in blocks])[: self.frames].astype(np.float64)
        limit = each.design.adc.full_scale
        report = verify(each.design, np.clip(noisy, -limit, limit), self.simulator, random=0)
        counts = {"rtl_frames": len(noisy), "rtl_words": report.compared, "rtl_differ": report.mismatches}
        return json.dumps({"name": each.name, "simulator": report.simulator, **counts}).encode()

    def tables(self, piece: Callable[[int], bytes]) -> Mapping[str, pl.DataFrame]:
        """The table."""
        return {self.name: pl.DataFrame([json.loads(piece(job)) for job in self.jobs])}


@dataclass(frozen=True)
class Placed:
    """Named designs, placed and routed; one that does not fit the part, or on which the tools fail, states so."""

    designs: tuple[Named, ...]
    evaluation: Evaluation
    seeds: int
    clock_mhz: float
    name = "placed"
    unit = "designs"
    makes = ("placed",)

    @property
    def jobs(self) -> range:
        """The designs."""
        return range(len(self.designs))

    def __call__(self, job: int) -> bytes:
        """The row of a design."""
        each, target = self.designs[job], self.evaluation.target
        row: dict[str, Any] = {"name": each.name, "part": target.name, "placed_reason": None}
        try:
            with scratch(temporary()) as place:
                run = Run(each.design, target, self.seeds, self.clock_mhz, lambda forecast: None)
                found = run.write(place / "fpga")
        except (ToolError, ValueError) as error:
            return json.dumps(row | {"placed_reason": str(error).splitlines()[0]}).encode()
        return json.dumps(row | _placed(found)).encode()

    def tables(self, piece: Callable[[int], bytes]) -> Mapping[str, pl.DataFrame]:
        """The table."""
        return {self.name: pl.DataFrame([json.loads(piece(job)) for job in self.jobs], infer_schema_length=None)}


def _placed(found: Mapping[str, Any]) -> dict[str, Any]:
    """Values from a report of synthesis: resources, and the median frequency where the part's tools give one."""
    used = {f"placed_{name}": facts["used"] for name, facts in found["resources"].items()}
    clock = found["clock"]
    speed = {"fmax_mhz": clock["median_mhz"], "seeds": len(clock["seeds"])} if clock else {}
    return used | speed
