"""What registers must do, access by access: an oracle that knows the map and nothing of the gateware."""

from __future__ import annotations

from tests.hdl.bus.manager import OKAY, SLVERR
from tfra.hdl.bus.map import Kind, RegisterMap

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
