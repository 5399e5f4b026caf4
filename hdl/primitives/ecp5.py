"""Cells of the Lattice ECP5, with their registers in use (Lattice FPGA-TN-02204 and FPGA-TN-02205)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import Any

import numpy as np
from amaranth import Array, Cat, ClockSignal, Const, Elaboratable, Instance, Module, Signal, Value, signed

from tfra.hdl.lib.pipeline import delayed
from tfra.model.arrays import Ints

_FACTOR_BITS = 18
"""Longest signed factor of a MULT18X18D."""

_DIGIT = _FACTOR_BITS - 1
"""Bits of the low digit of a longer factor."""

_MEMORY_WORDS = {18: 1024, 9: 2048}
"""Words of a DP16KD by their length."""

_ROW = 16
"""Words of 18 bits in an INITVAL parameter, each in a field of 20 bits."""


def multiplier(m: Module, a: Value, b: Value, enable: Value) -> Value:
    """``a * b`` two enabled cycles later, for signed factors of up to 35 bits.

    It is the sum of the digits' products; the lowest and the highest of four lie side by side.
    """
    products = {}
    for i, first in enumerate(_digits(a)):
        for j, second in enumerate(_digits(b)):
            m.submodules[f"digits{i}{j}"] = part = Product(first, second, enable)
            products[i, j] = part.product
    if (1, 1) in products:
        products[0, 0] = Cat(products[0, 0][: 2 * _DIGIT], products.pop((1, 1))).as_signed()
    return reduce(add, (word << (_DIGIT * (i + j)) for (i, j), word in products.items()))


def _digits(word: Value) -> list[Value]:
    """A signed word as an unsigned low digit and the signed rest, or as it is if it fits a cell."""
    if len(word) <= _FACTOR_BITS:
        return [word]
    return [Cat(word[:_DIGIT], Const(0, 1)).as_signed(), word[_DIGIT:].as_signed()]


def rom(
    m: Module, images: Ints, bits: int, address: Value, enable: Value, write: Value | None, data: Value | None
) -> list[Value]:
    """The word of ``bits`` at ``address`` in each of ``images``, two enabled cycles later.

    ``data`` is written there to image ``n`` while ``write[n]`` is high.  Two images share a memory wherever each needs
    half of it or less.
    """
    return _Rom(m, bits, address, enable, write, data).words(images)


def memories(bits: int, depth: int) -> int:
    """How many a pair of images takes in :func:`rom`: words of ``bits``, and ``depth`` of them."""
    count = 0
    for _, length in _slices(bits, depth):
        size = _MEMORY_WORDS[length]
        whole, rest = divmod(depth, size)
        count += 2 * whole + (0 if not rest else 1 if 2 * rest <= size else 2)
    return count


@dataclass
class _Rom:
    """Block memories of a ROM in module ``m``; the names are those of :func:`rom`."""

    m: Module
    bits: int
    address: Value
    enable: Value
    write: Value | None
    data: Value | None

    def words(self, images: Ints) -> list[Value]:
        """The word of every image, from pairs of images, the last one perhaps alone."""
        found: list[Value] = []
        for first in range(0, len(images), 2):
            pair = images[first : first + 2]
            slices = [self._slice(first, pair, low, bits) for low, bits in _slices(self.bits, images.shape[1])]
            found += [Cat(*words) for words in zip(*slices, strict=True)]
        return found

    def _slice(self, first: int, images: Ints, low: int, bits: int) -> list[Value]:
        """``bits`` from ``low`` of every image's word, from as many memories as the depth needs."""
        name, size = f"memory{first}_{low}", _MEMORY_WORDS[bits]
        found: list[list[Value]] = [[] for _ in images]
        for start in range(0, images.shape[1], size):
            part = images[:, start : start + size]
            numbers = list(range(len(part)))
            # images that need half of a memory or less share one
            for group in [numbers] if 2 * part.shape[1] <= size else [[number] for number in numbers]:
                writes = self._writes([first + number for number in group], start // size, size)
                data = None if self.data is None else Cat(self.data, Const(0, bits))[low : low + bits]
                memory = self._block(part[group] >> low, bits, writes, data)
                self.m.submodules[f"{name}_{start}_{group[0]}"] = memory
                for number, word in zip(group, memory.words, strict=True):
                    found[number].append(word)
        if len(found[0]) == 1:
            return [words[0] for words in found]
        with self.m.If(self.enable):
            block = delayed(self.m, self.address[(size - 1).bit_length() :], 2, "block")  # at the time of its words
        return [Array(words)[block] for words in found]

    def _writes(self, numbers: list[int], block: int, size: int) -> list[Value]:
        """Enables of images ``numbers``, in the memory of words from ``block * size`` on."""
        if self.write is None:
            return []
        above = self.address[(size - 1).bit_length() :]
        return [self.write[number] & (above == block if len(above) else 1) for number in numbers]

    def _block(self, images: Ints, bits: int, writes: list[Value], data: Value | None) -> "Words":
        """One memory of up to two images: the second, read by the second port, starts in the middle."""
        size = _MEMORY_WORDS[bits]
        starts = range(0, size, size // len(images))
        content = np.zeros(size, dtype=np.int64)
        for start, image in zip(starts, images, strict=True):
            content[start : start + len(image)] = image
        place = self.address[: (size // len(images) - 1).bit_length()]
        return Words(content.tolist(), bits, [(place | start) for start in starts], self.enable, writes, data)


def _slices(bits: int, depth: int) -> Iterator[tuple[int, int]]:
    """Lowest bit and length of the memories' words that make up one of ``bits``.

    Deep memories of short words save a multiplexer for each bit, so they are used where they are not more.
    """
    long, short = max(_MEMORY_WORDS), min(_MEMORY_WORDS)
    deep = long // short * -(-depth // _MEMORY_WORDS[short]) <= -(-depth // _MEMORY_WORDS[long])
    lengths = [short] if deep else [long, short]
    low = 0
    while low < bits:
        length = min((length for length in lengths if length >= bits - low), default=max(lengths))
        yield low, length
        low += length


class Product(Elaboratable):
    """MULT18X18D with input and output registers: ``product = a * b``, two enabled cycles later."""

    def __init__(self, a: Value, b: Value, enable: Value) -> None:
        self._a, self._b, self._enable = a, b, enable
        self.product = Signal(signed(len(a) + len(b)))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        product = Signal(signed(2 * _FACTOR_BITS))
        registers = ("INPUTA", "INPUTB", "OUTPUT")
        m.submodules.cell = Instance(
            "MULT18X18D",
            **{f"p_REG_{name}_CLK": "CLK0" for name in registers},
            **_bits("i_A", _extended(self._a)),
            **_bits("i_B", _extended(self._b)),
            **_bits("i_C", Const(0, _FACTOR_BITS)),
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
    fields = [0] * (_MEMORY_WORDS[bits] // halves)
    for place, word in enumerate(image):
        fields[place // halves] |= (int(word) & ((1 << bits) - 1)) << (place % halves * bits)
    rows = [fields[start : start + _ROW] for start in range(0, len(fields), _ROW)]
    values = (sum(field << (20 * k) for k, field in enumerate(row)) for row in rows)
    return {f"p_INITVAL_{number:02X}": Const(value, 20 * _ROW) for number, value in enumerate(values)}


def _extended(factor: Value) -> Value:
    return Cat(factor, factor[-1].replicate(_FACTOR_BITS - len(factor)))


def _bits(name: str, word: Value) -> dict[str, Value]:
    """Ports of single bits: NAME0, NAME1, ..."""
    return {f"{name}{place}": word[place] for place in range(len(word))}
