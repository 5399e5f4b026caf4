"""A design's operators, registers and memories, counted in its gateware before any synthesis.

The core is elaborated, but no netlist is made: that would take ten times as long and find the same.  There is one
:class:`CellCount` for each block of ``hdl/parallel/tfra/core.py``.
"""

from collections import Counter
from dataclasses import dataclass, field

from amaranth import Shape
from amaranth.hdl import Fragment, Instance, MemoryInstance

from tfra.codegen.verilog.emit import Top
from tfra.codegen.verilog.wrapper import wrapper
from tfra.families.hierarchy import block_of
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin
from tfra.synth.operators import OperatorCount


@dataclass(frozen=True, slots=True)
class Memory:
    """One memory: words, bits of each, read ports; ``rom`` if nothing writes it."""

    depth: int
    bits: int
    reads: int
    rom: bool


@dataclass
class CellCount:
    """Counts of one block.  ``operators`` are bits by kind: add, shift (bits times levels), logic, reduce, mux."""

    registers: int = 0
    """Flip-flops, in bits."""
    operators: Counter[str] = field(default_factory=Counter)
    multipliers: list[tuple[int, int]] = field(default_factory=list)
    """Widths of the operands of every multiplication with two variable operands."""
    memories: list[Memory] = field(default_factory=list)
    instances: Counter[str] = field(default_factory=Counter)
    """Cells of the target that the design instantiates, by type."""

    def __iadd__(self, other: "CellCount") -> "CellCount":
        self.registers += other.registers
        self.operators += other.operators
        self.multipliers += other.multipliers
        self.memories += other.memories
        self.instances += other.instances
        return self


def cell_counts(array: Design | Skin, *, package: bool = False) -> dict[str, CellCount]:
    """Counts by block of ``hdl/parallel/tfra/core.py``; ``"top"`` is everything outside of blocks.

    A skin's blocks are those of ``hdl/skin/``, too.  With ``package``, also of the ``"wrapper"`` around the core.
    """
    blocks = count(Fragment.get(Top(array), None))
    if package:
        blocks["wrapper"] = CellCount()
        for part in count(Fragment.get(wrapper(array), None)).values():
            blocks["wrapper"] += part
    return blocks


def count(top: Fragment) -> dict[str, CellCount]:
    """Counts by block in an elaborated top module; see :func:`block_of` for the names."""
    blocks: dict[str, CellCount] = {}
    _count_below(top, "", blocks)
    return blocks


def _count_below(fragment: Fragment, path: str, blocks: dict[str, CellCount]) -> None:
    """Add the module ``path`` and all modules in it to their blocks."""
    module, total = OperatorCount(), blocks.setdefault(block_of(path), CellCount())
    module.module(fragment)
    for part, name, _ in fragment.subfragments:
        if isinstance(part, MemoryInstance):
            total.memories.append(_count_memory(part, module))
        elif isinstance(part, Instance):
            total.instances[part.type] += 1
            for value, direction in part.ports.values():
                if direction == "i":
                    module.value(value)
        else:
            _count_below(part, f"{path}.{name}", blocks)
    total.registers += module.registers
    total.operators += module.operators
    total.multipliers += module.multipliers


def _count_memory(memory: MemoryInstance, operators: OperatorCount) -> Memory:
    """The memory; the operators of its ports' addresses, enables and data go to ``operators``."""
    reads, writes = memory._read_ports, memory._write_ports
    for port in (*reads, *writes):
        operators.value(port._addr)
        operators.value(port._en)
    for port in writes:
        operators.value(port._data)
    return Memory(memory._data.depth, Shape.cast(memory._data.shape).width, len(reads), not writes)
