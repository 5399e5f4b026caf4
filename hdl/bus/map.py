"""A map of registers as plain data: gateware, tables and tests follow from it."""

from dataclasses import dataclass
from enum import Enum

BITS = 32
"""Bits of a register and of the bus."""
BYTES = BITS // 8


class Kind(Enum):
    """What software and hardware do with a field; the value says so in a word."""

    CONSTANT = "constant"  # software reads the reset value
    STATUS = "status"  # software reads an input
    SETTING = "setting"  # software reads and writes; an output
    PULSE = "pulse"  # software writes 1 for a pulse of one cycle on an output, and reads 0
    PORT = "port"  # software writes a word; an output, with a pulse for each write
    EVENT = "event"  # an input sets it, and wins; software reads, and clears by writing 1
    COUNTER = "counter"  # an input counts it up, and it wraps; software reads
    CAPTURED = "captured"  # an input is stored when another is high; software reads

    @property
    def readable(self) -> bool:
        return self not in (Kind.PULSE, Kind.PORT)

    @property
    def writable(self) -> bool:
        return self in (Kind.SETTING, Kind.PULSE, Kind.PORT, Kind.EVENT)


@dataclass(frozen=True)
class Field:
    """``bits`` of a register from bit ``low`` on.

    ``clear`` names the pulse that clears a counter, ``enable`` the setting that lets an event raise the interrupt, both
    as ``REGISTER.field``; empty for none.
    """

    name: str
    low: int
    bits: int
    kind: Kind
    reset: int = 0
    clear: str = ""
    enable: str = ""
    text: str = ""

    @property
    def mask(self) -> int:
        """Its bits in the register's word."""
        return ((1 << self.bits) - 1) << self.low


@dataclass(frozen=True)
class Register:
    """A register at a byte ``address``, a multiple of ``BYTES``; its fields from the lowest on."""

    name: str
    address: int
    fields: tuple[Field, ...]
    text: str = ""

    @property
    def readable(self) -> bool:
        """Whether software may read it; other reads are answered with an error."""
        return any(field.kind.readable for field in self.fields)

    @property
    def writable(self) -> bool:
        """Whether software may write it; other writes are answered with an error, and change nothing."""
        return any(field.kind.writable for field in self.fields)

    @property
    def reset(self) -> int:
        """The word that software reads after a reset, all inputs being 0."""
        return sum(field.reset << field.low for field in self.fields if field.kind.readable)


@dataclass(frozen=True)
class RegisterMap:
    """Registers in the order of their addresses."""

    registers: tuple[Register, ...]

    @property
    def address_bits(self) -> int:
        """Bits of a byte address that tell the registers apart."""
        return (self.registers[-1].address + BYTES - 1).bit_length()

    def __getitem__(self, name: str) -> Register:
        """The register of that name; raises ``KeyError``."""
        return {register.name: register for register in self.registers}[name]
