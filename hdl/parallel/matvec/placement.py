"""Treatment of the quads that leave the drain register: scale, order of parities, operator."""

from dataclasses import dataclass
from typing import Any

from amaranth import Array, Module, Mux, Signal
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import register
from tfra.hdl.parallel.matvec.images import passes
from tfra.hdl.parallel.matvec.plan import stack_number
from tfra.model.fixed.design import Design


@dataclass(frozen=True)
class Row:
    """A run of consecutive quads from the drain register with the same treatment: its length, and the treatment.

    The result of an operand shifted left by its headroom is shifted right by ``offset + headroom``.  ``kind`` is the
    number of the operator in ``design.kinds``; None marks lanes without a row, whose quads are not sent.
    """

    quads: int
    offset: int
    flip: int
    kind: int | None
    starts_stack: bool


def table(design: Design) -> list[Row]:
    """Rows, stack by stack in the order of the stacks."""
    rows = []
    for name in design.stacks:
        stack = design.stacks[name]
        for number, op in enumerate(stack.operators):
            offset = design.widths.alignment + op.fraction + design.operand_word - design.widths.vector
            rows.append(Row(op.quads, offset, op.flip, design.kinds.index(op.name), number == 0))
        idle = passes(design, name) * design.architecture.mac_lanes // 4 - stack.quads
        if idle:
            rows.append(Row(idle, 0, 0, None, False))
    return rows


def placement(design: Design) -> data.StructLayout:
    """``offset``: of the right shift; ``flip``: slot s is parity s ^ flip; ``kind``: one bit set; ``send``: or none."""
    top = max(row.offset for row in table(design))
    return data.StructLayout({"offset": counter_shape(top), "flip": 2, "kind": len(design.kinds), "send": 1})


class Placement(wiring.Component):
    """Steps through :func:`table` quad by quad; a product's first pass jumps to its stack."""

    def __init__(self, design: Design) -> None:
        self._table = table(design)
        super().__init__({
            "completing": In(1),  # the sums of a pass will be captured in the next cycle
            "new": In(1),  # in the same cycle as ``completing``, it is the first pass of its product
            # In the same cycle as ``completing``, that of the product in design.stacks.
            "stack": In(stack_number(design)),
            "leave": In(1),  # the last words of a quad leave the drain register
            "quad": Out(placement(design)),  # placement of that quad
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        row_number = Signal(counter_shape(len(self._table) - 1))
        quad_number = Signal(counter_shape(max(row.quads for row in self._table) - 1))  # of the row
        ends_row = Signal()
        with m.Switch(row_number):
            for number, row in enumerate(self._table):
                with m.Case(number):
                    m.d.comb += [
                        self.quad.offset.eq(row.offset),
                        self.quad.flip.eq(row.flip),
                        self.quad.kind.eq(0 if row.kind is None else 1 << row.kind),
                        self.quad.send.eq(row.kind is not None),
                        ends_row.eq(quad_number == row.quads - 1),
                    ]
        with m.If(self.leave):
            m.d.sync += quad_number.eq(Mux(ends_row, 0, quad_number + 1))
            m.d.sync += row_number.eq(row_number + ends_row)
        starts = [number for number, row in enumerate(self._table) if row.starts_stack]
        start = register(m, Array(starts)[self.stack], "start")
        with m.If(register(m, self.completing & self.new, "starts", control=True)):
            m.d.sync += quad_number.eq(0)
            m.d.sync += row_number.eq(start)
        return m
