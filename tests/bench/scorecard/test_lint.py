"""Linters beyond those that the tests of generated Verilog ask: what they find when it is planted."""

import pytest

from bench.scorecard import lint, linters

GOOD = "module good(input clk, output reg [3:0] word);\n  always @(posedge clk) word <= word + 4'd1;\nendmodule\n"


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("4'd1", "4'd1", ""),
        ("4'd1", "4'd", "error"),
        ("module good", "module good;\nendmodule\nmodule good", "duplicate definition"),
        ("word <=", "other.word <=", "other"),
        ("endmodule", "wire [1:0] w;\nassign w[7] = clk;\nendmodule", "-Windex-oob"),
    ],
)
def test_slang(old, new, found, tmp_path):
    file = tmp_path / "good.v"
    file.write_text(GOOD.replace(old, new, 1))
    said = linters.slang(file)
    assert found in said
    assert bool(said) == bool(found)


def test_a_warning_misses_the_target(monkeypatch):
    said = {"verilator": "", "slang": "good.v:1: warning"}
    monkeypatch.setattr(lint, "python", lambda: {"ruff": ""})
    monkeypatch.setattr(lint, "verilog", lambda array, folder: said)
    found = lint.measure(True)
    assert not found.passed
    assert found.figure == "2 of 5 runs of linters have a warning"
    assert found.facts["warnings"] == {f"{name}: slang": ["good.v:1: warning"] for name in lint.QUICK}
    said["slang"] = ""
    assert lint.measure(True).passed
