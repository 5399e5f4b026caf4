"""The state of every taxel: the sum of a mean, its last word, and for how many frames it had that."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.intake import PART
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.ram import Ram
from tfra.model.fixed.front_end import LEAST_WORD, MOST_AVERAGED, OLDEST, WORD

SUM = WORD + 1 + MOST_AVERAGED
"""Bits of a sum."""
AGE = OLDEST.bit_length()
"""Bits of the number of frames with the same word."""

STATE = data.StructLayout({"sum": signed(SUM), "word": WORD, "age": AGE})
"""What is stored of a taxel."""

FAULTS = data.StructLayout({"saturated": 1, "out_of_range": 1, "stuck": 1})


def summed(taxels: int) -> data.StructLayout:
    """A taxel with its sum over the frames of a mean, including this one."""
    return data.StructLayout({
        "valid": 1,
        "index": counter_shape(taxels - 1),
        "sum": signed(SUM),
        "faults": FAULTS,
        "part": PART,
    })


class History(wiring.Component):
    """Read, update and write the state of a taxel; two pages, so that a frame that is dropped leaves no trace.

    =====  =================================  =======================
    cycle  word                               state
    =====  =================================  =======================
    0      register                           address
    1      :func:`reading`                    memory
    2      sum and age                        ``stored``
    3      ``o``                              ``updated``, written
    =====  =================================  =======================

    A state is written :attr:`latency` cycles after its taxel entered, and read one cycle later at the earliest: frames
    have four taxels or more.
    """

    latency = 3

    def __init__(self, taxels: int) -> None:
        super().__init__({
            "entered": In(1),  # a taxel is transferred
            "index": In(counter_shape(taxels - 1)),
            "word": In(WORD),
            "part": In(PART),  # of its frame
            "good": In(1),  # its frame ends with it and is complete
            "word_bits": In(5),  # settings
            "is_unsigned": In(1),
            "stuck_frames": In(AGE),
            "o": Out(summed(taxels)),  # ``latency`` cycles later
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        states = Ram(m, "states", STATE, 2 << len(self.index))
        page = Signal()
        stored = Signal(STATE, reset_less=True)
        updated = Signal(STATE, reset_less=True)
        entered = register(m, self.word, "word")
        value, saturated, outside = reading(entered, self.word_bits, self.is_unsigned)
        word = register(m, entered, "word")
        part = delayed(m, self.part, 2, "part")
        same = (stored.word == word) & ~part.fresh
        m.d.sync += [
            page.eq(page ^ self.good),
            stored.eq(states.read(Cat(self.index, page), self.entered)),
            updated.sum.eq(Mux(part.first, 0, stored.sum) + register(m, value, "value")),
            updated.word.eq(word),
            updated.age.eq(Mux(same, stored.age + ~stored.age.all(), 1)),
        ]
        o = self.o
        m.d.comb += [
            o.valid.eq(delayed(m, self.entered, self.latency, "valid", control=True)),
            o.index.eq(delayed(m, self.index, self.latency, "index")),
            o.part.eq(register(m, part, "part")),
            o.sum.eq(updated.sum),
            o.faults.stuck.eq((updated.age >= self.stuck_frames) & self.stuck_frames.any()),
            o.faults.saturated.eq(delayed(m, saturated, 2, "saturated")),
            o.faults.out_of_range.eq(delayed(m, outside, 2, "outside")),
        ]
        states.write(o.valid, Cat(o.index, ~delayed(m, page, self.latency, "page")), updated)
        return m


def reading(word: Value, word_bits: Value, is_unsigned: Value) -> tuple[Value, Value, Value]:
    """Signed value of ``word`` times 2^(16 - ``word_bits``), 17 bits; whether it is saturated, and out of range.

    Combinational.  A word is saturated at both ends of its range, and out of range if the bits above are no extension
    of it.
    """
    unused = (WORD - word_bits)[:4]
    at_least = [unused >= bits for bits in range(1, WORD - LEAST_WORD + 1)]  # so many bits are unused, or more
    moved = (word << unused)[:WORD]
    sign = moved[-1]
    # Both ends have all bits set but for the sign, which an unsigned word has the other way round.
    ones = moved[:-1] ^ (sign ^ is_unsigned).replicate(WORD - 1)
    saturated = (ones | Cat(at_least, Const(0, LEAST_WORD - 1))).all()
    extension = word ^ (word[-1] & ~is_unsigned).replicate(WORD)
    above = Cat(at_least[::-1])  # the bits above the highest one of an unsigned word
    from_sign = Cat(at_least[::-1], Const(1, 1))
    outside_unsigned = (extension[LEAST_WORD:] & above).any()
    outside_signed = (extension[LEAST_WORD - 1 :] & from_sign).any() & ~is_unsigned
    return Cat(moved, sign & ~is_unsigned).as_signed(), saturated, outside_unsigned | outside_signed
