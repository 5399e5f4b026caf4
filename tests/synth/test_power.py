"""The power of a core: published figures, and registers' toggles."""

import json
from pathlib import Path

import pytest

from bench.parts.toggles import count
from tfra.families import find, parts
from tfra.synth.power import TOGGLES, power

RESULTS = Path(__file__).parents[2] / "bench" / "results" / "toggles.json"
VERILOG = r"""
module top(clk, q);
  top__inner inner (
  always @(posedge clk)
    q <= d;
module top__inner(clk, q);
  always @(posedge clk)
    \q.x  <= d;
  assign d = q;
"""
WAVES = """
$scope module top $end
 $var wire 1 ! clk $end
 $var wire 4 # q [3:0] $end
 $scope module inner $end
  $var wire 4 $ q.x [3:0] $end
  $var wire 4 % d [3:0] $end
 $upscope $end
$upscope $end
#0
0!
bxxxx #
b0000 $
#1
1!
b1111 #
b0101 $
b1111 %
#2
b1110 #
""".strip().splitlines()


def test_toggles_of_registers_alone() -> None:
    """Neither the clock nor wires count, nor a register's first value."""
    assert count(iter(WAVES), VERILOG, "top") == (8, 3)


def test_toggles_are_those_of_the_campaign() -> None:
    rows = json.loads(RESULTS.read_text())["rows"]
    for kind, mean in TOGGLES.items():
        rates = [row["rate"] for row in rows if row["kind"] == kind]
        assert mean == pytest.approx(sum(rates) / len(rates), abs=5e-4)


def test_power() -> None:
    """By hand, from the sources that the module names."""
    used = {"LUT": 1, "FF": 10_000}
    large = power(used, "parallel", 100.0, find("ecp5-85"))
    assert large
    assert large.rest_mw == pytest.approx(233.2)
    assert large.registers_mw == pytest.approx(TOGGLES["parallel"] * 10_000 * 25.1e-3)  # 25.1 uW at 100 MHz
    small = power({**used, "FF": 0}, "serial", 12.0, find("ice40up5k"))
    assert small
    assert (small.rest_mw, small.registers_mw) == pytest.approx((0.09, 0.5279 * 1.219))
    assert str(small) == "0.734 mW or more: 0.09 at rest, 0.644 registers and clock"
    known = {target.part for target in parts() if power(used, "serial", 10.0, target)}
    assert known == {"ecp5-25", "ecp5-85", "ice40up5k"}
