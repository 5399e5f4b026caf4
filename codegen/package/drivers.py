"""Drivers of a core with registers: files in C and in Python for a host."""

import json
import re
from collections.abc import Mapping
from importlib.resources import files
from textwrap import wrap
from typing import Any

from tfra.codegen.registers.source import parameters, registers_of
from tfra.codegen.sidecar.build import HEADER as RECORD
from tfra.hdl.bus.map import BITS, RegisterMap
from tfra.hdl.cores import microarchitecture
from tfra.hdl.front_end.ports import NUMBER
from tfra.hdl.ip.framer import FAULTS, FORMAT, FORMAT_PLACE, HEADER_WORDS, RECORDS_FORMAT
from tfra.hdl.ip.output_stage import CUT
from tfra.model.arrays import Ints
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import DEVIATION, GAIN, LEAST_WORD, MOST_AVERAGED, UNITY, WEIGHT, WORD
from tfra.model.fixed.repair import HEADER as REPAIR_HEADER
from tfra.model.skin.finding import LARGEST_GAP, MARK_SHIFT, MOST, THRESHOLD_FRACTION, Mark
from tfra.model.skin.records import record_layout, record_words, results
from tfra.model.skin.scenes import recorded
from tfra.model.skin.skin import Skin, core_of
from tfra.model.skin.windows import PLACE_FRACTION
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
    "contacts_most": MOST,
    "gap_most": LARGEST_GAP,
    "unity_threshold": 1 << THRESHOLD_FRACTION,
    "unity_place": 1 << PLACE_FRACTION,
}
"""Settings that registers could hold and hardware refuses are outside of these; gain, threshold and pitch of 1."""
CODES = {
    "offset_bits": DEVIATION,
    "gain_bits": GAIN,
    "repair_weight_bits": WEIGHT,
    "repair_target_bit": REPAIR_HEADER.bit_length() - 1,
}
"""Bits of the words of the tables, and of their parts; a repair has its weight lowest, then the taxel."""

C_FILES = ("tfra_driver.h", "tfra_driver.c", "tfra_frame.c", "tfra_units.h", "example.c", "cosim.cpp")
PYTHON_FILES = tuple(f"tfra_host/{part}.py" for part in ("__init__", "contacts", "core", "frame", "registers"))
_OF_FRAMES = {"driver/show.h": "show_frame.h", "python/example.py": "example.py"}
_OF_CONTACTS = {"driver/show.h": "show_contacts.h", "python/example.py": "example_contacts.py"}
"""Files that show the words of a core, and of a skin, by their names in the package."""

_FIELDS = (
    *("frame", "exponent", "sweep_index", "phi", "mu", "mu_x", "mu_y"),
    *("resultant", "uncertainty", "forces", "status"),
)
"""In the order of ``tfra_config_t``."""
_WIDTH = 100
_RECORDED = 4
_SEED = 3
"""Simulated contacts in ``NAME_recorded.h``, and their seed."""


def driver_files(array: Design | Skin) -> dict[str, str]:
    """The text of every file by its name, the same for the same design.

    ``driver/`` has the C driver with its constants, and ``python/`` the one in Python; ``registers/tfra.h`` of
    :func:`tfra.codegen.registers.files.register_files` belongs to the first, and the sidecar to the second.

    Raises ``InputError`` without the packages of the extra ``ip``.
    """
    source, loaded = files("tfra.codegen.package") / "driver", microarchitecture(core_of(array)).loaded
    config = f"{array.name}_config"
    chosen = {f"driver/{name}": name for name in C_FILES} | {f"python/{name}": name for name in PYTHON_FILES}
    chosen |= _OF_CONTACTS if isinstance(array, Skin) else _OF_FRAMES
    texts = {name: (source / file).read_text(encoding="utf-8") for name, file in chosen.items()}
    for name in ("driver/example.c", "driver/cosim.cpp"):
        example = texts[name].splitlines(keepends=True)
        kept = "".join(line for line in example if loaded is not None or "NAME_coefficients" not in line)
        texts[name] = re.sub(r"NAME(?=_|\.v\b)", array.name, kept)
    texts[f"driver/{array.name}_recorded.h"] = _recorded(array)
    texts["driver/tfra_constants.h"] = _constants_header()
    texts[f"driver/{config}.h"] = _config(array, config)
    if loaded is not None:
        texts[f"driver/{array.name}_coefficients.h"] = _coefficients(array.name, loaded)
    texts["python/example.py"] = texts["python/example.py"].replace("NAME.json", f"{array.name}.json")
    numbers = _constants(registers_of(array))
    return texts | {"python/tfra_host/constants.json": json.dumps(numbers, indent=1) + "\n"}


def _constants(registers: RegisterMap) -> dict[str, Any]:
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
        "records_format": RECORDS_FORMAT,
        "frame_cut": CUT,
        "record": {name: place for place, name in enumerate(RECORD)},
        "tables": {name: number for number, name in enumerate(TABLES)},
        "limits": LIMITS,
        "codes": CODES,
        "status": {flag.name: flag.value for flag in Status},
        "marks": {mark.name: mark >> MARK_SHIFT for mark in Mark},
    }


