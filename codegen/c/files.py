"""All files of a core in C: its header, its source, its tables, a test that checks itself, and what builds them."""

import json
from collections.abc import Iterable, Iterator, Mapping
from importlib.resources import files as resources
from string import Template
from typing import Any

from tfra.codegen.blocks.constants import constants
from tfra.codegen.blocks.dialect import in_c
from tfra.codegen.blocks.program import blocks
from tfra.codegen.blocks.result import NAMED, dimensions, gathered
from tfra.codegen.blocks.tables import Table, numbers, tables
from tfra.codegen.blocks.types import types
from tfra.codegen.c.memory import c_type, ram_bytes, size_of, stack_bytes, state
from tfra.codegen.c.steps import most_steps
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.testbench import recorded
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import supported

_CORTEX_M = ("cortex_m/start.c", "cortex_m/mps2_an500.ld", "cortex_m/measure.c")


def files(design: Design) -> dict[str, str]:
    """Text of every file by its name; raises ``ValueError`` as :func:`sidecar`, for formats that can overflow."""
    facts, name = sidecar(design), design.name
    values = shared(design, facts)
    return core(design, facts) | {
        f"{name}_test.c": _test(design, values),
        "CMakeLists.txt": filled("CMakeLists.txt", values),
        "README.md": filled("README.md", values, front_end=_of_front_end(design, "front_end.md", values)),
        f"{name}.json": json.dumps(facts, indent=1) + "\n",
        **{file: filled(file, values) for file in _CORTEX_M},
    }


def core(design: Design, facts: Mapping[str, Any]) -> dict[str, str]:
    """Header, source and tables, with the sidecar's ``facts``."""
    values, name = shared(design, facts), design.name
    return {
        f"{name}.h": _header(design, facts, values),
        f"{name}.c": _source(design, facts, values),
        f"{name}_tables.c": _tables(design, values),
    }


def shared(design: Design, facts: Mapping[str, Any]) -> dict[str, object]:
    """What the templates share, by its name there, with the sidecar's ``facts``."""
    return {
        "name": design.name,
        "NAME": design.name.upper(),
        "bits": design.adc.bits,
        "computes": facts["computes"],
        "generator": facts["generator"],
        "hash": facts["configuration_sha256"],
        "ram": ram_bytes(design),
        "stack": stack_bytes(design),
        "flash": sum(table.values.size * size_of(table.bits) for table in tables(design)),
    }


def filled(file: str, values: Mapping[str, object], **more: object) -> str:
    """The template ``file`` with ``values``, and ``more`` that only it has."""
    text = resources("tfra.codegen.c").joinpath("templates", file).read_text("utf-8")
    return Template(text).substitute(values, **more)


def _of_front_end(design: Design, file: str, values: Mapping[str, object]) -> str:
    """A template of the front end; empty for a design that it can't be built for."""
    return filled(file, values) if supported(design) else ""


def _header(design: Design, facts: Mapping[str, Any], values: Mapping[str, object]) -> str:
    fields, name = facts["result"]["fields"], str(values["NAME"])
    lsb = {f["name"]: f for f in fields if f["lsb"] != 1}
    scales = (f"#define {name}_{f['name'].upper()}_LSB {f['lsb']!r} // {f['unit']}" for f in lsb.values())
    return filled(
        "core.h",
        values,
        rows=design.sensor.rows,
        columns=design.sensor.columns,
        taxels=design.sensor.taxels,
        lsb_pa=f"{design.adc.lsb:.6g}",
        code_type=c_type(design.adc.bits),
        products=f"{design.multiplications:,}",
        steps=f"{most_steps(design):,}",
        fields="\n".join(map(_member, fields)),
        status="\n".join(_enumerated(facts["result"]["status_bits"], name)),
        scales="\n".join(scales),
        state="\n".join(f"    {kind} {member};" for kind, member in state(design)),
        front_end=_of_front_end(design, "front_end.h", values),
    )


def _kind(field: Mapping[str, Any]) -> str:
    return c_type(field["bits"], signed=field["signed"])


def _member(field: Mapping[str, Any]) -> str:
    unit = "" if field["lsb"] == 1 else f"; {field['lsb']:.6g} {field['unit']}".removesuffix(" 1")
    return f"    {_kind(field)} {field['name']}{dimensions(field['count'])}; // {field['meaning']}{unit}"


def _enumerated(bits: Iterable[Mapping[str, Any]], name: str) -> Iterator[str]:
    yield "enum {"
    for bit in bits:
        yield f"    {name}_{bit['name']} = {1 << bit['bit']}, // {bit['meaning']}"
    yield "};"


def _source(design: Design, facts: Mapping[str, Any], values: Mapping[str, object]) -> str:
    lines = []
    for about, section in constants(design).items():
        lines += [f"// {about[0].upper()}{about[1:]}.", *(f"#define {key} {n}" for key, n in section.items())]
    fields = {field["name"]: field for field in facts["result"]["fields"]}
    kinds = [f"typedef {c_type(bits)} {key}; // {bits} bits" for key, bits in types(design).items()]
    kinds += [f"typedef {_kind(fields[key])} {kind};" for key, kind in NAMED.items() if key in fields]
    declared = (
        f"extern {_declared(table, design.name)}; // {table.text}\n#define {table.name} {_global(table, design.name)}"
        for table in tables(design)
    )
    return filled(
        "core.c",
        values,
        constants="\n".join(lines),
        types="\n".join(kinds),
        tables="\n".join(declared),
        blocks="\n".join(map(in_c, blocks(design).values())),
        front_end=_of_front_end(design, "front_end.c", values),
    )


def _global(table: Table, name: str) -> str:
    return f"{name}_{table.name.lower()}"


def _declared(table: Table, name: str) -> str:
    return f"const {c_type(table.bits)} {_global(table, name)}[{table.values.size}]"


def _tables(design: Design, values: Mapping[str, object]) -> str:
    head = f"// Tables of {design.name}.\n// Generated by {values['generator']}; do not edit.\n#include <stdint.h>\n"
    defined = (
        f"\n// {table.text[0].upper()}{table.text[1:]}.\nextern {_declared(table, design.name)};\n"
        f"{_declared(table, design.name)} = {{\n{numbers(table.values)}\n}};\n"
        for table in tables(design)
    )
    return head + "".join(defined)


def _test(design: Design, values: Mapping[str, object]) -> str:
    codes = recorded(design)
    words = design.model(codes).words
    return filled(
        "test.c",
        values,
        frames=len(codes),
        words=design.frame_words,
        codes=",\n".join(f"    {{\n{numbers(frame)}}}" for frame in codes),
        expected=",\n".join(f"    {{\n{numbers(frame)}}}" for frame in words),
        names=",\n".join(f'    {{{f.start}, "{f.name}"}}' for f in design.layout),
        gather=gathered(design),
    )
