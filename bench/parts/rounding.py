"""Cells and precision of other roundings of the lanes' results.

``python -m bench.parts.rounding`` measures a word's path through the drain with each rounding of
:mod:`tfra.study.errors.rounding`.  It writes ``bench/results/rounding.json`` and the table in docs/numerics.md.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Any

from amaranth import Cat, Const, Module, Value, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from bench.publish import publish
from tfra.codegen.config.cover import LayerSpec
from tfra.codegen.verilog.emit import to_rtlil
from tfra.hdl.lib.arithmetic import counter_shape, round_half, shift_right, two_steps
from tfra.hdl.lib.pipeline import driver, register
from tfra.hdl.parallel.matvec.drain import FINE, on_grid
from tfra.hdl.parallel.matvec.placement import table
from tfra.model.choices import FORMATS
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.cascade import View
from tfra.study.errors.rounding import Rounding
from tfra.study.errors.variants import variants
from tfra.study.errors.variation import Comparison
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.frames.schema import FramesSection
from tfra.study.workers import processes
from tfra.synth.flow import synthesise
from tfra.synth.targets import Target, find

DESIGNS = {
    "10×10, `standard`": TfraDesign(SENSORS["10×10, 4×2 mm, h 3 mm"]),
    "10×10, `wide`": TfraDesign(SENSORS["10×10, 4×2 mm, h 3 mm"], formats=FORMATS["wide"]),
    "5×7, `standard`": TfraDesign(SENSORS["5×7, 3×3 mm, h 2 mm"]),
}
TARGETS = {"ECP5": find("ecp5-45-6"), "iCE40": find("ice40up5k"), "7-series": find("xc7")}
KINDS = ("LUT[1-6]|INV|SB_LUT4", "CCU2C|SB_CARRY|CARRY4", "TRELLIS_FF|SB_DFF|FDRE")
"""LUT, carry cells, FF; a carry cell of ECP5 is two LUTs, one of 7-series is four bits long."""
WAYS = {"way": "", "unhurried": "scratchpad -set abc9.D 100000; "}
"""Commands before those of synthesis; with 100 ns for a path, yosys' mapper looks for few cells alone."""
CONTACTS = {
    "weight": 1,
    "shape": ["hertz", "rounded", "uniform"],
    **{key: {"from": 0.8, "to": 2, "log": True} for key in ("half_x_pitches", "half_y_pitches")},
    **{key: {"from": 0, "to": 1} for key in ("center_x_share", "center_y_share", "mu")},
    "force_n": {"from": -10, "to": -1},
    "phi_deg": {"from": 0, "to": 360},
}


