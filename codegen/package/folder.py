"""All files of a package, which drops into the FPGA project of a user."""

import json
from collections.abc import Callable, Mapping
from typing import Any

from tfra.codegen.config.names import check_packaged
from tfra.codegen.package.boards import boards
from tfra.codegen.package.contents import Contents, Part
from tfra.codegen.package.datasheet import datasheet
from tfra.codegen.package.drivers import driver_files
from tfra.codegen.package.projects import constraints, fusesoc, litex, readme, vivado
from tfra.codegen.registers.files import register_files
from tfra.codegen.sidecar.schema import schema
from tfra.codegen.verilog.wrapper import wrapper_verilog
from tfra.model.fixed.design import Design

WRITERS: tuple[Callable[[Contents], dict[str, str]], ...] = (
    lambda contents: {f"{contents.wrapper}.v": wrapper_verilog(contents.design)},
    lambda contents: {"core.schema.json": schema()},
    lambda contents: register_files(contents.design),
    lambda contents: driver_files(contents.design),
    lambda contents: {**contents.cells, **contents.rules},
    boards,
    constraints,
    vivado,
    litex,
    fusesoc,
    datasheet,
    readme,
)
"""Each makes texts of files by their names, and sees those of the writers before it: some list the others' files."""


def package(design: Design, texts: Mapping[str, str], part: Part) -> dict[str, str]:
    """Texts of all files of a package by their names, those of ``texts`` not among them.

    Raises ``InputError`` without the packages of the extra ``ip``, and ``ValueError`` for a name that one of the
    languages keeps for itself.
    """
    check_packaged(design.name)
    facts: dict[str, Any] = json.loads(texts[f"{design.name}.json"])
    made: dict[str, str] = {}
    for write in WRITERS:
        made |= write(Contents(design, facts, {**texts, **made}, part))
    return made
