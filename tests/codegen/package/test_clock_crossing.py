"""The FIFO between two clocks loses, doubles and swaps no word, and a core with a clock for its streams works."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.codegen.package.made import made
from tests.codegen.package.test_folder import CONTENTS
from tests.codegen.test_generate import run_testbench
from tests.marks import long
from tfra.codegen.package.folder import clock_crossing

BENCH = Path(__file__).with_name("async_bench.v")
UNSETTLED = re.compile(r"^    (head|tail)_meta <= \1_gray;", re.M)
"""Bits that changed less than 100 ps before they are sampled have either value."""


def played(folder: Path, stated: str, other: str, **parameters: int) -> str:
    """What the bench says of the FIFO with ``other`` text in place of what is ``stated``."""
    (text,) = clock_crossing(CONTENTS).values()
    assert text.count(stated) == 1
    before = "".join(f"  wire [LOG2_DEPTH:0] #100 {name}_before = {name}_gray;\n" for name in ("head", "tail"))
    text = text.replace(stated, other).replace("  assign s_ready", f"{before}  assign s_ready")
    text, count = UNSETTLED.subn(r"    \1_meta <= \1_gray ^ ((\1_gray ^ \1_before) & $random);", text)
    assert count == 2
    (folder / "async.v").write_text(f"`timescale 1ps / 1ps\n{text}")
    values = [f"-Pasync_bench.{name}={value}" for name, value in parameters.items()]
    command = ["iverilog", "-g2005", "-Wall", "-o", "tb", *values, "-s", "async_bench", str(BENCH), "async.v"]
    subprocess.run(command, cwd=folder, check=True)
    return subprocess.run(["vvp", "-n", "tb"], cwd=folder, capture_output=True, text=True, check=True).stdout


CLOCKS = [(s, m, depth) for depth, (s, m) in enumerate(((5000, 5000), (4999, 5000), (5000, 1901), (713, 33331)), 1)]


@pytest.mark.parametrize(("source", "sink", "depth"), [(5000, 3571, 2), *long(*CLOCKS)])
def test_every_word_comes_once_and_in_order(tmp_path: Path, source: int, sink: int, depth: int) -> None:
    assert "PASSED: 5000 words" in played(tmp_path, "3 <<", "3 <<", S_HALF=source, M_HALF=sink, LOG2_DEPTH=depth)


PLANTED = [("tail_next ^ (tail_next >> 1)", "tail_next"), ("3 <<", "2 <<"), ("!m_valid || m_ready", "1")]


@pytest.mark.parametrize(("stated", "other"), [("head_next ^ (head_next >> 1)", "head_next"), *long(*PLANTED)])
def test_what_is_planted_is_noticed(tmp_path: Path, stated: str, other: str) -> None:
    assert "FAILED" in played(tmp_path, stated, other)


@pytest.mark.long
def test_a_core_with_another_clock_for_its_streams(tmp_path: Path) -> None:
    """The testbench of the wrapper, whose streams then have a clock of 7.3 ns."""
    design, folder = made("parallel", tmp_path)
    bench = folder / "testbench" / f"{design.name}_axi_tb.v"
    text = bench.read_text().replace(f"  {design.name}_axi dut (", f"""\
  reg axis_clk = 0;
  always #3.65 axis_clk = !axis_clk;
  {design.name}_async dut (.axis_clk(axis_clk), .axis_resetn(aresetn),""")
    for edge in ("neg", "pos"):
        text = text.replace(f"always @({edge}edge aclk)", f"always @({edge}edge axis_clk)")
    bench.write_text(text.replace("_axi.v testbench", f"_axi.v {design.name}_async.v testbench"))
    assert "0 differ" in run_testbench(folder, f"{design.name}_axi")
