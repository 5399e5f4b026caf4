"""Run a component of plain ports: in Amaranth's simulator, or its Verilog with the models of cells in Icarus."""

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from amaranth.back import rtlil

from tfra.codegen.verilog.emit import plain_verilog
from tfra.hdl.primitives import cell_models
from tfra.sim.harness import play, port

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
    cycles = [dict(zip(inputs, values, strict=True)) for values in zip(*inputs.values(), strict=True)]
    record = play(dut, cycles, [_path(name) for name in outputs])
    masks = [(1 << bits) - 1 for bits in outputs.values()]
    return [[f"{value & mask:x}" for value, mask in zip(row.values(), masks, strict=True)] for row in record]


def in_icarus(dut: Any, inputs: Inputs, outputs: Mapping[str, int], target: str, place: Path) -> list[list[str]]:
    """The same from the Verilog of ``dut`` with the models of the target's cells; ``x`` where a bit is unknown."""
    models = [file.read_text() for file in cell_models(target, "multiplier", "rom")]
    (place / "dut.v").write_text(plain_verilog(str(rtlil.convert(dut, name="dut", emit_src=False)), "dut", (), models))
    bits = {name: len(port(dut, _path(name))) for name in inputs}
    declared = [*(("reg", name, bits[name]) for name in inputs), *(("wire", name, n) for name, n in outputs.items())]
    (place / "tb.v").write_text(
        TESTBENCH.format(
            top=sum(bits.values()) - 1,
            last=len(next(iter(inputs.values()))) - 1,
            declarations=" ".join(f"{kind} [{n - 1}:0] {name};" for kind, name, n in declared),
            connections=", ".join(f".{name}({name})" for _, name, _ in declared),
            inputs=", ".join(inputs),
            formats=" ".join("%h" for _ in outputs),
            outputs=", ".join(outputs),
        )
    )
    lines = []
    for values in zip(*inputs.values(), strict=True):
        word = 0
        for value, size in zip(values, bits.values(), strict=True):
            word = word << size | value & ((1 << size) - 1)
        lines.append(f"{word:x}\n")
    (place / "inputs.hex").write_text("".join(lines))
    return icarus("tb.v", "dut.v", *map(str, cell_models(target, "multiplier", "rom")), place=place)


def icarus(*files: str, place: Path) -> list[list[str]]:
    """Compile and run Verilog ``files``; the words of every line that it prints."""
    subprocess.run(["iverilog", "-g2012", "-o", "tb.vvp", *files], cwd=place, check=True)
    done = subprocess.run(["vvp", "-n", "tb.vvp"], cwd=place, capture_output=True, text=True, check=True)
    return [line.split() for line in done.stdout.splitlines()]


def _path(name: str) -> str:
    """The attribute of a port; a place of an array is ``NAME__3`` in Verilog."""
    return name.replace("__", ".")
