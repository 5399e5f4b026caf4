"""Cologne Chip GateMate: yosys and nextpnr; multipliers are made of its logic, in rows of two bits a cell."""

from tfra.families.family import BlockMemory, Family, PlaceAndRoute, Target


def _product(a: int, b: int) -> float:
    """Half CPEs of a signed multiplier, within 2 % of what nextpnr's packer takes from 8 x 8 to 35 x 35 bits."""
    narrow, wide = sorted(bits + bits % 2 + 2 for bits in (a, b))
    return wide * (narrow / 2 + 1) + 4.6 * narrow


FAMILY = Family(
    name="gatemate",
    title="GateMate",
    lut="half CPE",
    # nextpnr has no cell for CC_MX8, and places trees of lookup tables.  Cells get the names of their wires.
    synthesis="synth_gatemate -luttree -nomx8 -top {top}; autoname",
    cells={
        "LUT": {"CC_L(UT[1-4]|2T4)|CC_MX2|CC_ADDF": 1, "CC_L2T5|CC_MX4": 2, "CC_MULT": 312},  # of 18 x 18 bits
        "FF": {"CC_DFF": 1},
        "BRAM": {"CC_BRAM_20K": 1, "CC_BRAM_40K": 2},
    },
    memory=BlockMemory(16384, (40, 20, 10, 5, 2, 1), parity=(4, 5), enable=1),
    distributed=False,
    more=0.42,  # a serial core of 2 x 2 taxels: docs/synth.md
    product_luts=_product,
    place_and_route=PlaceAndRoute(
        program="yowasp-nextpnr-himbaechel-gatemate",
        packer="yowasp-gmpack",
        bitstream=".bit",
        bels={
            "LUT": {"CPE_LT": 1, "CPE_ADDF": 1, "CPE_ADDF2": 2, "CPE_MX4": 2, "CPE_MULT": 2},
            "FF": {"CPE_FF": 1},
            "BRAM": {"RAM_HALF": 1},
        },
        layout=("--vopt", "out={file}"),
        # With passages through its logic, nextpnr 0.11.1 aborts after it has routed a core.
        routing=("--vopt", "allow-unconstrained", "--vopt", "no-bridges", "--vopt", "no-cpe-cp"),
        stages=False,  # read again, a placed netlist has lost the clocks of its memories
    ),
)

TARGETS = (
    Target(
        name="gatemate-a1",
        family=FAMILY,
        device=("--device", "CCGM1A1"),
        available={"LUT": 40960, "FF": 40960, "BRAM": 64},
        clock_mhz=25.0,
        price="10 to 30",
    ),
)
