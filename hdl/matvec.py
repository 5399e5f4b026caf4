"""Matrix-vector products on L lanes: block-normalised operands times folded coefficients.

A frame is the five products of :data:`tfra.model.fixed.coefficients.PRODUCTS`, and for each of them

    result[i, p] = round(2^-shift * sum_j rows[i, p, j] * operand[j, s]),    s = p ^ flip,
    shift = fraction + operand - 1 - significant[s]

as :mod:`tfra.model.fixed.matvec` has it.  Row (i, p) is known by its slot ``s``, so that lane ``l`` always works on
word ``l % 4`` of the operand quad, and the operator's ``flip`` permutes nothing but finished results.

    operand -> two banks of Q quads -> align -> round to operand bits -> W = min(4, L) words, broadcast
                 |  significant bits                                       |
                 v                                  coefficient memory -> multiply -> accumulate    (L times)
               amounts by pass                                                            |
                 |                                              capture in the drain register, W words a cycle
                 +------------------------------------------------> shift -> round, permute -> result

A *pass* reads the Q quads of a bank once and ends with L exact sums; rows ``t L ... t L + L - 1`` are pass ``t``.
Lanes never freeze.  A pass is launched only when the pass before the last has left the drain register: then the
last one finds it free when its sums are complete, or at the latest before the sums are overwritten.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from amaranth import Cat, Elaboratable, Module, Mux, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory, ReadPort
from amaranth.lib.wiring import In, Out

from tfra.codegen.images import bases, lane_images, passes
from tfra.hdl.arithmetic import count
from tfra.hdl.matvec_drain import Drain
from tfra.hdl.matvec_operand import OperandBuffer, Prepare
from tfra.hdl.matvec_schedule import Schedule
from tfra.hdl.payloads import vector_quad
from tfra.hdl.pipeline import delayed
from tfra.model.design import Design
from tfra.model.fixed.coefficients import PRODUCTS, stacks
from tfra.model.fixed.widths import widths

FULL = 2
"""Cycles from the last operand quad's transfer to the launch that finds it: OR of magnitudes, amounts."""
_LOAD = FULL + 1
"""Cycles from there to the first read."""
_ADDRESS = 2
"""Stages from a buffer address to the coefficient address of the same quad, so that both words meet in the lane."""
CAPTURE = 7
"""Cycles from a quad's read to sums that hold its products."""
DRAIN = 5
"""Cycles from the capture of sums to their first result: drain register, amounts, shift, rounding, output."""
_RETURN = 8
"""Cycles between the read of a pass's last quad and that of the pass after the next, beside the draining."""


