"""Treatment of the quads that leave the drain register: scale, order of parities, operator."""

from dataclasses import dataclass

from amaranth import Array, Module, Mux, Signal, Value
from amaranth.lib import data

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import register
from tfra.hdl.parallel.matvec.images import passes
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


def placements(m: Module, design: Design, new: Value, stack: Value, leave: Value) -> data.View:
    """Placement of the quad whose words leave the drain register, the last ones in the cycle of ``leave``.

    ``offset``: of the right shift; ``flip``: slot s is parity s ^ flip; ``kind``: one bit set; ``send``: or none.
    Steps through :func:`table` quad by quad; ``new``, a cycle before the first pass of a product is captured, jumps to
    its ``stack``.
    """
    rows = table(design)
    offset = counter_shape(max(row.offset for row in rows))
    quad = Signal(data.StructLayout({"offset": offset, "flip": 2, "kind": len(design.kinds), "send": 1}))
    row_number = Signal(counter_shape(len(rows) - 1))
    quad_number = Signal(counter_shape(max(row.quads for row in rows) - 1))  # of the row
    ends_row = Signal()
    with m.Switch(row_number):
        for number, row in enumerate(rows):
            with m.Case(number):
                m.d.comb += [
                    quad.offset.eq(row.offset),
                    quad.flip.eq(row.flip),
                    quad.kind.eq(0 if row.kind is None else 1 << row.kind),
                    quad.send.eq(row.kind is not None),
                    ends_row.eq(quad_number == row.quads - 1),
                ]
    with m.If(leave):
        m.d.sync += quad_number.eq(Mux(ends_row, 0, quad_number + 1))
        m.d.sync += row_number.eq(row_number + ends_row)
    start = register(m, Array(number for number, row in enumerate(rows) if row.starts_stack)[stack], "start")
    with m.If(register(m, new, "starts", control=True)):
        m.d.sync += quad_number.eq(0)
        m.d.sync += row_number.eq(start)
    return quad
