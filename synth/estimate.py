"""Resources of a design before synthesis.

Multipliers and memories follow yosys' mapping rules; lookup tables and flip-flops are sums of the
operators that :mod:`tfra.synth.cell_count` finds in the design, each kind at the price fitted to syntheses: of parallel
cores for ECP5, of serial cores for iCE40 and for ECP5 (``python -m bench.parts.estimates``).
Other families have other rules for memories and carry chains: for them the estimate is a guide, not a proof.
"""

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import product
from typing import Any

from tfra.codegen.package.contents import Part
from tfra.families import DEFAULT, FAMILIES, Family, Target, parts
from tfra.families.family import BlockMemory, HardMultiplier
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin, core_of
from tfra.synth.cell_count import CellCount, Memory, cell_counts

Counts = Callable[..., Mapping[str, CellCount]]
""":func:`cell_counts`, or the same with a memory."""

KINDS = ("add", "shift", "logic", "reduce", "mux")
"""Operators with a price in lookup tables per bit."""

_TABLE_COST = 4
"""yosys' cost of a small memory in lookup tables (``share/lattice/lutrams_trellis.txt``)."""

_SELECT_COST = 0.5
"""Cost of each multiplexer bit between small memories; syntheses showed 0.2 to 0.8."""

_WORDS, _BITS, _TABLES = 16, 4, 6
"""The small memory: words, their bits, and the lookup tables it takes, two of them for writing."""


@dataclass(frozen=True)
class Prices:
    """Lookup tables per bit of each kind, flip-flops per register bit, and the largest relative errors measured.

    ``family`` is that which they were fitted to.  ``error`` has either sign, ``short`` is the share that a core takes
    more than estimated: an estimate that is never short has 0.
    """

    family: str
    lut: Mapping[str, float]
    ff: float
    error: Mapping[str, float]
    short: Mapping[str, float]


@cache
def prices(kind: str = "parallel", family: str = "") -> Prices:
    """The prices of cores of ``kind`` that were fitted for ``family``, else those for the first family of all."""
    own, first = (files("tfra.synth").joinpath(f"estimate_{name}.json") for name in (f"{kind}_{family}", kind))
    data: dict[str, Any] = json.loads((own if own.is_file() else first).read_text())
    return Prices(data["family"], data["lut"], data["ff"], data["error"], data["short"])


@dataclass(frozen=True, slots=True)
class Placed:
    """Mapping of a memory: ``blocks`` block memories, or ``tables`` lookup tables followed by ``registers``."""

    blocks: int
    tables: int
    registers: int
    levels: int
    """Bits of multiplexers between the tables."""