class MatVec(wiring.Component):
    """All matrix-vector products of a frame.

    Latency: see :meth:`latency` and :meth:`duration`; throughput: :attr:`interval`.

    Resources: L multipliers (coefficient x operand) with registers on both sides, L read-only memories of
    ``depth`` coefficients with output registers, a memory of 2 Q quads, 2 W barrel shifters.

    Members:
        operand: stream in, Q quads of parities for each of ``PRODUCTS`` in turn.
        result: stream out, after each operand the result quads of its stack, operator by operator.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self._lanes = design.architecture.mac_lanes
        self._words = min(4, self._lanes)
        self._sum_quads = max(1, self._lanes // 4)
        shape = stream.Signature(vector_quad(design))
        super().__init__({"operand": In(shape), "result": Out(shape)})

    @property
    def depth(self) -> int:
        """Coefficients of one lane."""
        return sum(passes(self._design, name) * self._design.quads for name in bases(self._design))

    @property
    def multiplications(self) -> int:
        """Products of a frame that count; lanes that have no row left in a last pass multiply by zero besides."""
        return sum(4 * stacks(self._design)[name].quads * self._design.quads for name in PRODUCTS)

    @property
    def pair_interval(self) -> int:
        """Cycles from the launch of a pass to that of the pass after the next: ``max(2 Q, Q + ceil(L / 4) + 8)``.

        The first of the two follows after Q cycles.
        """
        q = self._design.quads
        return max(2 * q, q + self._sum_quads + _RETURN)

    @property
    def interval(self) -> int:
        """Cycles per frame while operands are always there and results are always taken.

        The mean of two frames, rounded up: with an odd number of passes long and short frames can alternate.
        """
        total = sum(passes(self._design, name) for name in PRODUCTS)
        return -(-total * self.pair_interval // 2)

    def passes(self, stack: str) -> int:
        """Times the operand of ``stack`` runs past the lanes."""
        return passes(self._design, stack)

    def latency(self, stack: str) -> int:
        """Cycles from the transfer of the last operand quad to the first result of an otherwise idle unit."""
        return self._result_cycle(0)

    def duration(self, stack: str) -> int:
        """Cycles from the transfer of the last operand quad to the last result of an otherwise idle unit."""
        return self._result_cycle(stacks(self._design)[stack].quads - 1)

    def _result_cycle(self, number: int) -> int:
        """Cycles from the last operand quad to result quad ``number``: pass, then place in the drain register."""
        turn, row = divmod(4 * number + 3, self._lanes)
        launch = turn // 2 * self.pair_interval + turn % 2 * self._design.quads
        return _LOAD + launch + self._design.quads - 1 + CAPTURE + DRAIN + row // 4

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design = self._design
        m.submodules.buffer = buffer = OperandBuffer(design)
        m.submodules.schedule = schedule = Schedule(design)
        m.submodules.prepare = prepare = Prepare(design)
        m.submodules.drain = drain = Drain(design)
        wiring.connect(m, buffer.operand, wiring.flipped(self.operand))
        wiring.connect(m, wiring.flipped(self.result), drain.result)
        self._control(m, buffer, schedule, prepare, drain)
        address = delayed(m, schedule.address, _ADDRESS, "address")
        first = delayed(m, schedule.first, CAPTURE - 1, "first")
        valid = delayed(m, schedule.reading, CAPTURE - 1, "valid", control=True)
        m.d.comb += drain.complete.eq(delayed(m, schedule.last, CAPTURE, "last", control=True))
        for number, image in enumerate(lane_images(design)):
            m.submodules[f"lane{number}"] = lane = _Lane(design, image)
            m.d.comb += [
                lane.address.eq(address),
                lane.word.eq(prepare.words[number % self._words]),
                lane.first.eq(first),
                lane.valid.eq(valid),
                drain.sums[number].eq(lane.sum),
            ]
        return m

    def _control(self, m: Module, buffer: OperandBuffer, schedule: Schedule, prepare: Prepare, drain: Drain) -> None:
        """Amounts travel by the parity of the pass: both places are in use from launch until drained."""
        amounts = Signal.like(buffer.amounts, name="amounts", reset_less=True)
        with m.If(schedule.launch):
            m.d.sync += amounts[schedule.parity].eq(buffer.amounts[schedule.bank])
        m.d.comb += [
            buffer.read.eq(Cat(schedule.quad, schedule.read_bank)),
            buffer.free.eq(schedule.free),
            schedule.full.eq(buffer.full),
            schedule.drained.eq(drain.drained),
            prepare.quad.eq(buffer.quad),
            drain.amounts.eq(amounts[schedule.oldest]),
        ]
        parity, part = Signal(), Signal.like(schedule.read_part, reset_less=True)
        m.d.sync += [parity.eq(schedule.read_parity), part.eq(schedule.read_part)]
        m.d.comb += [prepare.amounts.eq(amounts[parity]), prepare.part.eq(part)]


class _Lane(Elaboratable):
    """Coefficient memory, multiplier and accumulator.

        address -> memory -> register -> coefficient -+
                                                      * -> product -> + -> sum
        word -----------------------------> operand --+               ^-- 0 if first

    ``word`` comes two cycles after its address, ``valid`` and ``first`` four after it; ``sum`` a cycle later.
    """

    def __init__(self, design: Design, image: np.ndarray[Any, np.dtype[np.int64]]) -> None:
        formats = design.formats
        self._image, self._shape = [int(word) for word in image], signed(formats.coefficient)
        self.address = Signal(count(len(self._image) - 1))
        self.word = Signal(signed(formats.operand))
        self.first, self.valid = Signal(), Signal()
        self.sum = Signal(signed(widths(design).accumulator), reset_less=True)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.memory = memory = Memory(shape=self._shape, depth=len(self._image), init=self._image)
        port: ReadPort = memory.read_port()
        fetched = Signal(self._shape, reset_less=True)
        coefficient = Signal(self._shape, reset_less=True)
        operand = Signal.like(self.word, reset_less=True)
        product = Signal(signed(len(coefficient) + len(operand)), reset_less=True)
        m.d.comb += port.addr.eq(self.address)
        m.d.sync += [
            fetched.eq(port.data),
            coefficient.eq(fetched),
            operand.eq(self.word),
            product.eq(coefficient * operand),
        ]
        with m.If(self.valid):
            m.d.sync += self.sum.eq(product + Mux(self.first, 0, self.sum))
        return m
