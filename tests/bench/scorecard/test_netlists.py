"""The proof of line 2: a small core's gates are proven, and one changed gate is not."""

from pathlib import Path
from typing import Any

import pytest

from bench.scorecard.aig import FALSE, TRUE, Graph
from bench.scorecard.netlists.points import Points, Side
from bench.scorecard.netlists.proof import Verdict, snapshots, verdict

VERILOG = """
module small(input clk, input rst, input [3:0] a, output reg [5:0] total, output [3:0] word);
  reg [3:0] memory [15:0];
  reg [3:0] place = 3;
  assign word = memory[place];
  always @(posedge clk) begin
    memory[place] <= a;
    place <= place + 1;
    total <= rst ? 0 : total + a * 5 - place;
  end
endmodule
"""

PRODUCTS = """
module products(input clk, input signed [15:0] a, b, input signed [29:0] c, input [10:0] place,
                output signed [31:0] short, output signed [45:0] long, output reg [7:0] word);
  reg signed [31:0] held = 0;
  reg [7:0] memory [0:1535];
  integer n;
  initial for (n = 0; n < 1536; n = n + 1) memory[n] = 37 * n * n;
  assign short = held;
  assign long = b * c;
  always @(posedge clk) begin
    held <= a * b;
    word <= memory[place];
  end
endmodule
"""
"""A product with its register, one of several multipliers and the adders in them, a memory of three blocks."""


def test_graph() -> None:
    graph = Graph()
    a, b = graph.input(), graph.input()
    assert graph.both(a, a ^ 1) == FALSE
    assert graph.both(a, TRUE) == a
    assert graph.both(a, b) == graph.both(b, a)
    assert graph.differ(a, b) == graph.differ(b ^ 1, a ^ 1)


@pytest.mark.parametrize("swapped", [False, True])
def test_sweeping_proves_what_is_false(swapped: bool, tmp_path: Path) -> None:
    graph = Graph()
    a, b, c = graph.input(), graph.input(), graph.input()
    left = graph.both(a, graph.both(b, c))
    right = graph.both(graph.both(a, b), c ^ swapped)
    assert graph.false([graph.differ(left, right), FALSE], tmp_path) == [not swapped, True]


def module(init: str, inverted: bool) -> dict[str, Any]:
    """A register that holds its value, or the inverse of it behind it."""
    cells: dict[str, Any] = {"r": {"type": "$_DFF_P_", "connections": {"D": [2], "Q": [2]}}}
    if inverted:
        cells["n"] = {"type": "$_NOT_", "connections": {"A": [2], "Y": [3]}}
    bit = 3 if inverted else 2
    nets = {"q": {"bits": [bit], "attributes": {}}, "held": {"bits": [2], "attributes": {"init": init}}}
    return {"cells": cells, "ports": {"q": {"direction": "output", "bits": [bit]}}, "netnames": nets}


@pytest.mark.parametrize(("init", "right"), [("0", True), ("1", False)])
def test_an_inverted_register_has_the_inverse_at_first(init: str, right: bool) -> None:
    points = Points(Side(module("1", False)), Side(module(init, True)), ["q"])
    assert (set(points.differ.values()) == {FALSE}) == right


@pytest.mark.long
@pytest.mark.parametrize("family", ["ecp5", "ice40"])
def test_one_changed_table_is_not_proven(family: str, tmp_path: Path) -> None:
    netlists = snapshots(VERILOG, "small", family, f"synth_{family} -top small", tmp_path)
    found = verdict(netlists, "small", family, tmp_path)
    assert (found.unproven, found.unlinked) == ([], 0)
    assert found.points > 20
    tables = [cell for cell in netlists["gates"]["modules"]["small"]["cells"].values() if "LUT4" in cell["type"]]
    (name,) = {"INIT", "LUT_INIT"} & tables[0]["parameters"].keys()
    tables[0]["parameters"][name] = tables[0]["parameters"][name].translate(str.maketrans("01", "10"))
    assert verdict(netlists, "small", family, tmp_path).unproven
    assert isinstance(found, Verdict)


@pytest.mark.long
def test_what_multipliers_of_the_ice40_have_in_them(tmp_path: Path) -> None:
    netlists = snapshots(PRODUCTS, "products", "ice40", "synth_ice40 -dsp -top products", tmp_path)
    found = verdict(netlists, "products", "ice40", tmp_path)
    assert (found.unproven, found.alone, found.unlinked) == ([], [], 0)
    cells = netlists["words"]["modules"]["products"]["cells"].values()
    products = [cell for cell in cells if cell["type"] == "SB_MAC16"]
    for name in ("PIPELINE_16x16_MULT_REG1", "TOPOUTPUT_SELECT"):
        values = {int(cell["parameters"][name], 2) for cell in products}
        assert len(values) == 2
    wrong = next(cell for cell in products if int(cell["parameters"]["PIPELINE_16x16_MULT_REG1"], 2))
    wrong["parameters"] |= dict.fromkeys(("PIPELINE_16x16_MULT_REG1", "TOP_8x8_MULT_REG", "BOT_8x8_MULT_REG"), "0")
    unproven = verdict(netlists, "products", "ice40", tmp_path).unproven
    assert {name.partition("[")[0] for name in unproven} == {"rtl: output short"}
