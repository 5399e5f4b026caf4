"""Memory of many words at one address: the coefficients of the lanes."""

from typing import Any

from amaranth import Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.primitives.gateware import GATEWARE
from tfra.model.arrays import Ints


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
        m.d.comb += [port.addr.eq(self.address), port.en.eq(self.enable), self.words[number].eq(word)]
        with m.If(self.enable):
            m.d.sync += word.eq(port.data)
        if self._loaded:
            write = memory.write_port()
            m.d.comb += [write.addr.eq(self.address), write.data.eq(self.data), write.en.eq(self.write[number])]
