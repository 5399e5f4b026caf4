"""Memory of many words at one address: the coefficients of the lanes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from amaranth import Array, Cat, Const, Module, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.primitives.ecp5 import MEMORY_WORDS, Words
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

    Members:
        address: in.
        enable: in, default 1; the registers hold while it is low.
        words: out, one for each image, signed words of ``bits``.
        write, data: in, if it is ``loaded``: ``data`` is written at ``address`` of image ``n`` while ``write[n]`` is
            high.  For such a memory, the images only determine the size.
    """

    latency = 2

    def __init__(self, images: Ints, bits: int, target: str, *, loaded: bool = False) -> None:
        self._images, self._bits, self._target, self._loaded = 0 * images if loaded else images, bits, target, loaded
        super().__init__(
            {
                "address": In(counter_shape(images.shape[1] - 1)),
                "enable": In(1, init=1),
                "words": Out(signed(bits)).array(len(images)),
                **({"write": In(len(images)), "data": In(signed(bits))} if loaded else {}),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        if self._target == "ecp5":
            for first in range(0, len(self._images), 2):
                self._pair(m, first)
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

    def _pair(self, m: Module, first: int) -> None:
        """Block memories of two images, or of the last one."""
        images = self._images[first : first + 2]
        parts = _slices(self._bits, images.shape[1])
        slices = [self._slice(m, first, images, low, bits) for low, bits in parts]
        for number, words in enumerate(zip(*slices, strict=True)):
            m.d.comb += self.words[first + number].eq(Cat(*words))

    def _slice(self, m: Module, first: int, images: Ints, low: int, bits: int) -> list[Value]:
        """``bits`` from ``low`` of every image's word, from as many memories as the depth needs."""
        name, size = f"memory{first}_{low}", MEMORY_WORDS[bits]
        found: list[list[Value]] = [[] for _ in images]
        for start in range(0, images.shape[1], size):
            part = images[:, start : start + size]
            for group in _groups(part, size):
                writes = self._writes([first + number for number in group], start // size, size)
                data = Cat(self.data, Const(0, bits))[low : low + bits] if self._loaded else None
                memory = self._block(part[group] >> low, bits, writes, data)
                m.submodules[f"{name}_{start}_{group[0]}"] = memory
                for number, word in zip(group, memory.words, strict=True):
                    found[number].append(word)
        if len(found[0]) == 1:
            return [words[0] for words in found]
        block = self._delayed(m, self.address[(size - 1).bit_length() :])
        return [Array(words)[block] for words in found]

    def _writes(self, numbers: list[int], block: int, size: int) -> list[Value]:
        """Enables of images ``numbers``, in the memory of words from ``block * size`` on."""
        if not self._loaded:
            return []
        above = self.address[(size - 1).bit_length() :]
        return [self.write[number] & (above == block if len(above) else 1) for number in numbers]

    def _block(self, images: Ints, bits: int, writes: list[Value], data: Value | None) -> Words:
        """One memory of up to two images: the second, read by the second port, starts in the middle."""
        size = MEMORY_WORDS[bits]
        starts = range(0, size, size // len(images))
        content = np.zeros(size, dtype=np.int64)
        for start, image in zip(starts, images, strict=True):
            content[start : start + len(image)] = image
        place = self.address[: (size // len(images) - 1).bit_length()]
        return Words(content.tolist(), bits, [(place | start) for start in starts], self.enable, writes, data)

    def _delayed(self, m: Module, value: Value) -> Value:
        """``value`` at the time of its word."""
        for _ in range(self.latency):
            later = Signal(value.shape(), name="block", reset_less=True)
            with m.If(self.enable):
                m.d.sync += later.eq(value)
            value = later
        return value


def _slices(bits: int, depth: int) -> Iterator[tuple[int, int]]:
    """Lowest bit and length of the memories' words that make up one of ``bits``.

    Deep memories of short words save a multiplexer for each bit, so they are used where they are not more.
    """
    long, short = max(MEMORY_WORDS), min(MEMORY_WORDS)
    deep = long // short * -(-depth // MEMORY_WORDS[short]) <= -(-depth // MEMORY_WORDS[long])
    lengths = [short] if deep else [long, short]
    low = 0
    while low < bits:
        length = min((length for length in lengths if length >= bits - low), default=max(lengths))
        yield low, length
        low += length


def _groups(images: Ints, size: int) -> list[list[int]]:
    """Images that share a memory of ``size`` words."""
    numbers = list(range(len(images)))
    return [numbers] if 2 * images.shape[1] <= size else [[number] for number in numbers]
