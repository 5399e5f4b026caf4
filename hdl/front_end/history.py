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
        unused = register(m, (WORD - self.word_bits)[:4], "unused")
        above = register(m, Cat(unused >= bits for bits in range(WORD - LEAST_WORD, 0, -1)), "above")
        entered = register(m, self.word, "word")
        value = register(m, reading(entered, unused, self.is_unsigned), "value")
        word = register(m, entered, "word")
        part = delayed(m, self.part, 2, "part")
        same = (stored.word == word) & ~part.fresh
        m.d.sync += [
            page.eq(page ^ self.good),
            stored.eq(states.read(Cat(self.index, page), self.entered)),
            updated.sum.eq(Mux(part.first, 0, stored.sum) + value),
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
            o.faults.saturated.eq(register(m, is_saturated(value[:WORD], above, self.is_unsigned), "saturated")),
            o.faults.out_of_range.eq(register(m, is_outside(word, above, self.is_unsigned), "outside")),
        ]
        states.write(o.valid, Cat(o.index, ~delayed(m, page, self.latency, "page")), updated)
        return m


def reading(word: Value, unused: Value, is_unsigned: Value) -> Value:
    """Signed value of ``word`` times 2^``unused``, 17 bits."""
    moved = (word << unused)[:WORD]
    return Cat(moved, moved[-1] & ~is_unsigned).as_signed()


def is_saturated(moved: Value, above: Value, is_unsigned: Value) -> Value:
    """Whether a word, ``moved`` to the top of its 16 bits, is at either end of its range.

    ``above`` has a one for each bit that is unused, from the highest bit on.
    """
    # Both ends have all bits set but for the sign, which an unsigned word has the other way round.
    ones = moved[:-1] ^ (moved[-1] ^ is_unsigned).replicate(WORD - 1)
    return (ones | Cat(above[::-1], Const(0, LEAST_WORD - 1))).all()


def is_outside(word: Value, above: Value, is_unsigned: Value) -> Value:
    """Whether the bits ``above`` are no extension of the ``word``."""
    extension = word ^ (word[-1] & ~is_unsigned).replicate(WORD)
    outside_unsigned = (extension[LEAST_WORD:] & above).any()
    outside_signed = (extension[LEAST_WORD - 1 :] & Cat(above, Const(1, 1))).any() & ~is_unsigned
    return outside_unsigned | outside_signed
