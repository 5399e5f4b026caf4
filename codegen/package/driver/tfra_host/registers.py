"""Registers: ways to them, their numbers from ``constants.json`` beside this file, words made of fields, states."""

import json
import mmap
import os
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

CONSTANTS: dict[str, Any] = json.loads(Path(__file__).with_name("constants.json").read_text(encoding="utf-8"))
REGISTERS: dict[str, Any] = CONSTANTS["registers"]
LIMITS: dict[str, int] = CONSTANTS["limits"]
CODES: dict[str, int] = CONSTANTS["codes"]

UNITY_GAIN = LIMITS["unity_gain"]
"""A gain of 1."""
ERRORS = tuple(REGISTERS["ERRORS"]["fields"])
"""Names of errors, and of faults of frames."""
EVENTS = tuple(REGISTERS["INTERRUPT_STATUS"]["fields"])
"""Names of events that raise the interrupt."""
OPTIONS = ("taxel_forces", "drop_late", "check_sequence", "cut_through")
"""Names of options."""


class DeviceError(Exception):
    """The core is another, did not do what it was asked to, or sent a frame that can't be right."""


def crc32(words: Iterable[int]) -> int:
    """CRC-32 of words of 32 bits, lowest byte first."""
    return zlib.crc32(b"".join((word & 0xFFFFFFFF).to_bytes(4, "little") for word in words))


def design_hash(facts: Mapping[str, Any]) -> str:
    """What the registers CONFIG_HASH_HIGH and CONFIG_HASH_LOW of a design say, as 16 digits."""
    return str(facts["configuration_sha256"])[:16]


def signed(word: int, bits: int) -> int:
    """The low ``bits`` of a word in two's complement."""
    return ((word + (1 << (bits - 1))) & ((1 << bits) - 1)) - (1 << (bits - 1))


def part(word: int, low: int, bits: int) -> int:
    """``bits`` of a word from bit ``low`` on, unsigned."""
    return word >> low & ((1 << bits) - 1)


def packed(register: str, **values: int) -> int:
    """The word of a register with ``values`` in its fields; raises ``ValueError`` for one that does not fit."""
    word = 0
    for name, value in values.items():
        low, bits = REGISTERS[register]["fields"][name]
        if not 0 <= value < 1 << bits:
            raise ValueError(f"{register}.{name} has {bits} bits, got {value}")
        word |= value << low
    return word


def names(register: str, word: int) -> frozenset[str]:
    """Names of the fields that are not 0 in the word of a register."""
    return frozenset(name for name, (low, bits) in REGISTERS[register]["fields"].items() if part(word, low, bits))


def of_names(register: str, chosen: Iterable[str], known: Sequence[str]) -> int:
    """The word of a register with the fields ``chosen`` set; raises ``ValueError`` for one that is not ``known``."""
    found = set(chosen)
    if unknown := found - set(known):
        raise ValueError(f"{', '.join(sorted(unknown))}: the names are {', '.join(known)}")
    return packed(register, **dict.fromkeys(found, 1))


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


@dataclass(frozen=True)
class FrontEnd:
    """Settings of the front end; see the registers FRONT_END, THRESHOLDS and STUCK."""

    word_bits: int
    is_unsigned: bool = False
    invert: bool = False
    log2_average: int = 0
    dead_band: int = 0
    contact: int = 0
    stuck_frames: int = 0


@dataclass(frozen=True)
class ContactSettings:
    """How contacts on a skin are told apart; see the register CONTACTS."""

    most: int
    threshold: int
    gap: int


@dataclass(frozen=True)
class Counters:
    """Counters of one cycle; they wrap."""

    frames_in: int
    frames_out: int
    frames_dropped: int
    frames_saturated: int
    frame_cycles: int


@dataclass(frozen=True)
class Load:
    """Progress of the load: coefficients taken since the reset, their CRC-32, and whether it is the expected one."""

    count: int
    crc: int
    match: bool
    loaded: bool


@dataclass(frozen=True)
class FaultyTaxel:
    """The last taxel with a fault; ``index`` row by row, from 0."""

    index: int
    saturated: bool
    out_of_range: bool
    stuck: bool