def _constants_header() -> str:
    """``tfra_constants.h``: the same for C, but for the registers, which ``tfra.h`` has."""
    places = [
        (f"HEADER__{name.upper()}_{ending}", value)
        for name, (beat, low, bits) in HEADER.items()
        for ending, value in (("beat", beat), ("bp", low), ("bm", hex(((1 << bits) - 1) << low)))
    ]
    numbers = {"header_beats": HEADER_WORDS, "frame_format": FORMAT, "records_format": RECORDS_FORMAT}
    numbers |= {"frame_cut": CUT, **LIMITS, **CODES}
    numbers |= {f"table_{name}": number for number, name in enumerate(TABLES)}
    places += [(name.upper(), value) for name, value in numbers.items()]
    places += [(f"RECORD__{name.upper()}", place) for place, name in enumerate(RECORD)]
    places += [(f"STATUS__{flag.name}", hex(flag.value)) for flag in Status]
    places += [(f"MARK__{mark.name}", hex(mark >> MARK_SHIFT)) for mark in Mark]
    text = "Header of output frames and of records, tables, limits, flags; the same for every design."
    return _header("tfra_constants", text, [f"#define TFRA_{name} {value}u" for name, value in places])


def _config(array: Design | Skin, config: str) -> str:
    """``NAME_config.h``: a ``tfra_config_t``, member by member, and the most beats of an output frame."""
    design, values = core_of(array), parameters(array)
    layout = {field.name: field for field in design.layout}
    header, x_lsb, y_lsb, beats = 0, 0.0, 0.0, design.frame_words
    if isinstance(array, Skin):
        header, beats = len(RECORD), MOST * record_words(array)
        x_lsb, y_lsb = (next(f.lsb for f in record_layout(array) if f.name == name) for name in ("column", "row"))
    members = [
        (f'"{design.name}"', "name"),
        (f"0x{values['HASH_HIGH']:08x}u, 0x{values['HASH_LOW']:08x}u", "hash"),
        (f"{array.sensor.rows}u, {array.sensor.columns}u", "rows, columns"),
        (f"{values['LOAD_LENGTH']}u", "load_words"),
        (f"{values['REPAIR_PLACES']}u", "repair_places"),
        (f"{design.frame_words}u", "words"),
        (f"{header}u", "record_words"),
        (f"{x_lsb.hex()}, {y_lsb.hex()}", "x_lsb, y_lsb, m"),
    ]
    for name in _FIELDS:
        field = layout.get(name)
        shown = "{0u, 0u, 0u, false, 0.0}"
        if field is not None:
            signed = str(field.signed).lower()
            shown = f"{{{field.start}u, {field.count}u, {field.bits}u, {signed}, {field.lsb.hex()}}}"
        members.append((shown, name if field is None or field.unit == "1" else f"{name}, {field.unit}"))
    body = [f"    {value}, /* {text} */" for value, text in members]
    lines = [f"static const tfra_config_t {config} = {{", *body, "};"]
    most = f"#define {array.name}_MOST_BEATS {HEADER_WORDS + beats}u"
    return _header(config, "The design, as the driver needs it.", ['#include "tfra_driver.h"', "", most, *lines])


def _coefficients(name: str, words: Ints) -> str:
    """``NAME_coefficients.h``: the words that ``tfra_load`` takes, in order."""
    numbers = wrap(", ".join(map(str, words.tolist())), _WIDTH)
    lines = [f"static const int32_t {name}_coefficients[{words.size}] = {{", *numbers, "};"]
    return _header(f"{name}_coefficients", "What the core is loaded with.", ["#include <stdint.h>", "", *lines])


def _recorded(array: Design | Skin) -> str:
    """``NAME_recorded.h``: frames of codes with the words that are due for them."""
    codes = recorded(array) if isinstance(array, Skin) else contact_codes(array, _RECORDED, _SEED)
    words = results(array, codes)
    rows = zip(codes % (1 << WORD), words, strict=True)
    frames = [f"{{{_listed(taxels)}}}, {result.size}u, {{{_listed(result)}}}" for taxels, result in rows]
    sizes = {"TAXELS": array.sensor.taxels, "TAXELS_PER_BEAT": core_of(array).bus.taxels_per_beat}
    lines = ["#include <stdint.h>", "", *(f"#define {array.name}_{name} {size}u" for name, size in sizes.items())]
    most = max(result.size for result in words)
    members = [f"uint16_t codes[{array.sensor.taxels}];", "uint32_t count;", f"int32_t words[{most}];"]
    lines += [f"static const struct {{ {' '.join(members)} }} {array.name}_recorded[{len(frames)}] = {{"]
    lines += [*(f"    {{{frame}}}," for frame in frames), "};"]
    return _header(f"{array.name}_recorded", "Frames, and the words of their results.", lines)


def _listed(numbers: Ints) -> str:
    return ", ".join(map(str, numbers.ravel().tolist()))


def _header(stem: str, text: str, lines: list[str]) -> str:
    guard = f"{stem.upper()}_H"
    head = [f"/** @file {stem}.h", f" *  {text} */", f"#ifndef {guard}", f"#define {guard}", ""]
    return "\n".join([*head, *lines, "", "#endif"]) + "\n"
