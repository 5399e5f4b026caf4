"""One text in C for all designs of a shape, which are given to it as constants and tables: none is compiled."""

from importlib.resources import files as resources
from string import Template

import numpy as np

from tfra.codegen.blocks.constants import constants
from tfra.codegen.blocks.dialect import in_c
from tfra.codegen.blocks.program import blocks
from tfra.codegen.blocks.result import NAMED, dimensions, gathered
from tfra.codegen.blocks.tables import tables
from tfra.codegen.blocks.types import types, vectors
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

_SHAPE = ("the array", "the parities of a vector", "status bits")
"""Sections of constants that a shape has."""
_SIZES = ("STEPS", "CANDIDATES", "SWEEP_HALF", "UNITS1", "UNITS2", "MOST_UNITS")
_WAYS = ("TAXEL_FORCES", "HALF_EVEN", "TRUNCATE")
"""Further ones: sizes of arrays, and what chooses lines of the blocks."""


def shaped(design: Design) -> str:
    """The text, the same for designs whose words fill the same of 32 and 64 bits."""
    given, fixed = _split(design)
    kinds = {name: _integer(bits) for name, bits in types(design).items()} | dict.fromkeys(NAMED.values(), "int64_t")
    members = [f"vector_t {name}[{words}]" for name, words in vectors(design).items()]
    fields = (f"int64_t {field.name}{dimensions(field.count)}" for field in design.layout)
    text = resources("tfra.codegen.c").joinpath("templates", "shaped.c").read_text("utf-8")
    return Template(text).substitute(
        fixed="\n".join(f"#define {name} {value}" for name, value in fixed.items()),
        count=len(given),
        given="\n".join(f"#define {name} given[{place}]" for place, name in enumerate(given)),
        types="\n".join(f"typedef {kind} {name};" for name, kind in kinds.items()),
        fields="\n".join(f"    {field};" for field in fields),
        members="\n".join(f"    {member};" for member in members),
        tables="\n".join(f"static const {_integer(table.bits)} *{table.name};" for table in tables(design)),
        blocks="\n".join(map(in_c, blocks(design).values())),
        chosen="\n".join(f"    {table.name} = tables[{place}];" for place, table in enumerate(tables(design))),
        gather=gathered(design),
    )


def arguments(design: Design) -> tuple[Ints, list[Ints]]:
    """The constants and the tables of ``design`` for its shape."""
    found = [table.values.astype(f"i{_size(table.bits)}") for table in tables(design)]
    return np.array([*_split(design)[0].values()], dtype=np.int64), found


def _split(design: Design) -> tuple[dict[str, int], dict[str, int]]:
    """Constants that are given, and those of the shape."""
    given: dict[str, int] = {}
    fixed: dict[str, int] = {}
    for about, section in constants(design).items():
        for name, value in section.items():
            (fixed if about in _SHAPE or name in (*_SIZES, *_WAYS) else given)[name] = value
    return given, fixed


def _size(bits: int) -> int:
    return 4 if bits <= 32 else 8


def _integer(bits: int) -> str:
    return f"int{8 * _size(bits)}_t"
