"""Counts of a core in the text of its RTLIL: the oracle of :mod:`tfra.synth.cell_count`, which never makes any."""

import re
from collections import Counter
from collections.abc import Iterator

from tfra.families.hierarchy import block_of
from tfra.synth.cell_count import CellCount, Memory

_ADD = ("$add", "$sub", "$neg", "$lt", "$le", "$gt", "$ge")
_SHIFT = ("$shl", "$shr", "$sshl", "$sshr", "$shift", "$shiftx")
_LOGIC = ("$and", "$or", "$xor", "$xnor")
_REDUCE = ("$eq", "$ne", "$reduce_or", "$reduce_and", "$reduce_xor", "$reduce_bool")


def count(rtlil: str) -> dict[str, CellCount]:
    """Counts by block in the text of a top module's RTLIL; see :func:`block_of` for the names."""
    blocks: dict[str, CellCount] = {}
    modules = list(_modules(rtlil))
    own = {name for name, _ in modules}
    for name, body in modules:
        found = blocks.setdefault(block_of(name.partition(".")[2]), CellCount())
        found += _count_module(body, own)
    return blocks


def _modules(rtlil: str) -> Iterator[tuple[str, list[str]]]:
    for text in re.split(r"^module ", rtlil, flags=re.MULTILINE)[1:]:
        head, *lines = text.splitlines()
        yield head.strip().lstrip("\\"), [line.strip() for line in lines]


def _count_module(lines: list[str], own: set[str]) -> CellCount:
    found, reads, writes, memories = CellCount(), Counter[str](), Counter[str](), dict[str, tuple[int, int]]()
    resets: list[bool] = []  # for every open switch: does it look at the reset?
    cell, facts = "", dict[str, str]()
    for line in lines:
        word, _, rest = line.partition(" ")
        if word == "memory":
            fields = rest.split()
            memories[fields[-1]] = (int(fields[fields.index("size") + 1]), int(fields[fields.index("width") + 1]))
        elif word == "cell":
            cell, facts = rest.split()[0], {}
        elif word in ("parameter", "connect") and cell:
            key, _, value = rest.removeprefix("signed ").partition(" ")
            facts[key] = value
        elif word == "switch":
            resets.append(rest.startswith("\\rst "))
        elif word == "assign" and resets and not any(resets):
            found.operators["mux"] += _slice_bits(rest)
        elif word == "end" and cell:
            if cell in ("$memrd_v2", "$memwr_v2"):
                (reads if cell == "$memrd_v2" else writes)[facts["\\MEMID"].strip('"').removeprefix("\\")] += 1
            _count_cell(found, cell, facts, own)
            cell = ""
        elif word == "end" and resets:
            resets.pop()
    found.memories = [Memory(*size, reads[name], name not in writes) for name, size in memories.items()]
    return found


def _slice_bits(assignment: str) -> int:
    """Bits of an assignment's left side, ``NAME [LAST:FIRST]`` or ``NAME [BIT]``: Amaranth always writes the slice."""
    match = re.match(r"\S+ \[(\d+)(?::(\d+))?\]", assignment)
    if not match:
        raise ValueError(f"RTLIL: no slice is assigned in {assignment!r}")
    return int(match[1]) - int(match[2] or match[1]) + 1


def _count_cell(found: CellCount, cell: str, facts: dict[str, str], own: set[str]) -> None:
    def bits(*keys: str) -> int:
        return max(int(facts.get(f"\\{key}", "0")) for key in keys)

    operands = bits("A_WIDTH", "B_WIDTH")
    if cell == "$dff":
        found.registers += bits("WIDTH")
    elif cell == "$mul":
        if (widths := (bits("A_WIDTH"), bits("B_WIDTH"))) and min(widths) > 1:
            found.multipliers.append(widths)
    elif cell in _ADD:
        found.operators["add"] += operands
    elif cell in _SHIFT:
        if not facts["\\B"][0].isdigit():  # by a constant is free
            found.operators["shift"] += bits("Y_WIDTH") * min(bits("B_WIDTH"), bits("A_WIDTH").bit_length())
    elif cell in _LOGIC:
        found.operators["logic"] += bits("Y_WIDTH")
    elif cell in _REDUCE:
        found.operators["reduce"] += operands
    elif cell == "$mux":
        found.operators["mux"] += bits("WIDTH")
    elif not cell.startswith("$") and cell.removeprefix("\\") not in own:
        found.instances[cell.removeprefix("\\")] += 1
