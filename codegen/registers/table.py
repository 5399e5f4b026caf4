"""The register map of a design as a table and as a page."""

from tfra.hdl.bus.map import Field, Kind, RegisterMap
from tfra.report.html import Section, page, paragraph
from tfra.report.table import Table

_ACCESS = {Kind.PULSE: "W pulse", Kind.PORT: "W", Kind.SETTING: "R/W", Kind.EVENT: "R/W1C"}
"""What software may do; it only reads the other kinds."""

_FIELD = ("bits", "field", "access", "reset", "meaning")


def register_table(registers: RegisterMap) -> Table:
    """A row for every field, in the order of addresses."""
    rows = []
    for register in registers.registers:
        place = (f"0x{register.address:02X}", register.name)
        for field in register.fields:
            rows.append((*place, *_field(field)))
            place = ("", "")
    return Table("Registers", ("address", "register", *_FIELD), rows, (0, 1, 3, 4, 6))


def register_page(title: str, registers: RegisterMap) -> str:
    """A page that loads nothing: a section for every register, with its fields."""
    sections = []
    for register in registers.registers:
        fields = Table(f"Fields of {register.name}", _FIELD, [_field(field) for field in register.fields], (1, 2, 4))
        heading = f"0x{register.address:02X} {register.name}"
        sections.append(Section(register.name, heading, [paragraph(register.text), fields.html()]))
    return page(title, [], sections)


def _field(field: Field) -> tuple[str, ...]:
    bits = f"{field.low + field.bits - 1}:{field.low}" if field.bits > 1 else f"{field.low}"
    reset = f"0x{field.reset:X}" if field.reset > 9 else f"{field.reset}"
    return bits, field.name, _ACCESS.get(field.kind, "R"), "–" if field.kind is Kind.STATUS else reset, field.text
