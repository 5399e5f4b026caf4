"""Operands of the matrix-vector unit: banks of quads, shifted left by their headroom and rounded for the lanes."""

from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, magnitude_bits, round_top, two_steps
from tfra.hdl.lib.pipeline import READ, delayed, register, registered_zeros, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.parallel.matvec.plan import Source
from tfra.hdl.parallel.payloads import vector_quad
from tfra.model.fixed.design import Design


def headroom_quad(design: Design) -> data.ArrayLayout:
    """Headroom of the four parities of an operand: the left shifts that align them."""
    return data.ArrayLayout(unsigned((design.widths.vector - 1).bit_length()), 4)


MEASURE = 2
"""Cycles from an operand's last quad to its headroom in a register, less one: magnitudes, half of the zeros."""
_FINE = 2
"""Bits of a headroom by which the second step of a shift moves."""


class OperandBuffer(wiring.Component):
    """Banks of operand quads, and the left shift of each parity that fills its word; banks are used in turn.

    Words may have fewer bits than a vector's: codes have no fraction, units have fewer above the point.  Where they are
    ``flowing``, quads of the bank, which is the only one, come in every cycle from the first to the last: it is read
    while they come, and nothing is measured.
    """

    def __init__(self, design: Design, source: Source) -> None:
        self._design, self._banks, self._flowing = design, source.banks, source.flowing(design)
        self._quads, self._fraction = source.quads(design), 0 if source.token else design.formats.vector_fraction
        shape = source.words(design)
        super().__init__({
            "operand": In(stream.Signature(shape)),  # a bank's quads one after the other
            "filling": Out(1),  # the bank that transfers go to
            "head": Out(1),  # the bank to be read next
            # The head may be read; rises ``MEASURE + 1`` cycles after the transfer of its last quad, or, where they
            # are ``flowing``, a cycle after that of its first.
            "full": Out(1),
            "headroom": Out(headroom_quad(design)),  # that of the head, valid while ``full``
            "read": In(counter_shape(self._quads - 1).width + 1),  # quad and, above it, bank to be read
            "quad": Out(vector_quad(design)),  # what is read, ``READ`` cycles later
            # For one cycle: the head may be written, from the next cycle on; the next bank becomes the head.
            "free": In(1),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        depth = 1 << len(self.read) if self._banks == 2 else self._quads
        shape, transfer, ended = self.operand.p.shape(), Signal(), Signal()
        memory = Ram(m, "memory", shape, depth)
        number, last = wrapping_counter(m, transfer, self._quads, "quad_number")
        memory.write(transfer, Cat(number, self.filling), self.operand.p)
        stored = data.View(shape, delayed(m, memory.read(self.read).as_value(), READ - 1, "stored"))
        m.d.comb += [
            transfer.eq(self.operand.valid & self.operand.ready),
            ended.eq(transfer & last),
            *(word.eq(short << self._fraction) for word, short in zip(self.quad, stored, strict=True)),
        ]
        if self._banks == 2:
            m.d.sync += self.filling.eq(self.filling ^ ended)
            m.d.sync += self.head.eq(self.head ^ self.free)
        if self._flowing:
            self._track_flowing_bank(m, transfer, last)
        else:
            self._track_banks(m, transfer, ended, number == 0)
        return m

    def _track_flowing_bank(self, m: Module, transfer: Value, last: Value) -> None:
        """The bank is read while its quads come; the next frame's first quad waits until it is free.

        ===========  ========  =========  =========  ============================================================
        state        ``full``  ``first``  ``waits``  next state
        ===========  ========  =========  =========  ============================================================
        empty        0         1          0          filling with the first quad
        filling      1         0          0          waiting with the last quad; freed when its last pass has begun
        freed        0         0          0          empty with the last quad
        waiting      1         1          1          empty when its last pass has begun
        ===========  ========  =========  =========  ============================================================
        """
        first = Signal(init=1)
        waits = Signal()
        with m.If(transfer):
            m.d.sync += first.eq(last)
        with m.If(self.free):
            m.d.sync += self.full.eq(0)
            m.d.sync += waits.eq(0)
        with m.Elif(transfer):
            m.d.sync += self.full.eq(self.full | first)
            m.d.sync += waits.eq(last & (self.full | first))
        m.d.comb += self.operand.ready.eq(~waits)
        for parity in range(4):
            m.d.comb += self.headroom[parity].eq(self._spare_bits)

    @property
    def _spare_bits(self) -> int:
        """Bits of a vector word above one that has fewer."""
        return self._design.widths.vector - self._fraction - len(self.operand.p[0])

    def _track_banks(self, m: Module, transfer: Value, ended: Value, first: Value) -> None:
        """Occupied banks, and full banks: ``MEASURE`` cycles later, when their headroom is known."""
        occupied = Signal(self._banks)
        full = Signal(self._banks)
        done = delayed(m, ended, MEASURE, "done", control=True)
        done_bank = delayed(m, self.filling, MEASURE, "done_bank", control=True)
        m.d.sync += [
            occupied.eq((occupied | (ended << self.filling)) & ~(self.free << self.head)),
            full.eq((full | (done << done_bank)) & ~(self.free << self.head)),
        ]
        m.d.comb += [
            self.operand.ready.eq(~occupied.bit_select(self.filling, 1)),
            self.full.eq(full.bit_select(self.head, 1)),
            self.headroom.eq(Array(self._measure(m, transfer, first, done, done_bank))[self.head]),
        ]

    def _measure(self, m: Module, transfer: Value, first: Value, done: Value, bank: Value) -> list[Value]:
        """OR of magnitudes while a bank fills; leading zeros when it is full."""
        shape = headroom_quad(self._design)
        headroom = [Signal(shape, name=f"bank{number}_headroom", reset_less=True) for number in range(self._banks)]
        for parity in range(4):
            mask = Signal(len(self.operand.p[parity]) - 1, name=f"mask{parity}", reset_less=True)
            with m.If(transfer):
                m.d.sync += mask.eq(Mux(first, 0, mask) | magnitude_bits(self.operand.p[parity]))
            zeros = registered_zeros(m, Cat(mask, Const(0, self._spare_bits)))
            for number, stored in enumerate(headroom):
                with m.If(done & (bank == number)):
                    m.d.sync += stored[parity].eq(zeros)
        return [a.as_value() for a in headroom]


def operand_lengths(design: Design) -> list[int]:
    """Bits of the operands of each stack's products."""
    return [design.formats.bits(f"operand.{name}") for name in design.stacks]


def lengths_differ(design: Design) -> bool:
    """Whether rounding an operand depends on its product."""
    return len(set(operand_lengths(design))) > 1


PREPARE = 4
"""Cycles from a quad of a buffer to its operand words."""


def prepared(m: Module, design: Design, quad: Any, headroom: Any, stack: Value | None) -> Any:
    """Operand words of a ``quad`` of a buffer, aligned by the ``headroom`` in two steps, then rounded: ``PREPARE``
    registers.

    ::

        raw, shift -> coarse -> aligned -> words

    ``stack``: number of the product's in design.stacks, where lengths differ.  Words of a product with shorter operands
    end in zeros, so that all have their point in the same place.
    """
    vector = design.widths.vector
    words = Signal(data.ArrayLayout(signed(design.operand_word), 4), reset_less=True)
    stack = None if stack is None else delayed(m, stack, PREPARE - 1, "stack")
    for word in range(4):
        raw = register(m, quad[word], f"raw{word}")
        shift = register(m, headroom[word], f"shift{word}")
        coarse_shift, _ = two_steps(shift, _FINE)
        _, fine_shift = two_steps(register(m, shift, f"coarse_shift{word}"), _FINE)
        coarse = register(m, (raw << coarse_shift)[:vector].as_signed(), f"coarse{word}")
        aligned = Signal(signed(vector), name=f"aligned{word}", reset_less=True)
        m.d.sync += [
            aligned.eq(coarse << fine_shift),
            words[word].eq(_rounded(design, aligned, stack)),
        ]
    return words


def _rounded(design: Design, aligned: Value, stack: Value | None) -> Value:
    """A word with the length of its product, aligned to the top of a lane's word."""
    word, lengths = design.operand_word, operand_lengths(design)
    if stack is None:
        return round_top(aligned, word)
    by_length = {bits: round_top(aligned, bits) << (word - bits) for bits in set(lengths)}
    return Array(by_length[bits] for bits in lengths)[stack]
