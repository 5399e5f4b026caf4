"""All files of a core for an HLS tool: C++ in the layout of hls4ml, a testbench with recorded frames, project files."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from importlib.resources import files as resources
from string import Template
from typing import Any

from tfra.codegen.blocks.constants import constants
from tfra.codegen.blocks.result import NAMED, dimensions, gathered
from tfra.codegen.blocks.tables import Table, numbers, tables
from tfra.codegen.blocks.types import types
from tfra.codegen.hls.lanes import lane_constants
from tfra.codegen.hls.loops import functions
from tfra.codegen.hls.schedule import schedule
from tfra.codegen.hls.source import pipelined, sources
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.testbench import recorded
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

_PROJECT = {"part": "xc7z020clg400-1", "period": 10}
"""Part and clock period in ns of the project files: of boards that many have."""

_BLOCK_MEMORY = 140 * 36 / 1024
"""Mbit of this part's block memories."""


def files(design: Design) -> dict[str, str]:
    """Text of every file by its name; raises ``ValueError`` as :func:`sidecar`, for formats that can overflow."""
    facts, name, codes = sidecar(design), design.name, recorded(design)
    values = _values(design, facts)
    firmware = _firmware(design, values)
    return {f"firmware/{file}": text for file, text in firmware.items()} | {
        f"{name}_test.cpp": _filled("test.cpp", values, names=_names(design)),
        "tb_data/tb_input_features.dat": data(codes),
        "tb_data/tb_output_predictions.dat": data(design.model(codes).words),
        "build_prj.tcl": _filled("build_prj.tcl", values),
        "hls_config.cfg": _filled("hls_config.cfg", values),
        "README.md": _filled("README.md", values, **_expected(design, firmware)),
        f"{name}.json": json.dumps(facts, indent=1) + "\n",
    }


def misfit(design: Design) -> str:
    """What the part of the project files certainly lacks; empty if nothing."""
    needed = sum(table.values.size * table.bits for table in tables(design)) / 2**20
    if needed <= _BLOCK_MEMORY:
        return ""
    return (
        f"sensor: tables of {needed:.1f} Mbit are over the {_BLOCK_MEMORY:.1f} Mbit of block memory of "
        f"{_PROJECT['part']}, which the project files name: give part= of a larger one"
    )


def data(frames: Ints) -> str:
    """Lines of a file in ``tb_data``, one a frame of ``frames (n, words)``."""
    return "".join(" ".join(map(str, frame)) + "\n" for frame in frames)


def _values(design: Design, facts: Mapping[str, Any]) -> dict[str, object]:
    """What the templates share; a beat has 32 bits, or 64 if a word needs more."""
    beat = 32 if max(design.word_bits, design.adc.bits) <= 32 else 64
    return _PROJECT | {
        "name": design.name,
        "NAME": design.name.upper(),
        "bits": design.adc.bits,
        "taxels": design.sensor.taxels,
        "words": design.frame_words,
        "beat": beat,
        "bytes": beat // 8,
        "computes": facts["computes"],
        "generator": facts["generator"],
    }


def _filled(file: str, values: Mapping[str, object], **more: object) -> str:
    text = resources("tfra.codegen.hls").joinpath("templates", file).read_text("utf-8")
    return Template(text).substitute(values, **more)


def _firmware(design: Design, values: Mapping[str, object]) -> dict[str, str]:
    blocks, found = sources(design), tables(design)
    top = _filled("core.cpp", values, put=_put(design), includes=_includes("blocks", blocks))
    return {
        f"{design.name}.cpp": pipelined(top),
        f"{design.name}.h": _filled("core.h", values),
        "defines.h": _defines(design, values),
        "parameters.h": _filled("parameters.h", values, includes=_includes("weights", (t.name for t in found))),
        **{f"blocks/{block}.h": text for block, text in blocks.items()},
        **{f"weights/{table.name}.h": _weights(table) for table in found},
    }


def _includes(folder: str, names: Iterable[str]) -> str:
    return "\n".join(f'#include "{folder}/{name}.h"' for name in names)


def _put(design: Design) -> str:
    """Statements that send a result, word by word."""
    sent = re.sub(r"words\[place\+\+\] = (.*);", r"put(words, \1, ++place == WORDS);", gathered(design))
    return sent.replace("result->frame", "frame")


def _defines(design: Design, values: Mapping[str, object]) -> str:
    lines = []
    for about, section in constants(design).items():
        lines += [f"// {about[0].upper()}{about[1:]}.", *(f"#define {key} {n}" for key, n in section.items())]
    fields = {field.name: (f"ap_{'' if field.signed else 'u'}int<{field.bits}>", field) for field in design.layout}
    bits = types(design, fewest=0)
    kinds = {key: "table_word" if key == "coefficient_t" else "ap_int" for key in bits}
    declared = [f"typedef {kinds[key]}<{bits[key]}> {key};" for key in bits]
    declared += [f"typedef {fields[key][0]} {kind};" for key, kind in NAMED.items() if key in fields]
    return _filled(
        "defines.h",
        values,
        constants="\n".join([*lines, f"#define WORDS {design.frame_words}"]),
        lanes="\n".join(f"static const int {key} = {n};" for key, n in lane_constants(design).items()),
        types="\n".join(declared),
        fields="\n".join(
            f"    {kind} {name}{dimensions(field.count)};" for name, (kind, field) in fields.items() if name != "frame"
        ),
    )


def _weights(table: Table) -> str:
    declared = f"static const table_word<{table.bits}> {table.name}[{table.values.size}]"
    return f"// {table.text[0].upper()}{table.text[1:]}.\n{declared} = {{\n{numbers(table.values)}\n}};\n"


def _names(design: Design) -> str:
    return ",\n".join(f'    {{{field.start}, "{field.name}"}}' for field in design.layout)


def _expected(design: Design, firmware: Mapping[str, str]) -> dict[str, object]:
    """What the README says of the schedule."""
    values = {name: n for section in constants(design).values() for name, n in section.items()}
    values |= lane_constants(design) | {"WORDS": design.frame_words}
    top = firmware[f"{design.name}.cpp"]
    found = functions("\n".join(text for file, text in firmware.items() if file.startswith("blocks/")) + top)
    cycles = schedule(found, design.name, values)
    return {
        "schedule": "\n".join(f"| `{name}` | {count:,} |" for name, count in cycles.items()),
        "interval": f"{max(cycles.values()):,}",
        "latency": f"{sum(cycles.values()):,}",
        "lanes": "\n".join(_lanes(design)),
    }


def _lanes(design: Design) -> Iterator[str]:
    constants = lane_constants(design)
    for stack in design.stacks.values():
        for op in stack.operators:
            lanes, reuse = (constants[f"{kind}_{op.name.upper()}"] for kind in ("LANES", "REUSE"))
            yield f"| `{op.name}` | {op.rows.size:,} | {lanes} | {reuse} |"
