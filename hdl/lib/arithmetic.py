"""Amaranth expressions for the primitives of :mod:`tfra.model.fixed.numbers`; all combinational."""

from collections.abc import Callable

from amaranth import Array, Cat, Const, Mux, Shape, Value, signed, unsigned
from amaranth.lib import data

from tfra.model.rounding import Rounding


def quad(bits: int) -> data.ArrayLayout:
    """Payload of a vector stream: four signed words, mirror taxels or parities."""
    return data.ArrayLayout(signed(bits), 4)


def saturate(value: Value, bits: int) -> Value:
    """Signed ``value`` limited to a signed word of ``bits``."""
    width = len(value)
    if width <= bits:
        return value
    high = value[bits - 1 :]
    fits = (high == 0) | high.all()
    top = (1 << (bits - 1)) - 1
    limit = Mux(value[-1], Const(-top - 1, signed(bits)), Const(top, signed(bits)))
    return Mux(fits, value[:bits].as_signed(), limit).as_signed()


def shift_right(value: Value, amount: Value) -> Value:
    """Signed ``value >> amount`` with one bit kept below the point; :func:`round_off` finishes the rounding.

    The pair equals ``round_shift``, with a register possible between barrel shifter and adder.
    """
    return (Cat(Const(0, 1), value).as_signed() >> amount)[: len(value) + 1].as_signed()


def round_off(value: Value, drop: int, rounding: Rounding = Rounding.HALF_UP) -> Value:
    """``value / 2^drop`` rounded; the result is as long as it can get, ``drop - 1`` bits shorter.

    In a value that has been shifted, the lowest bit may stand for all bits that are gone (sticky).
    """
    match rounding:
        case Rounding.HALF_UP:
            exact = (value + rounding.constant(drop)) >> drop
        case Rounding.HALF_EVEN:
            rounds_up = value[drop - 1] & (value[: drop - 1].any() | value[drop])
            return round_off(_like(value, Cat(rounds_up, value[drop:])), 1)
        case Rounding.TRUNCATE:
            exact = value >> drop
    return _like(value, exact[: len(value) + 1 - drop])


def round_negated(value: Value, drop: int) -> Value:
    """``-round_off(value, drop)`` half up, for a signed value: rounding and sign are one subtraction."""
    return ((1 << drop) - 1 - Rounding.HALF_UP.constant(drop) - value) >> drop


def _like(value: Value, bits: Value) -> Value:
    """``bits`` as a signed word if ``value`` is one."""
    return bits.as_signed() if value.shape().signed else bits


def round_top(aligned: Value, bits: int) -> Value:
    """Top ``bits`` of a value without leading zeros, rounded half up and saturated: the end of ``normalise``."""
    width = len(aligned)
    if width <= bits:
        return (aligned << (bits - width)).as_signed()
    return saturate(round_off(aligned[width - bits - 1 :].as_signed(), 1), bits)


def magnitude_bits(value: Value) -> Value:
    """``value ^ sign``: unsigned; its bit length is that of the signed value without the sign."""
    return (value ^ value[-1].replicate(len(value)))[: len(value) - 1]


def counter_shape(top: int) -> Shape:
    """Shape of a counter that holds 0 ... ``top``."""
    return unsigned(max(1, top.bit_length()))


def leading_zeros(value: Value, between: Callable[[Value], Value] = lambda word: word) -> Value:
    """Zeros above the highest set bit of an unsigned value, its length for zero.

    A tree of multiplexers without an adder, for a short path.  The results of each eight bits pass ``between``, a
    register where the whole tree would be too long a path.
    """
    size = max(8, 1 << len(value).bit_length())
    mark = size - len(value) - 1  # below the value; what it makes constant is the same now and later
    padded = Cat(Const(0, mark), Const(1, 1), value)
    nodes = []
    for k in range(0, size, 8):
        some, zeros = _zeros([(bit, Const(0, 0)) for bit in padded[k : k + 8]])
        nodes.append((between(some) if mark < k else some, between(zeros) if mark < k + 7 else zeros))
    return _zeros(nodes)[1]


def _zeros(nodes: list[tuple[Value, Value]]) -> tuple[Value, Value]:
    """For consecutive words, the highest last: whether any bit is set, and the zeros above it."""
    while len(nodes) > 1:
        pairs = zip(nodes[::2], nodes[1::2], strict=True)
        nodes = [
            (high | low, Cat(Mux(high, above, below) if len(above) else above, ~high))
            for (low, below), (high, above) in pairs
        ]
    return nodes[0]


def two_steps(amount: Value, fine: int) -> tuple[Value, Value]:
    """A shift in two steps, for a register in between: all but its lowest ``fine`` bits, and these."""
    return Cat(Const(0, fine), amount[fine:]), amount[:fine]


def add_or_subtract(base: Value, value: Value, subtract: Value) -> Value:
    """Signed ``base - value`` if ``subtract`` else ``base + value``: one carry chain for both."""
    inverted = value ^ subtract.replicate(len(value)).as_signed()  # equal signedness keeps the length
    return (Cat(subtract, base).as_signed() + Cat(subtract, inverted).as_signed())[1:].as_signed()


def add_carry(a: Value, b: Value, carry: Value) -> Value:
    """Unsigned ``a + b + carry`` in one adder, one bit longer than the longer word."""
    return (Cat(Const(1, 1), a) + Cat(carry, b))[1:]


def less(a: Value, b: Value) -> Value:
    """Unsigned ``a < b`` from parallel carry chains, half as long as the words.

    It takes the signs of differences, since yosys builds comparisons for both orders from one chain and a test for
    equality.
    """
    half = len(a) // 2
    low, high, higher = a[:half] - b[:half], a[half:] - b[half:], b[half:] - a[half:]
    return high[-1] | (low[-1] & ~higher[-1])


def during(counter: Value, window: range) -> Value:
    """High while ``counter`` is in ``window``, whose step is one."""
    return (counter >= window.start) & (counter < window.stop)


def once(cycle: int) -> range:
    """One cycle of a counter, as a window; a register is loaded at the end of its cycle."""
    return range(cycle, cycle + 1)


def later(window: range, cycles: int) -> range:
    """``window`` delayed by the given number of cycles: the next register of a pipeline."""
    return range(window.start + cycles, window.stop + cycles)


def nth_slice(word: Value, number: Value, slices: int) -> Value:
    """One of ``slices`` equal slices of ``word``, by a multiplexer; ``word_select`` would infer a multiplier."""
    size = len(word) // slices
    return Array(word.word_select(k, size) for k in range(slices))[number] if slices > 1 else word
