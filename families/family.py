"""What is known of a device family: its cells, the tools that make a core of them, its parts and its board."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

Netlist = dict[str, Any]
"""yosys' JSON."""


@dataclass(frozen=True)
class HardMultiplier:
    """A multiplier cell, signed, as yosys' ``mul2dsp.v`` maps products to it."""

    widths: tuple[int, int]
    shortest: tuple[int, int]
    """Bits of a factor, and of both together, below which yosys multiplies by lookup tables."""
    sign_bits: int = 0
    """Bits that the lower parts of a split operand leave unused: one if cells have no unsigned operands."""


@dataclass(frozen=True)
class BlockMemory:
    """One block memory."""

    bits: int
    """Without parity."""
    widths: tuple[int, ...]
    """Widths of its words, the widest first; two-port memories can't use the first."""
    parity: tuple[int, int] = (8, 9)
    """Bits of the unit that has a parity bit, without and with it; parity bits are used by words of whole units."""
    enable: int = 9
    """Bits that one write enable holds for; written words take whole units of it."""
    cost: int = 128
    """yosys' cost, which it compares with that of lookup tables."""

    def depth(self, width: int) -> int:
        """Words of ``width`` bits."""
        data, unit = self.parity
        return (self.bits if width % unit else self.bits // data * unit) // width


@dataclass(frozen=True)
class PlaceAndRoute:
    """nextpnr for a family, and the program that makes a bitstream of its layout; ``{file}`` in options is a file."""

    program: str
    packer: str
    bitstream: str
    """Suffix of the bitstream's file."""
    bels: Mapping[str, Mapping[str, int]]
    """Resources of nextpnr's bels, and the number of the resource that each is."""
    layout: tuple[str, ...]
    """Options that write the layout to ``{file}``."""
    routing: tuple[str, ...] = ()
    """Options of placer and router."""
    free: tuple[str, ...] = ()
    """Options of a second placer, which chooses the sites of hard blocks, too; the two take turns, and it begins."""
    threaded: tuple[str, ...] = ()
    """Extra options of programs with threads; PyPI's, in WebAssembly, lacks them.  The first shows which it is."""
    constraints: str = ""
    """The clock's pin: one that the placer chooses may have no route to the clock network."""
    constrained: tuple[str, ...] = ()
    """Options that read the constraints from ``{file}``."""
    stages: bool = True
    """Can a placed netlist be written and routed in another run?"""


@dataclass(frozen=True)
class Gates:
    """How a core's gates are simulated: yosys' commands, and what its models of the cells need."""

    synthesis: str
    """``{top}`` is the top module."""
    macros: tuple[str, ...] = ()
    unreadable: tuple[str, ...] = ()
    """Models that Icarus 11 can't read, of cells that only nextpnr makes."""


@dataclass(frozen=True)
class Board:
    """A board with a serial line: its clock, and whether its button and its lamps are on when their pins are low."""

    name: str
    clock_hz: int
    inverted: bool
    files: tuple[str, ...]
    """Constraints, and a script that makes a bitstream: templates of the package."""


@dataclass(frozen=True)
class Family:
    """One device family: what is the same for all of its parts."""

    name: str
    """In CONFIG's ``[target]``; yosys' models of the cells are in a folder of this name."""
    title: str
    """The name in messages."""
    lut: str
    """The name of a lookup table."""
    synthesis: str
    """yosys' commands; ``{top}`` is the top module."""
    cells: Mapping[str, Mapping[str, float]]
    """Resources of yosys' cells: a pattern of the whole cell type, and the number of the resource it takes."""
    memory: BlockMemory
    distributed: bool
    """Can lookup tables be a memory of 16 words?"""
    multiplier: HardMultiplier | None = None
    """None where multipliers are made of lookup tables."""
    product_luts: Callable[[int, int], float] | None = field(default=None, repr=False)
    """The lookup tables of such a multiplier, from the widths of its factors."""
    fallback: str = ""
    """yosys' commands if ABC9 aborts, with the older ABC instead."""
    prepare: Callable[[Netlist, str, Any], Counter[str]] | None = field(default=None, repr=False)
    """Changes a top module of yosys' netlist as vendors' tools do, hard blocks at a target's ``floor`` if it has one;
    returns how many cells of each type were added."""
    rules: tuple[str, ...] = ()
    """Modules that ``prepare`` is made of, which need Python alone, in the order of their imports."""
    registers: bool = False
    """Does ``prepare`` move registers into block memories and multipliers?"""
    place_and_route: PlaceAndRoute | None = None
    """None where only yosys runs."""
    more: float = 0.0
    """Share of lookup tables that a measured core took beyond its estimate, by the prices of another family."""
    timing: str = ""
    """Why no clock frequency is reported; empty if one is."""
    gateware: Mapping[str, str] = field(default_factory=dict)
    """The primitives of the gateware (``hdl/primitives``) that are instances of the family's cells, and those cells.
    With any, CONFIG's ``[target]`` can name the family."""
    gates: Gates | None = None
    """None where the gates of a core can't be simulated."""
    board: Board | None = None
    project: tuple[str, Mapping[str, Any]] = ("", {})
    """FuseSoC's flow for the family, and its options but for the part's."""


PRICED = "a rough class: single pieces of the slowest grade at distributors, 2025"
"""What a part's price is: one of "under 10", "10 to 30", "30 to 100", "over 100"; ask before you buy."""


@dataclass(frozen=True)
class Target:
    """One part at one speed grade."""

    name: str
    family: Family
    device: tuple[str, ...]
    """nextpnr's options for the part and its package."""
    available: Mapping[str, int]
    """Resources of the part; empty if it stands for a whole family."""
    clock_mhz: float
    """Default aim of place and route."""
    grade: str = ""
    """Speed grade: the end of the name, and ..."""
    speed: tuple[str, ...] = ()
    """... nextpnr's options for it."""
    floor: Any = None
    """Sites of the hard blocks, unless the placer chooses them."""
    price: str = ""
    """Class of the price of a piece in EUR, as :data:`PRICED`; empty if it stands for a whole family."""

    @property
    def part(self) -> str:
        """The name without the grade."""
        return self.name.removesuffix(f"-{self.grade}")

    @property
    def resources(self) -> tuple[str, ...]:
        """Names of the resources, in the order of the report."""
        return tuple(self.family.cells)
