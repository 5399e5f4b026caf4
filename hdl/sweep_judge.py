"""The sweep's choice among all candidates, from their sums."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.arithmetic import count
from tfra.hdl.comparator_tree import ComparatorTree
from tfra.hdl.pipeline import delayed
from tfra.hdl.sweep_lanes import lane_levels
from tfra.model.design import Design
from tfra.model.fixed.sweep import tolerance
from tfra.model.fixed.widths import widths


def limit_latency(design: Design) -> int:
    """Cycles from the comparator tree's output to the largest B^z of the plateau; an adder if there is a tolerance."""
    return 2 if tolerance(design).any() else 1


def judge_latency(design: Design) -> int:
    """Cycles from the sums of the last pass to the index: twice through the tree, two turns for every row."""
    return 3 + 2 * lane_levels(design) + limit_latency(design) + 2 * design.sweep_passes


class Judge(wiring.Component):
    """Choose: smallest B^xy of those within the tolerance of the smallest B^z, the first of equals.

    B^z of a row enters the tree as the pass ends; ``lowest`` is the minimum over the rows.  When it stands, every
    row enters twice: ``v = xy`` where it is not negative, then ``-v - 1`` where it is, so that one adder behind
    the tree instead of one per lane makes |v|.  Last, (|v|, number) is compared with the best so far.

    Resources: a comparator per lane, a :class:`ComparatorTree` of P keys, a memory of the rows if there are several.
    """

    def __init__(self, design: Design) -> None:
        self._design, w = design, widths(design)
        lanes = design.architecture.sweep_lanes
        super().__init__(
            {
                "z": In(unsigned(w.b_z)).array(lanes),
                "xy": In(signed(w.b_xy + 1)).array(lanes),
                "ended": In(1),  # the cycle before a row stands
                "stands": Out(1),  # the cycle in which z and xy are a row
                "idle": In(1),
                "exponent": In(count(design.adc.bits - 1)),
                "found": Out(1),  # a pulse, one cycle before index stands
                "index": Out(payloads.sweep_index(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        passes, lanes, bits = self._design.sweep_passes, len(self.z), widths(self._design).b_xy + 1
        m.submodules.tree = tree = ComparatorTree(lanes, bits)
        row, final = Signal(count(passes - 1)), Signal()
        m.d.sync += self.stands.eq(self.ended)
        m.d.comb += final.eq(row == passes - 1)
        with m.If(self.stands):
            m.d.sync += row.eq(row + 1)
        with m.If(self.idle):
            m.d.sync += row.eq(0)
        # The first keys reach the limit's comparators in the cycle in which it stands, two behind their turn.
        begin = delayed(m, self.ended & final, tree.latency + limit_latency(self._design) - 1, control=True)
        turn, turning, last_turn = self._turns(m, begin)
        rows = self._rows(m, row, turn)
        limit = self._limit(m, tree)
        self._keys(m, tree, rows, limit, final, delayed(m, turn, 2))
        valid = delayed(m, turning, 3 + tree.latency, control=True)
        self._best(m, tree, valid)
        m.d.comb += self.found.eq(delayed(m, last_turn, 4 + tree.latency, control=True))
        return m

    def _turns(self, m: Module, begin: Value) -> tuple[Signal, Signal, Value]:
        """Count every row twice."""
        last = 2 * self._design.sweep_passes - 1
        turn, turning, ends = Signal(count(last)), Signal(), Signal()
        m.d.comb += ends.eq(turning & (turn == last))
        with m.If(turning):
            m.d.sync += turn.eq(turn + 1)
        with m.If(ends):
            m.d.sync += turning.eq(0)
        with m.If(begin):
            m.d.sync += [turn.eq(0), turning.eq(1)]
        return turn, turning, ends

    def _rows(self, m: Module, row: Value, turn: Value) -> list[tuple[Value, Value]]:
        """B^z and xy of every lane, two cycles behind ``turn``; a single row stays in the lanes."""
        pairs = list(zip(self.z, self.xy, strict=True))
        if self._design.sweep_passes == 1:
            return pairs
        return [self._row(m, Cat(*pair), row, turn) for pair in pairs]

    def _row(self, m: Module, pair: Value, row: Value, turn: Value) -> tuple[Value, Value]:
        """One lane's pairs; a memory of its own, since some tools choke on a word of thousands of bits."""
        rows = Memory(shape=unsigned(len(pair)), depth=self._design.sweep_passes, init=[])
        m.submodules += rows
        write, read = rows.write_port(), rows.read_port()
        m.d.comb += [
            write.addr.eq(row),
            write.en.eq(self.stands),
            write.data.eq(pair),
            read.addr.eq(turn >> 1),
            read.en.eq(1),
        ]
        held, bits = delayed(m, read.data, 1), widths(self._design).b_z
        return held[:bits], held[bits:].as_signed()

    def _limit(self, m: Module, tree: ComparatorTree) -> Value:
        """The largest B^z of the plateau: minimum over the rows plus tolerance."""
        bits = widths(self._design).b_z
        lowest, least = Signal(bits, reset_less=True), tree.least[:bits]
        fresh = delayed(m, self.stands, 1 + tree.latency, control=True)
        with m.If(fresh & (least < lowest)):
            m.d.sync += lowest.eq(least)
        with m.If(self.idle):
            m.d.sync += lowest.eq((1 << bits) - 1)
        if not tolerance(self._design).any():
            return lowest
        slack, limit = Signal(bits, reset_less=True), Signal(bits + 1, reset_less=True)
        with m.Switch(self.exponent):
            for exponent, value in enumerate(tolerance(self._design)):
                with m.Case(exponent):
                    m.d.sync += slack.eq(int(value))
        m.d.sync += limit.eq(lowest + slack)
        return limit

    def _keys(
        self,
        m: Module,
        tree: ComparatorTree,
        rows: list[tuple[Value, Value]],
        limit: Value,
        final: Value,
        turn: Value,
    ) -> None:
        """Tree's input: B^z of the row that stands, else xy (or its complement) of a row from the memory.

        Lanes of the last row beyond candidate K get a one on top, as do those that this turn is not for.
        """
        passes, bits, lanes = self._design.sweep_passes, widths(self._design).b_xy, len(rows)
        mirrored, in_last = turn[0], (turn >> 1) == passes - 1
        for lane, (z, xy) in enumerate(rows):
            beyond = (passes - 1) * lanes + lane >= self._design.candidates
            key = Signal(bits + 1, reset_less=True)
            distance = (xy ^ mirrored.replicate(bits + 1))[: bits + 1]
            out = (z > limit) | distance[bits] | (in_last & beyond)
            m.d.sync += key.eq(Cat(distance[:bits], out))
            with m.If(self.stands):
                m.d.sync += key.eq(self.z[lane] | ((final & beyond) << bits))
            m.d.comb += tree.keys[lane].eq(key)

    def _best(self, m: Module, tree: ComparatorTree, valid: Value) -> None:
        """Smallest (|v|, number) of all turns; the numbers of a row begin at ``base``."""
        lanes, bits = self._design.architecture.sweep_lanes, widths(self._design).b_xy
        number = count(self._design.sweep_passes * lanes - 1).width
        base, mirrored = Signal(number), Signal()
        layout = data.StructLayout({"number": number, "distance": bits, "out": 1})
        entry, best = Signal(layout, reset_less=True), Signal(layout, reset_less=True)
        m.d.sync += [
            entry.number.eq(base + tree.place),
            entry.distance.eq(tree.least[:bits] + mirrored),
            entry.out.eq(tree.least[bits]),
        ]
        with m.If(valid):
            m.d.sync += [mirrored.eq(~mirrored), base.eq(Mux(mirrored, base + lanes, base))]
        entered = delayed(m, valid, 1, control=True)
        with m.If(entered & (entry.as_value() < best.as_value())):
            m.d.sync += best.eq(entry)
        with m.If(self.idle):
            m.d.sync += [base.eq(0), mirrored.eq(0), best.as_value().eq((1 << layout.size) - 1)]
        m.d.comb += self.index.eq(best.number)