def place(memory: Memory, family: Family) -> Placed:
    """The cheaper mapping of ``memory`` by yosys' costs; constants may become logic."""
    cell = family.memory
    ways = [_in_blocks(memory, cell, width) for width in (cell.widths[1:] if _shared(memory) else cell.widths)]
    costs = [cell.cost * way.blocks + _SELECT_COST * way.levels for way in ways]
    block = ways[costs.index(min(costs))]
    rows = -(-memory.depth // _WORDS)
    if not memory.rom and not family.distributed:
        return block
    small = -(-memory.bits // _BITS) * rows * memory.reads
    levels = memory.bits * (rows - 1) * memory.reads
    cost, tables = _TABLE_COST * small + _SELECT_COST * levels, _TABLES * small
    if memory.rom:
        levels = 0
        cost = tables = -(-memory.depth * memory.bits // _WORDS) * memory.reads
    if cost >= min(costs):
        return block
    return Placed(0, tables, memory.bits * memory.reads, levels)


def _shared(memory: Memory) -> bool:
    """Whether two ports share the constants, at half the width; other memories have a copy for each reader."""
    return memory.rom and memory.reads == 2


def _in_blocks(memory: Memory, block: BlockMemory, width: int) -> Placed:
    """Block memories whose words have ``width`` bits, in which rows of a deep memory lie side by side.

    A row is as many words as the block has; multiplexers choose among rows.  Where words are written, each takes whole
    units of the block's write enables.
    """
    rows, copies = -(-memory.depth // block.depth(width)), 1 if _shared(memory) else memory.reads
    unit = 1 if memory.rom else min(block.enable, width)
    bits = -(-memory.bits // unit) * unit
    return Placed(copies * -(-rows * bits // width), 0, 0, memory.bits * (rows - 1) * memory.reads)


def multipliers(widths: tuple[int, int], cell: HardMultiplier | None) -> int:
    """How many multipliers ``cell`` one signed product takes, as in yosys' ``mul2dsp.v``.

    Longer operands are split; short products become lookup tables, and all do where there is no such cell.
    """
    if cell is None:
        return 0
    factor, together = cell.shortest
    wide, narrow = sorted(widths, reverse=True)
    most_wide, most_narrow = sorted(cell.widths, reverse=True)
    pairs = product(_parts(wide, most_wide, cell.sign_bits), _parts(narrow, most_narrow, cell.sign_bits))
    return sum(min(pair) >= factor and sum(pair) >= together for pair in pairs)


def _parts(bits: int, most: int, sign_bits: int) -> list[int]:
    """Bits of an operand's parts for cells of ``most`` bits; only the highest has a sign."""
    low = most - sign_bits
    cut = 0 if bits <= most else -(-(bits - most) // low)
    return [low] * cut + [bits - low * cut]


def features(counts: CellCount, family: Family, kind: str = "parallel") -> dict[str, float]:
    """Features that prices multiply: bits by kind, lookup tables of memories ``table``, register bits ``ff``.

    ``DSP``, ``BRAM`` and ``SPRAM`` are counts.  Where registers move into multipliers and memories, each takes one
    word: a product, unless it is split, or the widest word of a memory.  A serial core has no such registers.
    """
    cell, luts = family.multiplier, family.product_luts
    placed = [place(memory, family) for memory in counts.memories]
    products, blocks = [multipliers(w, cell) for w in counts.multipliers], sum(p.blocks for p in placed)
    inside = 0
    if family.registers and kind == "parallel":
        inside = (sum(cell.widths) if cell else 0) * products.count(1) + family.memory.widths[0] * blocks
    operators = {kind: float(counts.operators[kind]) for kind in KINDS}
    operators["mux"] += sum(p.levels for p in placed)
    instances = tally(counts.instances, family)
    return {
        **operators,
        "table": sum(p.tables for p in placed) + sum(luts(*w) if luts else 0.0 for w in counts.multipliers),
        "ff": float(counts.registers + sum(p.registers for p in placed) - inside),
        "DSP": sum(products) + instances.get("DSP", 0.0),
        "BRAM": blocks + instances.get("BRAM", 0.0),
        "SPRAM": instances.get("SPRAM", 0.0),
    }


def tally(cells: Mapping[str, int], family: Family) -> dict[str, float]:
    """Resources of ``cells``, by type, as ``family.cells`` weighs them."""
    return {
        resource: sum(
            weight * number
            for pattern, weight in patterns.items()
            for cell, number in cells.items()
            if re.fullmatch(pattern, cell)
        )
        for resource, patterns in family.cells.items()
    }


def price(found: Mapping[str, float], rates: Prices) -> dict[str, float]:
    """Resources from :func:`features`."""
    lut = found["table"] + sum(rates.lut[kind] * found[kind] for kind in KINDS)
    return {"LUT": lut, "FF": rates.ff * found["ff"], **{name: found[name] for name in ("DSP", "BRAM", "SPRAM")}}


@dataclass(frozen=True)
class Estimate:
    """Resources of a core by block of ``hdl/parallel/tfra/core.py`` and name, those that its family has."""

    blocks: Mapping[str, Mapping[str, float]]
    constants: int
    """Lookup tables that hold the lanes' coefficients; only these may decrease with more lanes."""

    @property
    def total(self) -> dict[str, int]:
        """Resources of the core."""
        rows = list(self.blocks.values())
        return {name: round(sum(row[name] for row in rows)) for name in rows[0]}

    @property
    def least(self) -> dict[str, int]:
        """A lower bound on the resources of cores with more lanes, of which only the lanes' memories may be smaller."""
        total = self.total
        memories = round(self.blocks.get("matvec", {}).get("BRAM", 0))
        return {**total, "LUT": total["LUT"] - self.constants, "BRAM": total["BRAM"] - memories}


def estimate(array: Design | Skin, family: Family, *, package: bool = False, counts: Counts = cell_counts) -> Estimate:
    """Resources of a design or a skin on ``family``, with ``package`` behind its buses.

    Elaborates the core, which takes half a second, unless ``counts`` remembers it.
    """
    kind, blocks, counted = core_of(array).architecture.kind, {}, counts(array, package=package)
    around = {"wrapper"}
    if isinstance(array, Skin) and kind != "parallel":
        around = counted.keys() - counts(array.window, package=False).keys()
    for name, count in counted.items():
        like = "parallel" if name in around else kind  # what is around a core is no program
        priced = price(features(count, family, like), prices(like, family.name))
        blocks[name] = {resource: priced[resource] for resource in family.cells}
    lanes = counted.get("matvec", CellCount())
    return Estimate(blocks, sum(place(memory, family).tables for memory in lanes.memories if memory.rom))


def basis(kind: str, family: Family) -> str:
    """The unit of a LUT in estimates of ``kind`` cores on ``family``, and the estimates' errors."""
    rates = prices(kind, family.name)
    fitted = FAMILIES[rates.family]
    unit = f"a LUT is a {fitted.lut} of {fitted.title}"
    if fitted is family:
        off = ", ".join(f"{100 * error:.1f} % ({name})" for name, error in rates.error.items())
        return f"{unit}; fitted to syntheses of {kind} cores for {family.title}, off by up to {off}"
    seen = f": a core took {family.more:.0%} more" if family.more else ""
    guide = f"{family.title} has {family.lut}s, so this is only a guide{seen}"
    return f"{unit}, the family of the fitted {kind} cores; {guide}"


def at_most(total: Mapping[str, float], family: Family, kind: str) -> dict[str, int]:
    """What a core of ``kind`` may take if its estimate is as short as the shortest of all, of uncertain resources."""
    short = {**prices(kind, family.name).short}
    if family.more:
        short["LUT"] = family.more
    return {name: math.ceil(total[name] * (1 + more)) for name, more in short.items() if name in total}


def misfits(total: Mapping[str, float], target: Target, kind: str = "parallel", *, doubtful: bool = False) -> list[str]:
    """The resources that ``target`` lacks for a core of ``kind``: name, need, and what the part has.

    A resource may exceed the part by the fit's largest error; if ``doubtful``, those that only may fit are told, too.
    """
    error, most, found = prices(kind, target.family.name).error, at_most(total, target.family, kind), []
    for name, have in target.available.items():
        need = total[name]
        if need > have * (1 + error.get(name, 0.0)) or (doubtful and most.get(name, need) > have):
            about = f"about {need:,}" if need > have else f"about {need:,}, at most {most[name]:,},"
            found.append(f"{name}: {about} are needed, {target.name} has {have:,}")
    return found


def part_of(array: Design | Skin) -> Part:
    """The smallest part of its family that a package fits, core and wrapper, and what these take of it, estimated.

    ``DEFAULT``'s for designs of no family; always of the slowest grade; a package that fits none gets the largest.
    """
    design = core_of(array)
    family, kind = FAMILIES.get(design.target, DEFAULT), design.architecture.kind
    total = estimate(array, family, package=True).total
    slowest = [target for target in parts() if target.family is family]
    target = next((one for one in slowest if not misfits(total, one, kind)), slowest[-1])
    resources = {name: (total[name], have) for name, have in target.available.items()}
    return Part(target, resources, basis(kind, target.family))
