"""Cost of a comparator tree over all candidates, compared with the running minimum of the sweep.

``python -m bench.parts.tree`` synthesises the sweep of ``examples/fast.toml``, its winner, and the textbook's way for
the same words: a sum for each candidate and a tree of comparators after them, a register at every level.  It writes
``bench/results/tree.json`` and the table of docs/architecture.md.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from amaranth import Const, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from bench.parts.flat import Flat
from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.codegen.verilog.emit import to_rtlil, with_free_collisions
from tfra.hdl.lib.arithmetic import less
from tfra.hdl.parallel.tfra.sweep.unit import Sweep
from tfra.hdl.parallel.tfra.sweep.winner import Winner, winner_latency
from tfra.model.fixed.design import Design
from tfra.synth.flow import synthesise
from tfra.synth.targets import find

TARGET = "ecp5-45-6"


class Sums(wiring.Component):
    """B^z of every candidate at once: the positive parts of p + mu q, a taxel a cycle, and the same of its complement.

    Members:
        p, q: K p and q of a taxel, so that candidate k adds max(0, p + k q).
        z, xy: the sums of each candidate.
    """

    def __init__(self, design: Design) -> None:
        self._design, w = design, design.widths
        super().__init__(
            {
                "p": In(signed(w.candidate)),
                "q": In(signed(w.vector + 2)),
                "z": Out(data.ArrayLayout(unsigned(w.b_z), design.candidates)),
                "xy": Out(data.ArrayLayout(unsigned(w.b_xy), design.candidates)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m, bits = Module(), self._design.widths.candidate
        value = Signal(signed(bits))
        m.d.sync += value.eq(self.p)
        for k in range(self._design.candidates):
            term = Signal(signed(bits), name=f"term{k}")
            m.d.sync += [
                term.eq(value + self.q),  # each candidate's value comes from that of the one before
                self.z[k].eq(self.z[k] + Mux(term < 0, 0, term)),
                self.xy[k].eq(self.xy[k] + Mux(term < 0, -term, 0)),
            ]
            value = term
        return m


class Tree(wiring.Component):
    """The smallest (z, xy), the first of equals, from a tree of comparators with a register at every level."""

    def __init__(self, design: Design) -> None:
        self._design, w = design, design.widths
        super().__init__(
            {
                "z": In(data.ArrayLayout(unsigned(w.b_z), design.candidates)),
                "xy": In(data.ArrayLayout(unsigned(w.b_xy), design.candidates)),
                "index": Out(design.search.steps.bit_length()),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the sums to the index."""
        return (self._design.candidates - 1).bit_length()

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        row: list[tuple[Value, Value, Value]] = [
            (self.z[k], self.xy[k], Const(k, len(self.index))) for k in range(self._design.candidates)
        ]
        while len(row) > 1:
            pairs = [self._smaller(m, *pair) for pair in zip(row[::2], row[1::2], strict=False)]
            row = pairs + [self._later(m, row[-1])] * (len(row) % 2)
        m.d.comb += self.index.eq(row[0][2])
        return m

    def _smaller(self, m: Module, first: Any, second: Any) -> tuple[Value, Value, Value]:
        after = less(second[0], first[0]) | ((second[0] == first[0]) & less(second[1], first[1]))
        return self._later(m, tuple(Mux(after, b, a) for a, b in zip(first, second, strict=True)))

    @staticmethod
    def _later(m: Module, words: Any) -> Any:
        found = tuple(Signal(len(word), reset_less=True) for word in words)
        m.d.sync += [register.eq(word) for register, word in zip(found, words, strict=True)]
        return found


def measure(name: str, unit: wiring.Component) -> dict[str, int]:
    """Lookup tables and flip-flops of ``unit`` on an ECP5, from yosys."""
    with tempfile.TemporaryDirectory() as folder:
        text = with_free_collisions(to_rtlil(Flat(unit), name))
        found = synthesise(text, name, find(TARGET), Path(folder)).resources
    return {"LUT": found["LUT"], "FF": found["FF"]}


def main() -> None:
    """Measure, store, publish."""
    design = load(ROOT / "examples" / "fast.toml").design
    tree = Tree(design)
    running = winner_latency(design) + -(-design.candidates // 2)
    units: dict[str, tuple[wiring.Component, str]] = {
        "running minimum, two candidates a cycle (`sweep/winner.py`)": (Winner(design), f"{running}"),
        "tree of comparators": (tree, f"{tree.latency}"),
        "the whole `sweep`: terms sorted by where they change their sign, no multiplier": (Sweep(design), ""),
        "a sum for each candidate, in front of the tree": (Sums(design), ""),
    }
    lines = ["| unit, 10×10, K = 100 | LUT | FF | cycles from the first sums to the index |", "|---|---:|---:|---:|"]
    record = {}
    for number, (name, (unit, cycles)) in enumerate(units.items()):
        record[name] = measure(f"unit{number}", unit) | ({"cycles": int(cycles)} if cycles else {})
        lines.append(f"| {name} | {record[name]['LUT']:,} | {record[name]['FF']:,} | {cycles} |")
    publish("tree", record, "\n".join(lines), "docs/architecture.md")


if __name__ == "__main__":
    main()
