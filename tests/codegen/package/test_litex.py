"""A LiteX system on chip with the package's module: its CPU, SERV, sends a frame and reads the result, in Verilator."""

import runpy
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.codegen.package.test_folder import CONTENTS
from tfra.codegen.package.folder import litex
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.wrapper import ports_of, wrapper_verilog
from tfra.hdl.ip.framer import FORMAT, FORMAT_PLACE, HEADER_WORDS
from tfra.sim.tools import choose, environment

DESIGN, CORE, CSR, END = CONTENTS.design, 0x9000_0000, 0x8200_1000, 0x600D_C0DE
TAXEL, CAME, WORD, SEEN = 0, 4, 8, 12
CODES = [100, -200, 300, -400]
BENCH = """module bench;
  reg clk = 0, rst = 1;
  always #5 clk = !clk;
  initial begin #100 rst = 0; #10000000 $finish; end
  system dut (.clk(clk), .rst(rst));
endmodule
"""


def const(register: int, value: int) -> list[int]:
    """Instructions of RV32I: lui, addi."""
    high, low = (value + 0x800 >> 12) & 0xFFFFF, value & 0xFFF
    return [high << 12 | register << 7 | 0x37, low << 20 | register << 15 | register << 7 | 0x13]


def load(base: int, offset: int) -> int:
    return offset << 20 | base << 15 | 2 << 12 | 3 << 7 | 3


def store(base: int, offset: int) -> int:
    return (offset >> 5) << 25 | 3 << 20 | base << 15 | 2 << 12 | (offset & 31) << 7 | 0x23


def program() -> list[int]:
    """Show the core's ID, start it, send the taxels, show each word that comes; register 3 is that of all data."""
    again = 0xFE01_8EE3  # beq x3, x0, -4
    registers = CONTENTS.registers
    control = {field.name: field.mask for field in registers["CONTROL"].fields}
    words = [*const(1, CSR), *const(2, CORE), load(2, registers["ID"].address), store(1, SEEN)]
    words += [*const(3, control["run"] | control["taxel_forces"]), store(2, registers["CONTROL"].address)]
    for place, code in enumerate(CODES):
        words += [*const(3, code & 0xFFFF | (place == len(CODES) - 1) << 31), store(1, TAXEL)]
    words += [load(1, CAME), again, load(1, WORD), store(1, SEEN)] * (HEADER_WORDS + DESIGN.frame_words)
    return [*words, *const(3, END), store(1, SEEN), 0x6F]  # jal x0, 0


def system(folder: Path) -> tuple[Any, Any]:
    """The platform, and the system with registers that send taxels, read words and print what is written."""
    from litex.build.generic_platform import GenericPlatform, Pins
    from litex.gen import LiteXModule
    from litex.soc.integration.soc import SoCRegion
    from litex.soc.integration.soc_core import SoCCore
    from litex.soc.interconnect import stream
    from litex.soc.interconnect.csr import CSRStatus, CSRStorage
    from migen import ClockDomain, Display, Finish, If

    class Streams(LiteXModule):  # type: ignore[misc]  # LiteX has no types
        def __init__(self, core: Any) -> None:
            self.taxel = taxel = CSRStorage(32, name="taxel")
            self.came = came = CSRStatus(1, name="came")
            self.word = word = CSRStatus(32, name="word")
            self.seen = seen = CSRStorage(32, name="seen")
            self.fifo = fifo = stream.SyncFIFO([("data", 32), ("user", 1)], 64)
            self.comb += [core.sink.data.eq(taxel.storage), core.sink.last.eq(taxel.storage[31])]
            self.comb += [core.sink.valid.eq(taxel.re), core.source.connect(fifo.sink)]
            self.comb += [came.status.eq(fifo.source.valid), word.status.eq(fifo.source.data)]
            self.comb += fifo.source.ready.eq(word.we)
            self.sync += If(seen.re, Display("seen %d", seen.storage), If(seen.storage == END, Finish()))

    platform = GenericPlatform("none", [("clk", 0, Pins("X")), ("rst", 0, Pins("X"))])
    options = {"with_uart": False, "with_timer": False, "ident": "", "integrated_sram_size": 1024}
    rom = {"integrated_rom_size": 4096, "integrated_rom_init": program()}
    soc = SoCCore(platform, clk_freq=int(50e6), cpu_type="serv", **options, **rom)
    soc.cd_sys = ClockDomain()
    soc.comb += [soc.cd_sys.clk.eq(platform.request("clk")), soc.cd_sys.rst.eq(platform.request("rst"))]
    soc.submodules.lanes = core = runpy.run_path(str(folder / "litex" / "lanes.py"))["Tfra"](platform)
    soc.bus.add_slave("lanes", core.bus, SoCRegion(origin=CORE, size=256, cached=False))
    soc.submodules.streams = Streams(core)
    soc.finalize()
    return platform, soc


@pytest.mark.long
def test_its_cpu_reads_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    choose("verilator")
    monkeypatch.chdir(tmp_path)
    modules = {"lanes_axi.v": wrapper_verilog(DESIGN), "lanes.v": to_verilog(DESIGN), "bench.v": BENCH}
    (tmp_path / "litex").mkdir()
    for name, text in (litex(CONTENTS) | modules).items():
        (tmp_path / name).write_text(text)
    platform, soc = system(tmp_path)
    assert soc.csr.regions["streams"].origin == CSR
    output = platform.get_verilog(soc, name="system")
    output.write("system.v")
    for pin in ports_of(DESIGN):
        assert f".{pin.name}" in str(output), pin.name
    files = ["bench.v", "system.v", *(file for file, *_ in platform.sources)]
    command = ["verilator", "--binary", "--timing", "-Wno-fatal", "-Wno-lint", "--top-module", "bench", *files]
    subprocess.run(command, env=environment("verilator", tmp_path), check=True, capture_output=True)
    done = subprocess.run(["obj_dir/Vbench"], check=True, capture_output=True, text=True)
    seen = [int(line.split()[1]) for line in done.stdout.splitlines() if line.startswith("seen")]
    (words,) = DESIGN.model(np.array([CODES])).words
    head = [CONTENTS.registers["ID"].reset, 0, FORMAT << FORMAT_PLACE]
    assert seen == [*head, *(int(word) % (1 << 32) for word in words), END]
