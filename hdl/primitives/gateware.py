"""Multiplier, coefficient memory and store, and what each family's cells are used for in them, by CONFIG's target.

The rest is plain Amaranth: a family that has no cells of its own in the gateware needs no row.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from amaranth import Module, Signal, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.primitives import ecp5, ice40
from tfra.model.arrays import Ints


@dataclass(frozen=True)
class Gateware:
    """Functions that make a primitive of cells inside a module and return its words; None: plain Amaranth.

    ``multiplier(m, a, b, enable)`` and ``rom(m, images, bits, address, enable, write, data)`` answer two enabled cycles
    later, ``store(m, bits, address, write, data)`` one cycle later.
    """

    multiplier: Callable[..., Any] | None = None
    rom: Callable[..., Any] | None = None
    store: Callable[..., Any] | None = None


GATEWARE = {
    "portable": Gateware(),
    "ecp5": Gateware(multiplier=ecp5.multiplier, rom=ecp5.rom),
    "ice40": Gateware(store=ice40.store),
}


class Multiplier(wiring.Component):
    """``product = a * b``, exact, :attr:`latency` enabled cycles later, one a cycle.

    ======== ================================================================================================
    target   made of
    ======== ================================================================================================
    portable registers for ``a``, ``b`` and ``product``, none of them reset
    ice40    the same, which yosys packs into SB_MAC16
    ecp5     MULT18X18D with its input and output registers: one for factors up to 18 bits.  Longer factors are
             split into a low digit of 17 bits and the rest; the sum of the two or four products follows the
             output registers without another one.
    ======== ================================================================================================
    """

    latency = 2

    def __init__(self, a_bits: int, b_bits: int, target: str) -> None:
        self._cells = GATEWARE[target].multiplier
        super().__init__({
            "a": In(signed(a_bits)),  # 35 bits at most, as ``b``
            "b": In(signed(b_bits)),
            "enable": In(1, init=1),  # the registers hold while it is low
            "product": Out(signed(a_bits + b_bits)),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        if self._cells:
            m.d.comb += self.product.eq(self._cells(m, self.a, self.b, self.enable))
            return m
        a = Signal.like(self.a, reset_less=True)
        b = Signal.like(self.b, reset_less=True)
        product = Signal.like(self.product, reset_less=True)
        m.d.comb += self.product.eq(product)
        with m.If(self.enable):
            m.d.sync += a.eq(self.a)
            m.d.sync += b.eq(self.b)
            m.d.sync += product.eq(a * b)
        return m


class Rom(wiring.Component):
    """``words[n]`` is ``images[n][address]``, :attr:`latency` enabled cycles later, one address a cycle.

    ======== ================================================================================================
    target   made of
    ======== ================================================================================================
    portable a memory for each image, with a register after it
    ice40    the same: SB_RAM40_4K has one read port and no output register
    ecp5     DP16KD with output registers.  Two images share a memory wherever each needs half of it or less:
             of a pair, one is read by port A, the other by port B.
    ======== ================================================================================================

    If it is ``loaded``, ``data`` is written at ``address`` of image ``n`` while ``write[n]`` is high, and the
    images only determine the size.
    """

    latency = 2

    def __init__(self, images: Ints, bits: int, target: str, *, loaded: bool = False) -> None:
        self._images, self._bits, self._loaded = 0 * images if loaded else images, bits, loaded
        self._cells = GATEWARE[target].rom
        super().__init__({
            "address": In(counter_shape(images.shape[1] - 1)),
            "enable": In(1, init=1),  # the registers hold while it is low
            "words": Out(signed(bits)).array(len(images)),
            **({"write": In(len(images)), "data": In(signed(bits))} if loaded else {}),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        if self._cells:
            write, data = (self.write, self.data) if self._loaded else (None, None)
            words = self._cells(m, self._images, self._bits, self.address, self.enable, write, data)
            m.d.comb += [port.eq(word) for port, word in zip(self.words, words, strict=True)]
        else:
            for number in range(len(self._images)):
                self._memory(m, number)
        return m

    def _memory(self, m: Module, number: int) -> None:
        image, shape = self._images[number].tolist(), signed(self._bits)
        m.submodules[f"memory{number}"] = memory = Memory(shape=shape, depth=len(image), init=image)
        port = memory.read_port()
        word = Signal(shape, name=f"word{number}", reset_less=True)
        m.d.comb += port.addr.eq(self.address)
        m.d.comb += port.en.eq(self.enable)
        m.d.comb += self.words[number].eq(word)
        with m.If(self.enable):
            m.d.sync += word.eq(port.data)
        if self._loaded:
            write = memory.write_port()
            m.d.comb += write.addr.eq(self.address)
            m.d.comb += write.data.eq(self.data)
            m.d.comb += write.en.eq(self.write[number])


class Store(wiring.Component):
    """``depth`` words of ``bits`` without initial contents.

    For ``target`` "ice40" it is made of SB_SPRAM256KA, otherwise it is a plain memory.
    """

    def __init__(self, bits: int, depth: int, target: str) -> None:
        self._bits, self._depth, self._cells = bits, depth, GATEWARE[target].store
        super().__init__({
            "address": In(range(depth)),
            "write": In(1),  # write ``write_data`` in this cycle instead of reading
            "write_data": In(bits),
            "data": Out(bits),  # the word at the address of the cycle before
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        if self._cells:
            m.d.comb += self.data.eq(self._cells(m, self._bits, self.address, self.write, self.write_data))
            return m
        m.submodules.memory = memory = Memory(shape=unsigned(self._bits), depth=self._depth, init=[])
        read, write = memory.read_port(), memory.write_port()
        m.d.comb += [
            read.addr.eq(self.address),
            read.en.eq(~self.write),
            self.data.eq(read.data),
            write.addr.eq(self.address),
            write.data.eq(self.write_data),
            write.en.eq(self.write),
        ]
        return m
