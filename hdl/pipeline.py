"""Registers in a row: words that come later, constant products without a multiplier."""

from __future__ import annotations

from amaranth import Module, Shape, Signal, Value


def register(m: Module, value: Value, name: str = "register", *, control: bool = False) -> Signal:
    """``value`` a cycle later, or a step where ``m`` is in a condition; ``control`` bits are cleared by a reset."""
    word = Signal(value.shape(), name=name, reset_less=not control)
    m.d.sync += word.eq(value)
    return word


def delayed(m: Module, value: Value, cycles: int, name: str = "word", *, control: bool = False) -> Value:
    """``value`` so many cycles later."""
    for _ in range(cycles):
        value = register(m, value, name, control=control)
    return value


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
    """``value * factor`` from a tree of shifted copies with a register behind every addition."""
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
