"""Numbers that drivers need and that are no registers: the header of output frames, faults, tables, limits."""

from collections.abc import Mapping
from typing import Any

from tfra.hdl.bus.map import BITS, RegisterMap
from tfra.hdl.front_end.ports import NUMBER
from tfra.hdl.ip.framer import FAULTS, FORMAT, FORMAT_PLACE, HEADER_WORDS
from tfra.model.fixed.front_end import DEVIATION, GAIN, LEAST_WORD, MOST_AVERAGED, UNITY, WEIGHT, WORD
from tfra.model.fixed.repair import HEADER as REPAIR_HEADER
from tfra.model.tfra import Status

HEADER: Mapping[str, tuple[int, int, int]] = {
    "sequence": (0, 0, NUMBER),
    "user": (0, NUMBER, NUMBER),
    "faults": (1, 0, max(FAULTS.values()) + 1),
    "format": (1, FORMAT_PLACE, BITS - FORMAT_PLACE),
}
"""Fields before the result words of an output frame: beat, lowest bit, bits; a fault has the place of its error."""

TABLES = ("offsets", "gains", "repairs")
"""By their numbers in CALIBRATION_PLACE.kind."""
LIMITS = {
    "word_bits_least": LEAST_WORD,
    "word_bits_most": WORD,
    "log2_frames_most": MOST_AVERAGED,
    "unity_gain": UNITY,
}
"""Settings of the front end that registers could hold and hardware refuses are outside of these; the gain of 1."""
CODES = {
    "offset_bits": DEVIATION,
    "gain_bits": GAIN,
    "repair_weight_bits": WEIGHT,
    "repair_target_bit": REPAIR_HEADER.bit_length() - 1,
}
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
        "header_beats": HEADER_WORDS,
        "frame_format": FORMAT,
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
    numbers = {"header_beats": HEADER_WORDS, "frame_format": FORMAT, **LIMITS, **CODES}
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
