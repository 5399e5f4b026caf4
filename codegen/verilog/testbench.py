"""A testbench in plain Verilog: a few frames, the expected words, stalls on both ports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from string import Template
from typing import Any

import numpy as np

from tfra.codegen.verilog.header import frame_lines
from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.model.arrays import Ints
from tfra.model.cover.scenes import contact_codes, directed_codes
from tfra.model.fixed.design import Design

CONTACTS = 4
"""Simulated contacts; every directed frame comes after them."""

SEED = 1

_LINE = 10
"""Words in a line of the file."""

_TEMPLATE = Template("""\
// Self-checking testbench of $name: $frames frames, $words result words, all compared.
// It needs no other file but the core, and runs in any directory:
// iverilog -g2012 -o tb $name.v ${name}_tb.v$cells && vvp tb
//
// Words are hexadecimal, two's complement where signed, the first of a line leftmost.
$formats
`timescale 1ns / 1ps
module ${name}_tb;
  reg clk = 0, rst = 1;
  reg signed [$taxel_top:0] taxels [0:$last_taxel];
  reg signed [$word_top:0] expected [0:$last_word];
$load_signals  reg [15:0] noise = 16'hace1;  // shift register: decides who stalls
  integer taxel = 0, word = 0, errors = 0, quiet = 0;
  integer code_count = 0, result_count = 0;
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
$load_words    give_frames;
    repeat (4) @(negedge clk);
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
        if (errors) $$fatal;  // ends the simulator with an error
        $$finish;
      end
    end
    if (quiet > $patience) begin
      $$display("FAILED: no result for %0d cycles, %0d words compared", quiet, word);
      $$fatal;
    end
  end

$tasks
  task give_frames;
    begin
$given    end
  endtask
${load_tasks}endmodule
""")

_LOAD = {
    "load_signals": """\
  reg signed [$load_top:0] coefficients [0:$last_load];
  integer load = 0, coefficient_count = 0;
  reg load_valid = 0;
  wire load_ready;
  wire signed [$load_top:0] load_data = coefficients[load];
""",
    "load_ports": """\
    .load_data(load_data), .load_valid(load_valid), .load_ready(load_ready),
""",
    "load_words": """\
    give_coefficients;
""",
    "load_transfers": """\
    load_valid = 1;
    while (load <= $last_load) begin
      @(posedge clk);
      if (load_ready) #1 load = load + 1;
    end
    load_valid = 0;
""",
    "load_tasks": """
$store
  task give_coefficients;
    begin
$coefficients    end
  endtask
""",
}
"""The parts of a testbench for a core with a ``load`` port."""

_STORE = Template("""\
  task $kind(input integer count, input [$top:0] words);
    integer place;
    for (place = count - 1; place >= 0; place = place - 1) begin
      $memory[${kind}_count] = words[$slot * place +: $bits];
      ${kind}_count = ${kind}_count + 1;
    end
  endtask
""")


def testbench(design: Design, facts: dict[str, Any]) -> str:
    """Text of the testbench ``NAME_tb``; ``facts`` are those of the sidecar."""
    core = microarchitecture(design)
    codes = np.concatenate([contact_codes(design, CONTACTS, SEED), directed_codes(design)])
    words = design.model(codes).words
    code_bits, word_bits = design.adc.bits, design.word_bits
    return _TEMPLATE.substitute(
        name=design.name,
        cells="".join(f" {file.name}" for file in core.cell_models),
        frames=len(codes),
        words=words.size,
        frame=design.frame_words,
        taxel_top=code_bits - 1,
        word_top=word_bits - 1,
        last_taxel=codes.size - 1,
        last_word=words.size - 1,
        patience=20 * facts["interval_cycles"] + 1000,
        formats="".join(f"// {line}\n" for line in frame_lines(facts)).rstrip(),
        tasks=_store("code", "taxels", code_bits) + "\n" + _store("result", "expected", word_bits),
        given="".join(_frames(codes.reshape(len(codes), -1), words, code_bits, word_bits)),
        **_load(core),
    )


def _load(core: Microarchitecture) -> dict[str, str]:
    words, bits = core.loaded, core.design.coefficient_word
    if words is None:
        return dict.fromkeys(_LOAD, "")
    parts = {
        "last_load": len(words) - 1,
        "load_top": bits - 1,
        "store": _store("coefficient", "coefficients", bits),
        "coefficients": "".join(_lines("coefficient", words, bits)),
    }
    return {name: Template(text).substitute(parts) for name, text in _LOAD.items()}


def _store(kind: str, memory: str, bits: int) -> str:
    """A task that stores a line of words."""
    slot = 4 * _digits(bits)
    return _STORE.substitute(kind=kind, memory=memory, bits=bits, slot=slot, top=slot * _LINE - 1)


def _frames(codes: Ints, words: Ints, code_bits: int, word_bits: int) -> Iterator[str]:
    for number, (given, expected) in enumerate(zip(codes, words, strict=True)):
        yield f"      // frame {number}, {'a contact' if number < CONTACTS else 'a corner case'}\n"
        yield from _lines("code", given, code_bits)
        yield from _lines("result", expected, word_bits)


def _lines(kind: str, words: Ints, bits: int) -> Iterator[str]:
    """Calls of the task ``kind`` with a line of ``words`` each."""
    digits, size = hex_words(words, bits).split(), 4 * _digits(bits) * _LINE
    for start in range(0, len(digits), _LINE):
        line = digits[start : start + _LINE]
        yield f"      {kind}({len(line)}, {size}'h{'_'.join(line)});\n"


def _digits(bits: int) -> int:
    return -(-bits // 4)


def hex_words(words: Iterable[int], bits: int) -> str:
    """Text for ``$readmemh``: two's complement words of ``bits``, one a line."""
    digits, mask = _digits(bits), (1 << bits) - 1
    return "".join(f"{int(word) & mask:0{digits}x}\n" for word in words)
