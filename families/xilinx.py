"""Xilinx 7 series: yosys alone."""

from tfra.families.family import BlockMemory, Family, HardMultiplier, Target

FAMILY = Family(
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
    memory=BlockMemory(32768, (72, 36, 18, 9, 4, 2, 1)),
    distributed=True,
    multiplier=HardMultiplier((25, 18), shortest=(2, 9), sign_bits=1),
    timing="only yosys runs for this family: cells are counted, not placed",
    project=("vivado", {"part": "xc7a35tcsg324-1"}),
)

TARGETS = (Target("xc7", FAMILY, (), {}, 100.0),)
