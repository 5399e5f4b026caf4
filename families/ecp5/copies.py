"""What drives many lanes gets copies, each for lanes that stand together: netlist in, netlist out.

yosys merges registers that hold the same, and one driver of all lanes has wires across the whole part.  A register that
drives the copies of the next has copies, too, fewer: a tree.
"""

import copy
from collections import defaultdict
from typing import Any

from tfra.families.hierarchy import lane_of

LANES = 4
"""Neighbours that share a copy."""

_DISTRICT = 4 * LANES
"""Neighbours that share a copy of what drives copies."""

_LUT, _REGISTER = "LUT4", "TRELLIS_FF"
_OUTPUTS = {_LUT: "Z", _REGISTER: "Q"}
"""What is copied, and its output."""

Reader = tuple[str, str, int]
"""Cell, port and place in the port."""


def spread(netlist: dict[str, Any], top: str) -> dict[str, int]:
    """Copy registers and lookup tables of module ``top`` of yosys' JSON; return how many of each were added."""
    module = netlist["modules"][top]
    # Lookup tables first, since the registers before them then drive their copies.
    tables, registers = _spread(module, _LUT, LANES), _spread(module, _REGISTER, LANES)
    return {_LUT: tables, _REGISTER: registers + _spread(module, _REGISTER, _DISTRICT)}


def _spread(module: dict[str, Any], kind: str, lanes: int) -> int:
    cells, readers, added = module["cells"], _readers(module), 0
    free = 1 + max(bit for net in module["netnames"].values() for bit in net["bits"] if isinstance(bit, int))
    for name in [name for name, cell in cells.items() if cell["type"] == kind]:
        (bit,) = cells[name]["connections"][_OUTPUTS[kind]]
        groups = defaultdict[int, list[Reader]](list)
        for reader in readers[bit]:
            if (lane := lane_of(reader[0])) is not None:
                groups[lane // lanes].append(reader)
        for group in sorted(groups)[1:]:
            _copy(module, name, f"{name}.matvec.lane{group * lanes}", free + added, groups[group])
            added += 1
    return added


def _readers(module: dict[str, Any]) -> dict[int | str, list[Reader]]:
    readers = defaultdict[int | str, list[Reader]](list)
    for name, cell in module["cells"].items():
        for port, bits in cell["connections"].items():
            if cell["port_directions"][port] == "input":
                for place, bit in enumerate(bits):
                    readers[bit].append((name, port, place))
    return readers


def _copy(module: dict[str, Any], name: str, twin: str, bit: int, readers: list[Reader]) -> None:
    """A copy of cell ``name`` drives ``bit``, which ``readers`` read; its name says the lanes that it belongs to."""
    cells = module["cells"]
    cells[twin] = copy.deepcopy(cells[name])
    cells[twin]["connections"][_OUTPUTS[cells[name]["type"]]] = [bit]
    module["netnames"][twin] = {"hide_name": 1, "bits": [bit], "attributes": {}}
    for cell, port, place in readers:
        cells[cell]["connections"][port][place] = bit
