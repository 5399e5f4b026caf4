"""A testbench in plain Verilog: a few frames, the expected words, stalls on both ports."""

from __future__ import annotations

from collections.abc import Iterable
from string import Template

import numpy as np

from tfra.codegen.sidecar import LOADED
from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.model.cover.scenes import contact_codes, directed_codes
from tfra.model.fixed.design import Design

CONTACTS = 4
"""Simulated contacts; every directed frame comes after them."""

SEED = 1

_TEMPLATE = Template("""\
// Self-checking testbench of $name: $frames frames, $words result words, all compared.
// iverilog -g2012 -o tb $name.v testbench/${name}_tb.v$cells && vvp tb     (in the directory of $name.v)
`timescale 1ns / 1ps
module ${name}_tb;
  reg clk = 0, rst = 1;
  reg signed [$taxel_top:0] taxels [0:$last_taxel];
  reg signed [$word_top:0] expected [0:$last_word];
$load_signals  reg [15:0] noise = 16'hace1;  // shift register: decides who stalls
  integer taxel = 0, word = 0, errors = 0, quiet = 0;
  wire taxel_ready, result_valid, result_last;
  wire signed [$word_top:0] result_data;
  reg taxel_valid = 0, result_ready = 0;
  wire signed [$taxel_top:0] taxel_data = taxels[taxel];

  $name dut (
    .clk(clk), .rst(rst),
$load_ports    .taxel_data(taxel_data), .taxel_valid(taxel_valid), .taxel_ready(taxel_ready),
    .result_data(result_data), .result_last(result_last), .result_valid(result_valid), .result_ready(result_ready)
  );

  always #5 clk = !clk;

  initial begin
    $$readmemh("testbench/taxels.hex", taxels);
    $$readmemh("testbench/results.hex", expected);
$load_file    repeat (4) @(negedge clk);
    rst = 0;
$load_transfers  end

  always @(negedge clk) if (!rst) begin  // inputs change between the rising edges
    noise = {noise[14:0], noise[15] ^ noise[13] ^ noise[12] ^ noise[10]};
    if (!taxel_valid) taxel_valid = taxel <= $last_taxel && noise[0];
    result_ready = noise[5] | noise[9];
  end

  always @(posedge clk) if (!rst) begin
    quiet = (result_valid && result_ready) === 1'b1 ? 0 : quiet + 1;  // an undefined one is none
    if (taxel_valid && taxel_ready) begin
      taxel <= #1 taxel + 1;
      taxel_valid <= #1 taxel < $last_taxel && noise[3];
    end
    if (result_valid && result_ready) begin
      if (result_data !== expected[word] || result_last !== (word % $frame == $frame - 1)) begin
        if (errors < 10)
          $$display("frame %0d, word %0d: %0d expected, %0d observed", word / $frame, word % $frame, expected[word],
                   result_data);
        errors = errors + 1;
      end
      word = word + 1;
      if (word == $words) begin
        $$display("%s: %0d words compared, %0d differ", errors ? "FAILED" : "PASSED", word, errors);
        $$finish;
      end
    end
    if (quiet > $patience) begin
      $$display("FAILED: no result for %0d cycles, %0d words compared", quiet, word);
      $$finish;
    end
  end
endmodule
""")

_LOAD = {
    "load_signals": """\
  reg signed [$load_top:0] coefficients [0:$last_load];
  integer load = 0;
  reg load_valid = 0;
  wire load_ready;
  wire signed [$load_top:0] load_data = coefficients[load];
""",
    "load_ports": """\
    .load_data(load_data), .load_valid(load_valid), .load_ready(load_ready),
""",
    "load_file": f"""\
    $$readmemh("{LOADED}", coefficients);
""",
    "load_transfers": """\
    load_valid = 1;
    while (load <= $last_load) begin
      @(posedge clk);
      if (load_ready) #1 load = load + 1;
    end
    load_valid = 0;
""",
}
"""The parts of a testbench for a core with a ``load`` port."""


def testbench(design: Design, interval: int) -> dict[str, str]:
    """Texts of the testbench's files by name; ``interval``: cycles from frame to frame without stalls."""
    core = microarchitecture(design)
    codes = np.concatenate([contact_codes(design, CONTACTS, SEED), directed_codes(design)])
    words = design.model(codes).words
    text = _TEMPLATE.substitute(
        name=design.name,
        cells="".join(f" {file.name}" for file in core.cell_models),
        frames=len(codes),
        words=words.size,
        frame=design.frame_words,
        taxel_top=design.adc.bits - 1,
        word_top=design.word_bits - 1,
        last_taxel=codes.size - 1,
        last_word=words.size - 1,
        patience=20 * interval + 1000,
        **_load(core),
    )
    return {
        f"{design.name}_tb.v": text,
        "taxels.hex": hex_words(codes.ravel(), design.adc.bits),
        "results.hex": hex_words(words.ravel(), design.word_bits),
    }


def _load(core: Microarchitecture) -> dict[str, str]:
    words = core.loaded
    if words is None:
        return dict.fromkeys(_LOAD, "")
    sizes = {"last_load": len(words) - 1, "load_top": core.design.coefficient_word - 1}
    return {name: Template(text).substitute(sizes) for name, text in _LOAD.items()}


def hex_words(words: Iterable[int], bits: int) -> str:
    """Text for ``$readmemh``: two's complement words of ``bits``, one a line."""
    digits, mask = -(-bits // 4), (1 << bits) - 1
    return "".join(f"{int(word) & mask:0{digits}x}\n" for word in words)
