"""Run a component of plain ports: in Amaranth's simulator, or its Verilog with the models of cells in Icarus."""

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from amaranth.back import rtlil
from amaranth.sim import Simulator

from tfra.codegen.verilog.emit import plain_verilog
from tfra.hdl.primitives import cell_models

Inputs = Mapping[str, Sequence[int]]
"""By port, its value in every cycle."""

TESTBENCH = """\
module tb;
  reg clk = 0, rst = 0;
  reg [{top}:0] words [0:{last}];
  integer cycle;
  {declarations}
  dut dut (.clk(clk), .rst(rst), {connections});
  initial begin
    $readmemh("inputs.hex", words);
    for (cycle = 0; cycle <= {last}; cycle = cycle + 1) begin
      {{{inputs}}} = words[cycle];
      #1 $display("{formats}", {outputs});
      clk = 1;
      #1 clk = 0;
    end
  end
endmodule
"""


def in_amaranth(dut: Any, inputs: Inputs, outputs: Mapping[str, int]) -> list[list[str]]:
    """Values of ``outputs`` (by port, their bits) before each clock edge, in hexadecimal."""
    seen = []

    async def process(ctx: Any) -> None:
        for cycle in range(_cycles(inputs)):
            for name, values in inputs.items():
                ctx.set(_port(dut, name), values[cycle])
            seen.append([_hex(ctx.get(_port(dut, name)), bits) for name, bits in outputs.items()])
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(process)
    simulator.run()
    return seen


def in_icarus(dut: Any, inputs: Inputs, outputs: Mapping[str, int], target: str, place: Path) -> list[list[str]]:
    """The same from the Verilog of ``dut`` with the models of the target's cells; ``x`` where a bit is unknown."""
    models = [file.read_text() for file in cell_models(target, "multiplier", "rom")]
    (place / "dut.v").write_text(plain_verilog(str(rtlil.convert(dut, name="dut", emit_src=False)), "dut", (), models))
    bits = {name: len(_port(dut, name)) for name in inputs}
    declared = [*(("reg", name, bits[name]) for name in inputs), *(("wire", name, n) for name, n in outputs.items())]
    (place / "tb.v").write_text(
        TESTBENCH.format(
            top=sum(bits.values()) - 1,
            last=_cycles(inputs) - 1,
            declarations=" ".join(f"{kind} [{n - 1}:0] {name};" for kind, name, n in declared),
            connections=", ".join(f".{name}({name})" for _, name, _ in declared),
            inputs=", ".join(inputs),
            formats=" ".join("%h" for _ in outputs),
            outputs=", ".join(outputs),
        )
    )
    lines = []
    for cycle in range(_cycles(inputs)):
        word = 0
        for name, values in inputs.items():
            word = word << bits[name] | values[cycle] & ((1 << bits[name]) - 1)
        lines.append(f"{word:x}\n")
    (place / "inputs.hex").write_text("".join(lines))
    return icarus("tb.v", "dut.v", *map(str, cell_models(target, "multiplier", "rom")), place=place)


def icarus(*files: str, place: Path) -> list[list[str]]:
    """Compile and run Verilog ``files``; the words of every line that it prints."""
    subprocess.run(["iverilog", "-g2012", "-o", "tb.vvp", *files], cwd=place, check=True)
    done = subprocess.run(["vvp", "-n", "tb.vvp"], cwd=place, capture_output=True, text=True, check=True)
    return [line.split() for line in done.stdout.splitlines()]


def _cycles(inputs: Inputs) -> int:
    return len(next(iter(inputs.values())))


def _port(dut: Any, name: str) -> Any:
    """``NAME``, or ``NAME__3`` for a place of an array, as Verilog has it."""
    name, _, place = name.partition("__")
    return getattr(dut, name)[int(place)] if place else getattr(dut, name)


def _hex(value: int, bits: int) -> str:
    return f"{value & ((1 << bits) - 1):0{-(-bits // 4)}x}"
