"""Functions that add registers to a module: delays, counters, occupancy, normalization, products without multiplier."""

from collections.abc import Iterable
from functools import reduce
from operator import or_
from typing import Any

from amaranth import Cat, Module, Mux, Shape, Signal, Value, signed

from tfra.hdl.lib.arithmetic import counter_shape, during, leading_zeros, magnitude_bits, two_steps

READ = 2
"""Cycles from an address to the word of a memory: the memory, and a register, since memories are slow."""


def register(m: Module, value: Value, name: str = "register", *, control: bool = False) -> Signal:
    """``value`` a cycle later, or only in enabled cycles if ``m`` is in a condition; a reset clears ``control``
    bits."""
    word = Signal(value.shape(), name=name, reset_less=not control)
    m.d.sync += word.eq(value)
    return word


def driver(m: Module, port: Any) -> Any:
    """A data register that drives ``port``, an output of a component; a port itself would be cleared by a reset."""
    word = Signal.like(port, name="word", reset_less=True)
    m.d.comb += port.eq(word)
    return word


def delayed(m: Module, value: Value, cycles: int, name: str = "word", *, control: bool = False) -> Value:
    """``value`` after the given number of cycles."""
    for _ in range(cycles):
        value = register(m, value, name, control=control)
    return value


def lookahead(m: Module, counter: Value, window: range) -> Signal:
    """``during(counter, window)`` from a register, for a counter that only waits two steps before it, or earlier."""
    return register(m, during(counter, range(window.start - 1, window.stop - 1)), "lookahead", control=True)


def wrapping_counter(m: Module, step: Value, length: int, name: str = "number") -> tuple[Signal, Value]:
    """A counter from 0 to ``length - 1`` that ``step`` advances and that wraps, and a register: it is at its end."""
    number = Signal(counter_shape(length - 1), name=name)
    last = Signal(init=length == 1, name=f"{name}_last")
    with m.If(step):
        m.d.sync += number.eq(Mux(last, 0, number + 1))
        if length > 1:
            m.d.sync += last.eq(number == length - 2)
    return number, last


def occupancy(m: Module, size: int, enter: Value, leave: Value, *, full: bool = False) -> Signal:
    """Occupancy of ``size`` places, one bit each from the first; both ends are registers for use elsewhere.

    ``enter`` counts only while there is a place.
    """
    taken = Signal(size, init=-int(full) & ((1 << size) - 1), name="taken")
    with m.If(enter & ~leave):
        m.d.sync += taken.eq(Cat(1, taken))
    with m.Elif(leave & ~enter):
        m.d.sync += taken.eq(taken[1:])
    return taken


def occupancy_flags(m: Module, size: int, enter: Value, leave: Value) -> tuple[Signal, Signal]:
    """Whether some, and whether all, of many places, ``size``, are taken; registers, as in :func:`occupancy`.

    ``enter`` counts only while there is a place, ``leave`` only while one is taken.
    """
    taken = Signal(counter_shape(size))
    some = Signal()
    full = Signal()
    with m.If(enter & ~leave):
        m.d.sync += taken.eq(taken + 1)
    with m.Elif(leave & ~enter):
        m.d.sync += taken.eq(taken - 1)
    # Without conditions, which would become an enable: one level of logic after the late inputs.
    m.d.sync += [
        some.eq(enter | (some & ~(leave & (taken == 1)))),
        full.eq(~leave & (full | (enter & (taken == size - 1)))),
    ]
    return some, full


ALIGN = 2
"""Cycles in which :func:`align` moves a word."""
_FINE = 2
"""Bits of a shift by which its second step moves."""


def registered_zeros(m: Module, value: Value) -> Value:
    """``leading_zeros(value)`` a cycle later; the register is in the middle of the tree."""
    return leading_zeros(value, lambda word: register(m, word, "zeros"))


