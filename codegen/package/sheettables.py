"""Tables of the datasheet: ports, words, registers, cycles, resources, accuracy."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from tfra.codegen.package.accuracy import accuracy
from tfra.codegen.package.contents import Contents
from tfra.codegen.verilog.wrapper import ports_of, wrapper
from tfra.hdl.bus.map import Field, Kind, Register
from tfra.hdl.ip.framer import FAULTS, HEADER_WORDS
from tfra.recordings.facts import MEANINGS, status_label
from tfra.report.html import grid, row

_ACCESS = {Kind.PULSE: "W pulse", Kind.PORT: "W", Kind.SETTING: "R/W", Kind.EVENT: "R/W1C"}


def _table(label: str, header: Sequence[str], rows: Iterable[Sequence[str]], numbers: Iterable[int] = ()) -> str:
    names = set(range(len(header))) - set(numbers)
    return grid(label, header, [(row(cells, names) for cells in rows)], names)


def wrapper_ports(contents: Contents) -> str:
    """Ports of NAME_axi."""
    rows = [(pin.name, pin.direction, f"{pin.bits}", pin.note) for pin in ports_of(contents.design)]
    return _table("Ports of the wrapper", ("port", "", "bits", "meaning"), rows, [2])


def core_ports(contents: Contents) -> str:
    """Ports of NAME."""
    rows = [(port["name"], port["direction"], f"{port['bits']}", port["note"]) for port in contents.facts["ports"]]
    return _table("Ports of the core", ("port", "", "bits", "meaning"), rows, [2])


def output_words(contents: Contents) -> str:
    """Every beat of an output frame, with the bits of each."""
    errors = contents.registers["ERRORS"].fields
    faults = [(f"{HEADER_WORDS - 1}", f"{f.low}", f.name, "", "", f.text) for f in errors if f.name in FAULTS]
    rows = [
        ("0", "15:0", "sequence", "", "1", "frames that arrived since the reset, good or bad, from 0: a gap is a loss"),
        ("0", "31:16", "user", "", "1", "s_axis_tuser of the frame"),
        *faults,
        ("1", "31:24", "format", "", "1", "1: this format; all other bits of the beat are 0"),
    ]
    for field, fact in zip(contents.design.layout, contents.facts["result"]["fields"], strict=True):
        first = HEADER_WORDS + field.start
        beats = f"{first}" if field.count == 1 else f"{first} … {first + field.count - 1}"
        extended = "sign" if field.signed else "zeros"
        bits = f"{field.bits - 1}:0, {extended} above"
        value = f"{field.lsb:.6g} {field.unit}" if field.unit != "1" else f"{field.lsb:.6g}"
        rows.append((beats, bits, field.name, fact["format"], value, fact["meaning"]))
    header = ("beat", "bits", "word", "format", "lsb", "meaning")
    return _table("Output frame", header, rows, [4])


def status_bits(contents: Contents) -> str:
    """Bits of the word status."""
    rows = [(f"{flag.bit_length() - 1}", status_label(flag), MEANINGS[flag]) for flag in contents.design.status_bits]
    return _table("Status", ("bit", "name", "meaning"), rows)


def registers(contents: Contents) -> str:
    """The register map, a row for each field."""
    rows: list[tuple[str, ...]] = []
    for register in contents.registers.registers:
        rows += [_register(register, field) for field in register.fields]
    return _table("Registers", ("address", "register", "bits", "field", "access", "reset", "meaning"), rows)


def _register(register: Register, field: Field) -> tuple[str, ...]:
    first = field is register.fields[0]
    bits = f"{field.low + field.bits - 1}:{field.low}" if field.bits > 1 else f"{field.low}"
    reset = "–" if field.kind is Kind.STATUS else f"0x{field.reset:X}" if field.reset > 9 else f"{field.reset}"
    place = (f"0x{register.address:02X}", register.name) if first else ("", "")
    return (*place, bits, field.name, _ACCESS.get(field.kind, "R"), reset, field.text)


def cycles(contents: Contents) -> str:
    """Latency and interval, in cycles and µs at the part's clock."""
    facts, part = contents.facts, contents.part
    latency, added = facts["latency_cycles"], wrapper(contents.design).latency
    rows = [
        ("from s_axis_tlast to the first result word on m_axis, which is its beat 2", latency["first_word"] + added),
        ("from s_axis_tlast to m_axis_tlast", latency["last_word"] + added),
        ("from the core's last taxel to its first result word", latency["first_word"]),
        ("from the core's last taxel to its last result word", latency["last_word"]),
        ("from frame to frame, back to back", facts["interval_cycles"]),
    ]
    shown = [(text, f"{number:,}", f"{part.microseconds(number):,.2f}") for text, number in rows]
    return _table("Cycles", ("", "cycles", f"µs at {part.clock_mhz:g} MHz"), shown, [1, 2])


def resources(contents: Contents) -> str:
    """What the core takes of its part."""
    rows = [
        (name, f"{used:,}", f"{have:,}", f"{100 * used / have:.0f} %")
        for name, (used, have) in contents.part.resources.items()
    ]
    return _table("Resources", ("", "core", contents.part.name, ""), rows, [1, 2, 3])


def errors(contents: Contents) -> tuple[int, str]:
    """Contacts that count, and the errors of the core on them."""
    count, found = accuracy(contents.design)
    rows = [(error.reference, error.name, f"{error.median:.3g}", f"{error.high:.3g}") for error in found]
    return count, _table("Accuracy", ("against", "error of", "median", "95th percentile"), rows, [2, 3])
