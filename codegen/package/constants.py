"""Numbers that drivers need and that are no registers: the header of output frames, faults, tables, limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tfra.hdl.bus.map import RegisterMap
from tfra.model.tfra import Status

HEADER: Mapping[str, tuple[int, int, int]] = {
    "sequence": (0, 0, 16),
    "user": (0, 16, 16),
    "faults": (1, 0, 10),
    "format": (1, 24, 8),
}
"""Fields before the result words of an output frame: beat, lowest bit, bits; a fault has the place of its error."""
HEADER_BEATS = 2
FRAME_FORMAT = 1
"""What the field ``format`` says."""

TABLES = ("offsets", "gains", "repairs")
"""By their numbers in CALIBRATION_PLACE.kind."""
LIMITS = {"word_bits_least": 8, "word_bits_most": 16, "log2_frames_most": 6, "unity_gain": 1 << 15}
"""Settings of the front end that registers could hold and hardware refuses are outside of these; the gain of 1."""
CODES = {"offset_bits": 18, "gain_bits": 17, "repair_weight_bits": 18, "repair_target_bit": 31}
"""Bits of the words of the tables, and of their parts; a repair has its weight lowest, then the taxel."""


def constants(registers: RegisterMap) -> dict[str, Any]:
    """All of them as plain data, with the register map: what the Python driver reads as JSON."""
    return {
        "registers": {
            register.name: {
                "address": register.address,
                "reset": register.reset,
                "fields": {field.name: [field.low, field.bits] for field in register.fields},
            }
            for register in registers.registers
        },
        "header": {name: list(place) for name, place in HEADER.items()},
        "header_beats": HEADER_BEATS,
        "frame_format": FRAME_FORMAT,
        "tables": {name: number for number, name in enumerate(TABLES)},
        "limits": LIMITS,
        "codes": CODES,
        "status": {flag.name: flag.value for flag in Status},
    }


def constants_header() -> str:
    """``tfra_constants.h``: the same for C, but for the registers, which ``tfra.h`` has."""
    places = [
        (f"TFRA_HEADER__{name.upper()}_{ending}", f"{value}u")
        for name, (beat, low, bits) in HEADER.items()
        for ending, value in (("beat", beat), ("bp", low), ("bm", hex(((1 << bits) - 1) << low)))
    ]
    numbers = {"header_beats": HEADER_BEATS, "frame_format": FRAME_FORMAT, **LIMITS, **CODES}
    numbers |= {f"table_{name}": number for number, name in enumerate(TABLES)}
    places += [(f"TFRA_{name.upper()}", f"{value}u") for name, value in numbers.items()]
    places += [(f"TFRA_STATUS__{flag.name}", f"{hex(flag.value)}u") for flag in Status]
    lines = [
        "/** @file tfra_constants.h",
        " *  Header of output frames, tables, limits, flags of the status; the same for every design. */",
        "#ifndef TFRA_CONSTANTS_H",
        "#define TFRA_CONSTANTS_H",
        "",
        *(f"#define {name} {value}" for name, value in places),
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"
