"""Counts the operators and registers of one Amaranth module, statement by statement, before any netlist.

Kinds and bits are those of the cells that Amaranth's RTLIL would have: operands are as long as the expression says, an
assignment under a condition is a multiplexer of the bits that it writes, and a reset is none.
"""

from collections import Counter
from dataclasses import dataclass
from typing import Any

from amaranth import Const, Signal
from amaranth.hdl import Fragment, _ast

_ADD = ("+", "-", "<", "<=", ">", ">=")
_REDUCE = ("b", "r|", "r&", "r^")
_KEEPS_ZERO = ("+", "-", "*", "<<", ">>", "&", "|", "^", "s", "u")


@dataclass
class _Register:
    """A word of flip-flops and its known values."""

    signal: Any
    writes: int = 0
    varies: bool = False
    """False if it stays zero."""
    copies: Any = None
    """The expression that it takes in every cycle, if there is one."""

    @property
    def content(self) -> tuple[Any, ...]:
        """Registers of the same content are one."""
        if self.copies is None:
            return (id(self.signal),)
        return id(self.copies), self.signal.init, self.signal.reset_less


class OperatorCount:
    """Counts of one module; ``operators`` in bits by kind: add, shift (bits times levels), logic, reduce, mux.

    ``multipliers`` are the widths of both operands of every multiplication.
    """

    def __init__(self) -> None:
        self.operators: Counter[str] = Counter()
        self.multipliers: list[tuple[int, int]] = []
        self._registers: dict[int, _Register] = {}

    @property
    def registers(self) -> int:
        """Flip-flops in bits: none for a register that stays zero, and one register for all of the same content."""
        bits: dict[tuple[Any, ...], int] = {}
        for register in self._registers.values():
            if register.varies:
                bits[register.content] = max(bits.get(register.content, 0), len(register.signal))
        return sum(bits.values())

    def module(self, fragment: Fragment) -> None:
        """Count the statements of ``fragment``, not those of modules in it."""
        for domain, statements in fragment.statements.items():
            for statement in statements:
                self._statement(statement, domain != "comb", conditional=False)

    def _statement(self, statement: Any, clocked: bool, conditional: bool) -> None:
        if isinstance(statement, _ast.Switch):
            self.value(statement.test)
            for _, inner, _ in statement.cases:
                for each in inner:
                    self._statement(each, clocked, conditional=True)
        elif isinstance(statement, _ast.Assign):
            self.value(statement.rhs)
            self._target(statement.lhs, len(statement.lhs), clocked, conditional)
            if clocked:
                self._store(statement, conditional)
        else:
            raise TypeError(f"{statement!r} is not counted")

    def _target(self, left: Any, bits: int, clocked: bool, conditional: bool) -> None:
        """The first ``bits`` of ``left`` are written."""
        if isinstance(left, Signal):
            self.operators["mux"] += bits if conditional else 0
            if clocked:
                self._registers.setdefault(id(left), _Register(left)).writes += 1
        elif isinstance(left, _ast.Slice):
            self._target(left.value, bits, clocked, conditional)
        elif isinstance(left, _ast.Operator):  # as_signed, as_unsigned
            self._target(left.operands[0], bits, clocked, conditional)
        elif isinstance(left, _ast.Concat):
            for part in left.parts:
                self._target(part, len(part), clocked, conditional)
        elif isinstance(left, _ast.Part):
            self.value(left.offset)
            for start in range(0, min(len(left.value), left.stride << len(left.offset)), left.stride):
                self._target(left.value, min(bits, len(left.value) - start), clocked, conditional=True)
        elif isinstance(left, _ast.SwitchValue):
            self.value(left.test)
            for _, choice in left.cases:
                self._target(choice, min(bits, len(choice)), clocked, conditional=True)
        else:
            raise TypeError(f"{left!r} is not counted")

    def _store(self, statement: Any, conditional: bool) -> None:
        """What the written registers contain from now on."""
        for signal in statement._lhs_signals():
            register = self._registers[id(signal)]
            register.varies |= bool(signal.init) or not _is_zero(statement.rhs)
            always = signal is statement.lhs and not conditional and register.writes == 1
            register.copies = statement.rhs if always else None

    def value(self, value: Any) -> None:
        """Count the operators of ``value``."""
        if isinstance(value, _ast.Operator):
            for operand in value.operands:
                self.value(operand)
            (self._unary if len(value.operands) == 1 else self._binary)(value)
        elif isinstance(value, _ast.Slice):
            self.value(value.value)
        elif isinstance(value, _ast.Concat):
            for part in value.parts:
                self.value(part)
        elif isinstance(value, _ast.Part):
            self.value(value.value)
            self.value(value.offset)
            offset = len(value.offset) + (value.stride.bit_length() if value.stride > 1 else 0)
            self._shift(value.width, offset, len(value.value))
        elif isinstance(value, _ast.SwitchValue):
            self._choice(value)
        elif not isinstance(value, Const | Signal | _ast.ClockSignal | _ast.ResetSignal):
            raise TypeError(f"{value!r} is not counted")

    def _choice(self, value: Any) -> None:
        """A multiplexer of two is one of its bits, one of several takes an assignment for each."""
        self.value(value.test)
        for _, choice in value.cases:
            self.value(choice)
        if [patterns for patterns, _ in value.cases] == [("0" * len(value.test),), None]:
            self.operators["reduce"] += len(value.test) if len(value.test) > 1 else 0
            self.operators["mux"] += len(value)
        else:
            self.operators["mux"] += len(value) * len(value.cases)

    def _unary(self, value: Any) -> None:
        bits = len(value.operands[0])
        if value.operator == "-":
            self.operators["add"] += bits
        elif value.operator in _REDUCE:
            self.operators["reduce"] += bits

    def _binary(self, value: Any) -> None:
        a, b = value.operands
        widths = _widths(a, b)
        if value.operator in _ADD:
            self.operators["add"] += max(widths)
        elif value.operator in ("==", "!="):
            self.operators["reduce"] += max(widths)
        elif value.operator in ("&", "|", "^"):
            self.operators["logic"] += len(value)
        elif value.operator in ("<<", ">>"):
            if not isinstance(b, Const):  # by a constant is free
                self._shift(len(value), len(b), len(a))
        elif value.operator == "*":
            if min(widths) > 1:
                self.multipliers.append(widths)
        else:
            raise TypeError(f"{value!r} is not counted")

    def _shift(self, bits: int, amount: int, word: int) -> None:
        """``bits`` for each bit of the ``amount`` that moves anything of a ``word``."""
        self.operators["shift"] += bits * min(amount, word.bit_length())


def _widths(a: Any, b: Any) -> tuple[int, int]:
    """Bits of both operands, with a sign if either has one; of a constant, those that it needs."""
    shapes = a.shape(), b.shape()
    signed = any(shape.signed for shape in shapes)

    def width(value: Any, bits: int, own: bool) -> int:
        return value.value.bit_length() + signed if isinstance(value, Const) else bits + (signed and not own)

    first, second = (width(v, s.width, s.signed) for v, s in zip((a, b), shapes, strict=True))
    return first, second


def _is_zero(value: Any) -> bool:
    """Whether ``value`` is made of constants that are zero."""
    if isinstance(value, _ast.Operator):
        words = value.operands[:1] if value.operator in ("<<", ">>") else value.operands
        return value.operator in _KEEPS_ZERO and all(map(_is_zero, words))
    return isinstance(value, Const) and value.value == 0
