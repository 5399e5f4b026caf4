"""The register map as a table in Markdown."""

from __future__ import annotations

from tfra.hdl.bus.map import Field, Kind, Register, RegisterMap

_ACCESS = {Kind.PULSE: "W pulse", Kind.PORT: "W", Kind.SETTING: "R/W", Kind.EVENT: "R/W1C"}
"""What software may do; it only reads the other kinds."""


def table(registers: RegisterMap) -> str:
    """A row for every field, in the order of addresses; constants have no reset value, as it is that of a design."""
    lines = ["| address | register | bits | field | access | reset | meaning |", "|---|---|---:|---|---|---:|---|"]
    lines += [_row(register, field) for register in registers.registers for field in register.fields]
    return "\n".join(lines)


def _row(register: Register, field: Field) -> str:
    first = field is register.fields[0]
    place = f"`0x{register.address:02X}` | `{register.name}`" if first else " | "
    bits = f"{field.low + field.bits - 1}:{field.low}" if field.bits > 1 else f"{field.low}"
    reset = "–" if field.kind in (Kind.CONSTANT, Kind.STATUS) else f"{field.reset}"
    access = _ACCESS.get(field.kind, "R")
    return f"| {place} | {bits} | `{field.name}` | {access} | {reset} | {field.text} |"
