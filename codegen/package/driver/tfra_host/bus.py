"""Ways to the registers."""

import mmap
import os
from typing import Protocol


class Bus(Protocol):
    """The way to the registers; addresses are in bytes from the core's base."""

    def read32(self, address: int) -> int:
        """The word of a register."""

    def write32(self, address: int, word: int) -> None:
        """Write the word of a register."""


class Mapped:
    """Registers in memory: ``/dev/uioN``, or ``/dev/mem`` and the ``offset`` of the core, a multiple of the page."""

    def __init__(self, path: str, offset: int = 0) -> None:
        file = os.open(path, os.O_RDWR | os.O_SYNC)
        try:
            self._memory = mmap.mmap(file, mmap.PAGESIZE, offset=offset)
        finally:
            os.close(file)
        self._words = memoryview(self._memory).cast("I")

    def read32(self, address: int) -> int:
        return self._words[address // 4]

    def write32(self, address: int, word: int) -> None:
        self._words[address // 4] = word

    def close(self) -> None:
        self._words.release()
        self._memory.close()