class Finish(wiring.Component):
    """From the shifted word to the result: what differs between roundings.

    Half even rounds a half up only if a bit below it is set or the word is odd: ``gone`` and ``rest`` tell of these
    bits, a step of the shift each.  All inputs are registers that the drain has.

    Members:
        total, amount: the exact sum and its right shift.
        coarse, fine: a cycle later, the lowest bits after the shift's first step, and how far the second goes.
        shifted: a cycle later, the word with one bit below the point.
        result: a cycle later, the rounded word.
    """

    def __init__(self, design: Design, rounding: Rounding) -> None:
        self._rounding, self._alignment, w = rounding, design.widths.alignment, design.widths
        super().__init__(
            {
                "total": In(signed(w.accumulator)),
                "amount": In(counter_shape(max(row.offset for row in table(design)) + w.vector - 1)),
                "coarse": In((1 << FINE) - 1),
                "fine": In(FINE),
                "shifted": In(signed(w.vector + 1)),
                "result": Out(signed(w.vector)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        word = self.shifted
        if self._rounding is Rounding.HALF_EVEN:
            word = Cat(word[0] & (self._rest(m) | word[1]), word[1:]).as_signed()
        whole = word[1:].as_signed() if self._rounding is Rounding.TRUNCATE else round_half(word)
        m.d.sync += driver(m, self.result).eq(whole)
        return m

    def _rest(self, m: Module) -> Value:
        """Whether any bit is set below the one below the point."""
        size, steps = 1 << FINE, self.amount[FINE:]
        below = Cat(Const(0, self._alignment + 1), self.total)
        groups = [below[low : low + size].any() for low in range(0, len(below), size)]
        gone = reduce(or_, (some & (steps > number) for number, some in enumerate(groups)))
        left = reduce(or_, (bit & (self.fine > number) for number, bit in enumerate(self.coarse)))
        return register(m, register(m, gone, "gone") | left, "rest")


class Word(wiring.Component):
    """The way of one word through the drain, four cycles: ``sum``, to the right by ``shift``, rounded to ``result``.

    A word starts ``alignment`` places further left than the grid, so that shorter shifts move it to the left.
    """

    def __init__(self, design: Design, rounding: Rounding) -> None:
        self._design, self._finish = design, Finish(design, rounding)
        ports = self._finish.signature.members
        super().__init__({"sum": ports["total"], "shift": ports["amount"], "result": ports["result"]})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.finish = finish = self._finish
        total, amount = register(m, self.sum), register(m, self.shift)  # on_grid's, again: yosys merges them
        coarse, fine = two_steps(amount, FINE)
        wide = Cat(Const(0, self._design.widths.alignment), total).as_signed()
        m.d.comb += [
            finish.total.eq(total),
            finish.amount.eq(amount),
            finish.coarse.eq(register(m, shift_right(wide, coarse)[: len(finish.coarse)])),
            finish.fine.eq(register(m, fine)),
            finish.shifted.eq(on_grid(m, self._design, 0, self.sum, self.shift)),
            self.result.eq(finish.result),
        ]
        return m


def cells(unit: wiring.Component, target: Target, before: str = "") -> dict[str, int]:
    """Cells of ``unit`` by their types; ``before`` are commands before those of the family."""
    chosen = replace(target, family=replace(target.family, synthesis=before + target.family.synthesis))
    with tempfile.TemporaryDirectory() as folder:
        found = synthesise(to_rtlil(unit, "unit"), "unit", chosen, Path(folder)).cells
    return {kind: found[kind] for kind in sorted(found) if not re.fullmatch(r"[IO]BUF|BUFG|\$.*", kind)}


def kinds(found: Mapping[str, int]) -> list[int]:
    """Cells by ``KINDS``."""
    return [sum(number for kind, number in found.items() if re.fullmatch(each, kind)) for each in KINDS]


def worth(design: TfraDesign, frames: int) -> dict[str, dict[str, float]]:
    """For each rounding, the arithmetic's own errors by quantity: their 95th percentiles on contacts."""
    section = FramesSection.model_validate({"train": frames, "held_out": 0, "seed": 18, "mixture": [CONTACTS]})
    layer = LayerSpec(poisson=0.48, sampling="point")
    with tempfile.TemporaryDirectory() as folder, processes(2) as workers:
        made = FrameSet.create(Path(folder), Definition.of(Path(folder), design.sensor, layer, section))
        made.complete()
        comparison = Comparison(made, Part.TRAIN, variants(design, steps=(), tolerances=()))
        jobs = comparison.jobs(len(comparison.variations))
        done = dict(workers(comparison, jobs))
        rows = comparison.table(jobs, [done[place] for place in range(len(jobs))]).to_dicts()
    own = [row for row in rows if row["view"] == View.OWN]
    return {each: {row["quantity"]: row["p95"] for row in own if row["rounding"] == each} for each in Rounding}


def measure(design: TfraDesign, rounding: Rounding) -> dict[str, Any]:
    """Cells of the finish, unhurried, on every target, and of the whole way on ECP5."""
    unhurried, finish = WAYS["unhurried"], Finish(design, rounding)
    found = {family: cells(finish, target, unhurried) for family, target in TARGETS.items()}
    return {"finish": found} | {way: cells(Word(design, rounding), TARGETS["ECP5"], WAYS[way]) for way in WAYS}


def row(name: str, rounding: Rounding, facts: Mapping[str, Any]) -> str:
    """Markdown of one rounding of a design; cells of the finish are those of half up, or how many more or less."""
    found, base, paid = facts[rounding], facts[Rounding.HALF_UP], []
    for family in TARGETS:
        here, there = kinds(found["finish"][family]), kinds(base["finish"][family])
        more = [f"{one - other:+}".replace("-", "−").replace("+0", "0") for one, other in zip(here, there, strict=True)]
        paid.append(", ".join(map(str, here) if found is base else more))
    errors = found["errors"]["force_difference_percent_of_true_force"] * 1e4, found["errors"]["mu"] * 1e6
    ways = [str(kinds(found[way])[0]) for way in WAYS]
    return f"| {' | '.join([name, rounding.replace('_', ' '), *paid, *ways, *map('{:.3g}'.format, errors)])} |"


def main() -> None:
    """Measure, store, publish."""
    record: dict[str, dict[str, Any]] = {}
    for name, design in DESIGNS.items():
        errors = worth(design, 4096)
        record[name] = {each: measure(design, each) | {"errors": errors[each]} for each in Rounding}
    lines = [
        f"| design | rounding | {' | '.join(TARGETS)} | way, LUT4 of ECP5 | unhurried | F off, ppm | μ off, 10⁻⁶ |",
        "|---|---|" + "---:|" * 7,
        *(row(name, rounding, facts) for name, facts in record.items() for rounding in Rounding),
    ]
    publish("rounding", record, "\n".join(lines), "docs/numerics.md")


if __name__ == "__main__":
    main()
