"""What registers must do, access by access: an oracle that knows the map and nothing of the gateware."""

import random
from collections.abc import Iterator
from typing import Any

from tests.hdl.bus.manager import OKAY, SLVERR
from tfra.hdl.bus.map import Kind, RegisterMap

Access = tuple[Any, ...]
"""``("write", address, word, strobe)``, ``("read", address)``; to hardware ``("happen", "REGISTER.field", value)``."""

KEPT = (Kind.SETTING, Kind.PORT)


class Model:
    """Values of all fields by ``REGISTER.field``, and the pulses that there have been."""

    def __init__(self, registers: RegisterMap) -> None:
        self.registers = {register.address: register for register in registers.registers}
        self.fields = {f"{r.name}.{f.name}": f for r in registers.registers for f in r.fields}
        self.values = {path: field.reset for path, field in self.fields.items()}
        self.pulses = dict.fromkeys((p for p, f in self.fields.items() if f.kind in (Kind.PULSE, Kind.PORT)), 0)

    def write(self, address: int, word: int, strobe: int = 15) -> int:
        register = self.registers.get(address & ~3)
        if register is None or not register.writable:
            return SLVERR
        enabled = sum(255 << 8 * byte for byte in range(4) if strobe >> byte & 1)
        for field in register.fields:
            path = f"{register.name}.{field.name}"
            new, bits = ((value & field.mask) >> field.low for value in (word & enabled, enabled))
            if field.kind in KEPT:
                self.values[path] = self.values[path] & ~bits | new
            if field.kind is Kind.EVENT:
                self.values[path] &= ~new
            if (field.kind is Kind.PULSE and new) or (field.kind is Kind.PORT and bits):
                self.pulses[path] += 1
                for each, other in self.fields.items():
                    self.values[each] = 0 if other.clear == path else self.values[each]
        return OKAY

    def read(self, address: int) -> tuple[int, int]:
        register = self.registers.get(address & ~3)
        if register is None or not register.readable:
            return 0, SLVERR
        shown = (f for f in register.fields if f.kind not in (Kind.PULSE, Kind.PORT))
        return sum(self.values[f"{register.name}.{f.name}"] << f.low for f in shown), OKAY

    def happen(self, path: str, value: int) -> None:
        """The hardware does to a field what it can do: set it, count it up, or give it ``value``."""
        kind, bits = self.fields[path].kind, self.fields[path].bits
        if kind is Kind.EVENT:
            self.values[path] = 1
        elif kind is Kind.COUNTER:
            self.values[path] = (self.values[path] + 1) % (1 << bits)
        else:
            self.values[path] = value

    @property
    def interrupt(self) -> int:
        return int(any(self.values[path] and self.values[f.enable] for path, f in self.fields.items() if f.enable))


def accesses(registers: RegisterMap, rng: random.Random, number: int) -> Iterator[Access]:
    """What software and hardware do, at random."""
    model, highest = Model(registers), registers.registers[-1].address
    driven = [p for p, f in model.fields.items() if f.kind in (Kind.STATUS, Kind.EVENT, Kind.COUNTER, Kind.CAPTURED)]
    for _ in range(number):
        action, address = rng.choice(["write", "read", "read", "happen"]), rng.randrange(highest + 12)
        if action == "write":
            word = rng.choice([rng.getrandbits(32), 1 << rng.randrange(32), 0, 0xFFFFFFFF])
            yield action, address, word, rng.choice([15, 15, rng.getrandbits(4)])
        elif action == "read":
            yield action, address
        else:
            path = rng.choice(driven)
            yield action, path, rng.getrandbits(model.fields[path].bits)


def bits(registers: RegisterMap) -> Iterator[Access]:
    """Every bit and every byte alone: written as 1, read, written as 0, read; only twice where software can't write."""
    for register in registers.registers:
        yield "read", register.address
        alone = [(1 << bit, 15) for bit in range(32)] + [(0xFFFFFFFF, 1 << byte) for byte in range(4)]
        for word, strobe in alone if register.writable else [(0xFFFFFFFF, 15)]:
            for each in (word, 0):
                yield from [("write", register.address, each, strobe), ("read", register.address)]
