"""Drivers of a core with registers: files in C and in Python for a host."""

import json
from importlib.resources import files

from tfra.codegen.package.constants import constants, constants_header
from tfra.codegen.registers.values import parameters, registers_of
from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

C_FILES = ("tfra_driver.h", "tfra_driver.c", "tfra_frame.c", "tfra_units.h", "example.c")
PYTHON_FILES = (*(f"tfra_host/{part}.py" for part in ("__init__", "core", "frame", "registers")), "example.py")

_FIELDS = (
    *("frame", "exponent", "sweep_index", "phi", "mu", "mu_x", "mu_y"),
    *("resultant", "uncertainty", "forces", "status"),
)
"""In the order of ``tfra_config_t``."""
_WORDS_A_LINE = 8


def driver_files(design: Design) -> dict[str, str]:
    """The text of every file by its name, the same for the same design.

    ``driver/`` has the C driver with its constants, and ``python/`` the one in Python; ``registers/tfra.h`` of
    :func:`tfra.codegen.registers.files.register_files` belongs to the first, and the sidecar to the second.

    Raises ``InputError`` without the packages of the extra ``ip``.
    """
    source, loaded = files("tfra.codegen.package") / "driver", microarchitecture(design).loaded
    config = f"{design.name}_config"
    texts = {f"driver/{name}": (source / name).read_text(encoding="utf-8") for name in C_FILES}
    example = texts["driver/example.c"].splitlines(keepends=True)
    kept = "".join(line for line in example if loaded is not None or "NAME_coefficients" not in line)
    texts["driver/example.c"] = kept.replace("NAME_", f"{design.name}_")
    texts["driver/tfra_constants.h"] = constants_header()
    texts[f"driver/{config}.h"] = _config(design, config)
    if loaded is not None:
        texts[f"driver/{design.name}_coefficients.h"] = _coefficients(design.name, loaded)
    texts |= {f"python/{name}": (source / name).read_text(encoding="utf-8") for name in PYTHON_FILES}
    texts["python/example.py"] = texts["python/example.py"].replace("NAME.json", f"{design.name}.json")
    numbers = constants(registers_of(design))
    return texts | {"python/tfra_host/constants.json": json.dumps(numbers, indent=1) + "\n"}


def _config(design: Design, config: str) -> str:
    """``NAME_config.h``: a ``tfra_config_t``, member by member."""
    values, layout = parameters(design), {field.name: field for field in design.layout}
    members = [
        (f'"{design.name}"', "name"),
        (f"0x{values['HASH_HIGH']:08x}u, 0x{values['HASH_LOW']:08x}u", "hash"),
        (f"{design.sensor.rows}u, {design.sensor.columns}u", "rows, columns"),
        (f"{values['LOAD_LENGTH']}u", "load_words"),
        (f"{values['REPAIR_PLACES']}u", "repair_places"),
        (f"{design.frame_words}u", "words"),
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
    return _header(config, "The design, as the driver needs it.", ['#include "tfra_driver.h"', "", *lines])


def _coefficients(name: str, words: Ints) -> str:
    """``NAME_coefficients.h``: the words that ``tfra_load`` takes, in order."""
    numbers = [str(int(word)) for word in words]
    rows = [numbers[first : first + _WORDS_A_LINE] for first in range(0, len(numbers), _WORDS_A_LINE)]
    lines = [f"static const int32_t {name}_coefficients[{len(numbers)}] = {{"]
    lines += [*(f"    {', '.join(row)}," for row in rows), "};"]
    return _header(f"{name}_coefficients", "What the core is loaded with.", ["#include <stdint.h>", "", *lines])


def _header(stem: str, text: str, lines: list[str]) -> str:
    guard = f"{stem.upper()}_H"
    head = [f"/** @file {stem}.h", f" *  {text} */", f"#ifndef {guard}", f"#define {guard}", ""]
    return "\n".join([*head, *lines, "", "#endif"]) + "\n"
