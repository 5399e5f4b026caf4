"""Cells of the Lattice ECP5, with their registers in use (Lattice FPGA-TN-02204 and FPGA-TN-02205)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amaranth import Cat, ClockSignal, Const, Elaboratable, Instance, Module, Signal, Value, signed

FACTOR_BITS = 18
"""Longest signed factor of a MULT18X18D."""

MEMORY_WORDS = {18: 1024, 9: 2048}
"""Words of a DP16KD by their length."""

_ROW = 16
"""Words of 18 bits in an INITVAL parameter, each in a field of 20 bits."""


class Product(Elaboratable):
    """MULT18X18D with input and output registers: ``product = a * b``, two enabled cycles later."""

    def __init__(self, a: Value, b: Value, enable: Value) -> None:
        self._a, self._b, self._enable = a, b, enable
        self.product = Signal(signed(len(a) + len(b)))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        product = Signal(signed(2 * FACTOR_BITS))
        registers = ("INPUTA", "INPUTB", "OUTPUT")
        m.submodules.cell = Instance(
            "MULT18X18D",
            **{f"p_REG_{name}_CLK": "CLK0" for name in registers},
            **_bits("i_A", _extended(self._a)),
            **_bits("i_B", _extended(self._b)),
            **_bits("i_C", Const(0, FACTOR_BITS)),
            **_bits("o_P", product),
            i_SIGNEDA=Const(1),
            i_SIGNEDB=Const(1),
            i_SOURCEA=Const(0),
            i_SOURCEB=Const(0),
            i_CLK0=ClockSignal(),
            i_CE0=self._enable,
            i_RST0=Const(0),
        )
        m.d.comb += self.product.eq(product)
        return m


class Words(Elaboratable):
    """DP16KD as memory of ``bits`` (18 or 9) with output registers: two words a cycle.

    ``words[p]`` is the word that ``addresses[p]`` named two enabled cycles before.  If the memory is writable,
    ``writes[p]`` writes ``data`` there.
    """

    def __init__(
        self,
        image: Sequence[int],
        bits: int,
        addresses: Sequence[Value],
        enable: Value,
        writes: Sequence[Value] = (),
        data: Value | None = None,
    ) -> None:
        self._image, self._bits, self._addresses, self._enable = image, bits, addresses, enable
        self._writes, self._data = writes or [Const(0)] * len(addresses), Const(0, bits) if data is None else data
        self.words = [Signal(bits, name=f"word{port}") for port in range(len(addresses))]

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        ports: dict[str, Any] = {}
        for name, address, write, word in zip("AB", self._addresses, self._writes, self.words, strict=False):
            ports |= self._port(name, address, write, word)
        m.submodules.cell = Instance("DP16KD", **_initial(self._image, self._bits), **ports)
        return m

    def _port(self, name: str, address: Value, write: Value, word: Signal) -> dict[str, Any]:
        below = self._bits.bit_length() - 1  # address bits that number the bits of a word
        whole = (1 << self._bits // 9) - 1 if self._bits > 9 else 0  # of these, the lowest enable the bytes to write
        place = Cat(Const(whole, below), address, Const(0, 14))[:14]
        return {
            f"p_DATA_WIDTH_{name}": self._bits,
            f"p_REGMODE_{name}": "OUTREG",
            f"i_CLK{name}": ClockSignal(),
            f"i_CE{name}": self._enable,
            f"i_OCE{name}": self._enable,
            f"i_WE{name}": write,
            f"i_RST{name}": Const(0),
            **_bits(f"i_AD{name}", place),
            **_bits(f"i_DI{name}", self._data),
            **_bits(f"i_CS{name}", Const(0, 3)),
            **_bits(f"o_DO{name}", word),
        }


def _initial(image: Sequence[int], bits: int) -> dict[str, Const]:
    """INITVAL parameters; two words of 9 bits lie where one of 18 does."""
    halves = 18 // bits
    fields = [0] * (MEMORY_WORDS[bits] // halves)
    for place, word in enumerate(image):
        fields[place // halves] |= (int(word) & ((1 << bits) - 1)) << (place % halves * bits)
    rows = [fields[start : start + _ROW] for start in range(0, len(fields), _ROW)]
    values = (sum(field << (20 * k) for k, field in enumerate(row)) for row in rows)
    return {f"p_INITVAL_{number:02X}": Const(value, 20 * _ROW) for number, value in enumerate(values)}


def _extended(factor: Value) -> Value:
    return Cat(factor, factor[-1].replicate(FACTOR_BITS - len(factor)))


def _bits(name: str, word: Value) -> dict[str, Value]:
    """Ports of single bits: NAME0, NAME1, ..."""
    return {f"{name}{place}": word[place] for place in range(len(word))}
