"""What is known of every taxel from the frames before: the sum of a mean, its last word, and for how long it had it."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.means import PART
from tfra.hdl.front_end.reading import reading
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import delayed, register
from tfra.model.fixed.front_end import MOST_AVERAGED, OLDEST, WORD

SUM = WORD + 1 + MOST_AVERAGED
"""Bits of a sum."""
AGE = OLDEST.bit_length()
"""Bits of the number of frames with the same word."""

KEPT = data.StructLayout({"sum": signed(SUM), "word": WORD, "age": AGE})

FAULTS = data.StructLayout({"saturated": 1, "out_of_range": 1, "stuck": 1})


def summed(taxels: int) -> data.StructLayout:
    """A taxel with its sum over the frames of a mean, including this one."""
    members = {"valid": 1, "index": counter_shape(taxels - 1), "sum": signed(SUM), "faults": FAULTS, "part": PART}
    return data.StructLayout(members)


class History(wiring.Component):
    """Reads, updates and writes what is kept of a taxel; two pages, so that a frame that is dropped leaves no trace.

    A taxel is written :attr:`latency` cycles after it entered, and read one cycle later at the earliest: frames have
    four taxels or more.

    Members:
        entered, index, word: in, a taxel in the cycle of its transfer; ``part``: of its frame.
        good: in, the frame ends with this taxel and is complete.
        word_bits, is_unsigned, stuck_frames: settings.
        o: out, :attr:`latency` cycles later.
    """

    latency = 3

    def __init__(self, taxels: int) -> None:
        index = In(counter_shape(taxels - 1))
        taxel = {"entered": In(1), "index": index, "word": In(WORD), "part": In(PART), "good": In(1)}
        settings = {"word_bits": In(5), "is_unsigned": In(1), "stuck_frames": In(AGE)}
        super().__init__({**taxel, **settings, "o": Out(summed(taxels))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.kept = kept = Memory(shape=KEPT, depth=2 << len(self.index), init=[])
        read, write = kept.read_port(), kept.write_port()
        page = Signal()
        now = Signal(KEPT, reset_less=True)
        m.d.sync += page.eq(page ^ self.good)
        word = register(m, self.word, "word")
        value, saturated, outside = reading(word, self.word_bits, self.is_unsigned)
        word, value = register(m, word, "word"), register(m, value, "value")
        stored, part = Signal(KEPT, reset_less=True), delayed(m, self.part, 2, "part")
        same = (stored.word == word) & ~part.fresh
        m.d.sync += [
            stored.eq(read.data),
            now.sum.eq(Mux(part.first, 0, stored.sum) + value),
            now.word.eq(word),
            now.age.eq(Mux(same, stored.age + ~stored.age.all(), 1)),
        ]
        o = self.o
        stuck = (now.age >= self.stuck_frames) & self.stuck_frames.any()
        m.d.comb += [
            *(read.addr.eq(Cat(self.index, page)), read.en.eq(self.entered)),
            o.valid.eq(delayed(m, self.entered, self.latency, "valid", control=True)),
            *(o.index.eq(delayed(m, self.index, self.latency, "index")), o.part.eq(register(m, part, "part"))),
            *(o.sum.eq(now.sum), o.faults.stuck.eq(stuck)),
            o.faults.saturated.eq(delayed(m, saturated, 2, "saturated")),
            o.faults.out_of_range.eq(delayed(m, outside, 2, "outside")),
            *(write.addr.eq(Cat(o.index, ~delayed(m, page, self.latency, "page"))), write.en.eq(o.valid)),
            write.data.eq(now),
        ]
        return m