def align(m: Module, words: Iterable[Value], word: Value, measure: Value) -> tuple[Signal, Signal]:
    """``word`` ``ALIGN`` cycles later, shifted left by the headroom that all ``words`` share; that headroom.

    ``measure`` is high two cycles after ``words`` are valid, when the OR of their magnitudes and a part of its zeros
    are known.  The zeros then stay, so the words may pass ``word`` one by one.  ``round_top`` finishes the
    normalisation.
    """
    width = len(word)
    magnitudes = Signal(width - 1, reset_less=True)
    zeros = Signal(counter_shape(width - 1), reset_less=True)
    aligned = Signal(signed(width), reset_less=True)
    coarse, fine = two_steps(zeros, _FINE)
    m.d.sync += [
        magnitudes.eq(reduce(or_, map(magnitude_bits, words))),
        aligned.eq(register(m, (word << coarse)[:width].as_signed(), "coarse") << fine),
    ]
    common = registered_zeros(m, magnitudes)
    with m.If(measure):
        m.d.sync += zeros.eq(common)
    return aligned, zeros


def signed_digits(factor: int) -> list[tuple[int, int]]:
    """Canonical signed digits ``(place, +-1)`` of a positive ``factor``, from the highest, which is positive."""
    digits, place = [], 0
    while factor:
        if factor & 1:
            digit = 2 - (factor & 3)
            digits.append((place, digit))
            factor -= digit
        factor >>= 1
        place += 1
    return digits[::-1]


def product_latency(factor: int) -> int:
    """Cycles that :func:`registered_product` takes: the levels of its tree of additions."""
    return (len(signed_digits(factor)) - 1).bit_length()


def registered_product(m: Module, value: Value, factor: int) -> Value:
    """``value * factor`` from a tree of shifted copies with a register after every addition."""
    most = len(value) + factor.bit_length()
    terms: list[tuple[Value, int]] = [(value << place, sign) for place, sign in signed_digits(factor)]
    while len(terms) > 1:
        level = []
        for (a, sign_a), right in zip(terms[::2], [*terms[1::2], None], strict=False):
            total, sign = a, sign_a
            if right is not None:
                b, sign_b = right
                total = a + b if sign_a == sign_b else a - b if sign_a > 0 else b - a
                sign = sign_a if sign_a == sign_b else 1
            word = Signal(Shape(min(len(total), most), True), reset_less=True)
            m.d.sync += word.eq(total)
            level.append((word, sign))
        terms = level
    return terms[0][0]


def busy_after(m: Module, start: Value, cycles: int) -> Signal:
    """High for ``cycles`` cycles from the one after ``start``."""
    left = Signal(counter_shape(cycles))  # remaining cycles
    busy = Signal()  # TIMING: left -> users of busy: some are left
    m.d.sync += busy.eq(start | (busy & (left != 1)))
    with m.If(start):
        m.d.sync += left.eq(cycles)
    with m.Elif(busy):
        m.d.sync += left.eq(left - 1)
    return busy


def serial_product(m: Module, word: Value, constant: int, digits: int, start: Value, busy: Value, name: str) -> Value:
    """``word * constant``, a digit of the constant for each ``busy`` cycle after ``start``.

    The product enters the register at the top while the constant leaves it at the bottom; the word must be stable.
    """
    shifter = Signal(len(word) + digits, name=name, reset_less=True)
    with m.If(start):
        m.d.sync += shifter.eq(constant)
    with m.Elif(busy):
        total = shifter[digits:] + Mux(shifter[0], word, 0)
        m.d.sync += shifter.eq(Cat(shifter[1:digits], total))
    return shifter


NORMALIZE = 4
"""Cycles from a word to its normalized one: two for its leading zeros, two for the shift."""


def normalize(m: Module, word: Value, bits: int) -> tuple[Value, Value]:
    """Leading zeros of unsigned ``word``, two cycles later, and its ``bits`` bits from the highest set one on.

    The second comes ``NORMALIZE`` cycles later.
    """
    zeros = register(m, registered_zeros(m, word), "length")
    coarse, fine = two_steps(zeros, _FINE)
    moved = register(m, (word << coarse)[max(0, len(word) - bits - (1 << _FINE)) : len(word)], "moved")
    return zeros, register(m, (moved << register(m, fine, "fine"))[len(moved) - bits : len(moved)], "top")
