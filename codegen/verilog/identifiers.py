"""Names of a netlist as plain Verilog identifiers, which no tool has to escape."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from tfra.codegen.config.keywords import KEYWORDS, SIMULATORS
from tfra.codegen.verilog.netlist import Cell, Module

_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def with_plain_names(modules: dict[str, Module]) -> dict[str, Module]:
    """``modules`` under plain names, as are their ports, wires, instances and memories.

    ``\\\\core.lane0`` becomes ``core__lane0``: cores of different names have no module in
    common.  Names that begin with ``$`` are yosys' own, which it replaces by numbers when it writes Verilog.
    """
    names = _renamed(modules, "__")
    inner = {name: _renamed(_named(module), "_") for name, module in modules.items()}
    return {names[name]: _module(module, names, inner) for name, module in modules.items()}


def _named(module: Module) -> Iterable[str]:
    """Every name in a module; those of operations but memories are not written."""
    yield from module.wires
    for cell in module.cells:
        yield cell.name
        if "\\MEMID" in cell.parameters:
            yield _memory(cell)


def _memory(cell: Cell) -> str:
    return cell.parameters["\\MEMID"][1:-1].replace("\\\\", "\\")


def _renamed(names: Iterable[str], separator: str) -> dict[str, str]:
    """A plain and unique name for each; names that are plain already keep theirs."""
    public = [name for name in dict.fromkeys(names) if name.startswith("\\")]
    taken = {name for name in public if _is_plain(name[1:])}
    renamed = {name: name for name in taken}
    for name in public:
        if name not in renamed:
            renamed[name] = _free(_plain(name[1:], separator), taken)
            taken.add(renamed[name])
    return renamed


def _is_plain(name: str) -> bool:
    return bool(_PLAIN.fullmatch(name)) and name not in KEYWORDS | SIMULATORS


def _plain(name: str, separator: str) -> str:
    word = re.sub(r"[^A-Za-z0-9_]", "_", name.replace(".", separator)).strip("_")
    return word if _is_plain(word) else f"n_{word}"


def _free(name: str, taken: set[str]) -> str:
    """``name``, with a number if it is taken."""
    number, found = 1, f"\\{name}"
    while found in taken:
        number += 1
        found = f"\\{name}_{number}"
    return found


def _module(module: Module, names: dict[str, str], inner: dict[str, dict[str, str]]) -> Module:
    own = inner[module.name]
    wires = (replace(wire, name=own.get(wire.name, wire.name)) for wire in module.wires.values())
    return replace(
        module,
        name=names[module.name],
        wires={wire.name: wire for wire in wires},
        cells=[_cell(cell, own, names, inner) for cell in module.cells],
    )


def _cell(cell: Cell, own: dict[str, str], names: dict[str, str], inner: dict[str, dict[str, str]]) -> Cell:
    pins = inner.get(cell.kind, {})
    parameters = cell.parameters
    if "\\MEMID" in parameters:
        memory = own.get(_memory(cell), _memory(cell)).replace("\\", "\\\\")
        parameters = parameters | {"\\MEMID": f'"{memory}"'}
    return Cell(
        names.get(cell.kind, cell.kind),
        own.get(cell.name, cell.name),
        parameters,
        {pins.get(pin, pin): word for pin, word in cell.pins.items()},
    )
