"""Sites of the hard blocks: multipliers and block memories, in the order in which data pass them.

nextpnr's analytic placer pulls cells together and towards what stands still.  The core has few pins, so without a
floorplan all cells begin in one heap, and how that is spread decides how long the wires are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tfra.families.hierarchy import block_of, lane_of

_MULTIPLIERS = {0: "MULT18_0", 1: "MULT18_1", 4: "MULT18_4", 5: "MULT18_5"}
_MEMORIES = {0: "EBR0", 2: "EBR1", 4: "EBR2", 6: "EBR3"}
"""Columns of a group's sites, behind the group's first, and their names."""

_MEMORY_CELLS = ("DP16KD", "PDPW16KD")

_APART = "front_end"
"""Its memories stand beside each other, wherever the placer wants them."""

_ORDER = ("sweep", "forces", "matvec", "combine")
"""Blocks with memories; those of neighbours exchange words."""

Site = tuple[int, int, str]
"""Column, row and name within the tile."""


@dataclass(frozen=True)
class Floor:
    """Where an ECP5 has its hard blocks: in rows, four of a kind in every group of nine columns."""

    groups: tuple[int, ...]
    """First column of each group."""
    multipliers: tuple[int, ...]
    """Rows of multipliers."""
    memories: tuple[int, ...]
    """Rows of block memories."""


def pin(netlist: dict[str, Any], top: str, floor: Floor) -> None:
    """Give hard blocks of module ``top`` in yosys' JSON their sites on ``floor``."""
    cells = netlist["modules"][top]["cells"]
    sites = plan({name: cell["type"] for name, cell in cells.items()}, floor)
    for name, site in sites.items():
        cells[name]["attributes"]["BEL"] = site


def plan(cells: Mapping[str, str], floor: Floor) -> dict[str, str]:
    """Site of hard blocks, by cell name; ``cells`` are types by name.

    The multipliers of the lanes stand in a line that runs along one row and comes back along the next, evenly spaced.
    The memories of their coefficients stand as near to them as there is room, the other memories evenly on the sites
    that are left.  Other multipliers are few, and the placer's, as are the memories of the front end.  Where there are
    more blocks than sites none gets one: it is the placer's to say what is missing.
    """
    line = _line(floor.groups, floor.multipliers, _MULTIPLIERS)
    free = _line(floor.groups, floor.memories, _MEMORIES)
    by_lane = sorted((lane, name) for name in cells if (lane := lane_of(name)) is not None)
    lanes = [name for _, name in by_lane if cells[name] == "MULT18X18D"]
    memories = [name for name, kind in cells.items() if kind in _MEMORY_CELLS]
    if len(lanes) > len(line) or len(memories) > len(free):
        return {}
    sites = dict(zip(lanes, _evenly(line, len(lanes)), strict=True))
    lane_sites = {lane_of(name): site for name, site in sites.items()}
    coefficients = [name for _, name in by_lane if cells[name] in _MEMORY_CELLS]
    for name in coefficients:
        near = lane_sites.get(lane_of(name), free[0])
        sites[name] = min(free, key=lambda site: abs(site[0] - near[0]) + abs(site[1] - near[1]))
        free.remove(sites[name])
    rank = {block: number for number, block in enumerate(_ORDER)}
    others = {name for name in memories if block_of(name) != _APART} - set(coefficients)
    in_order = sorted(others, key=lambda name: (rank.get(block_of(name), len(rank)), name))
    sites |= zip(in_order, _evenly(free, len(in_order)), strict=True)
    return {name: f"X{column}/Y{row}/{bel}" for name, (column, row, bel) in sites.items()}


def _line(groups: Sequence[int], rows: Sequence[int], sites: Mapping[int, str]) -> list[Site]:
    """All sites, along one row and back along the next."""
    line = []
    for number, row in enumerate(rows):
        along = [(group + column, row, name) for group in groups for column, name in sites.items()]
        line += along[:: -1 if number % 2 else 1]
    return line


def _evenly(line: Sequence[Site], count: int) -> list[Site]:
    return [line[(2 * place + 1) * len(line) // (2 * count)] for place in range(count)]
