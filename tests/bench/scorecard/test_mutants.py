"""Line 5: equivalent mutants are proven so and no others; mutants survive too few frames; the figure counts both."""

from pathlib import Path

import pytest

from bench.scorecard.mutants.equivalent import SCRIPT, Prover, read
from bench.scorecard.mutants.measure import judged
from bench.scorecard.mutants.verilog import Mutant, Mutants
from bench.scorecard.words.drawn import drawn
from tfra.codegen.verilog.emit import run_yosys

DELAY = """\
module delay(input clk, input [3:0] mutant, input in_valid, input [3:0] in_data,
             output out_valid, output [3:0] out_data);
  reg valid = 0;
  reg [3:0] data = 0, unread = 0, again = 0, four = 4;
  reg [3:0] memory [0:3];
  always @(posedge clk) begin
    valid <= in_valid & (mutant != 1);
    if (in_valid | mutant == 2) data <= in_data;
    unread <= in_data ^ {4{mutant == 3}};
    again <= {4{mutant == 4}} & (mutant == 5 ? data ^ again : data ^ ~data ^ 15);
    four <= mutant == 6 ? four ^ 1 : four;
    if (in_valid & mutant != 7) memory[in_data[1:0]] <= in_data;
  end
  assign out_valid = valid;
  assign out_data = (valid | mutant == 8 ? data : 0) ^ again ^ {four[0] & mutant == 9, 3'b0} ^ memory[data[1:0]];
endmodule
"""
EQUIVALENT = [3, 4, 5, 6, 8, 9]
"""Mutants of registers that nobody reads or whose bits stay 0, and of an output that is not valid.

That data are stored while they are not valid (2) is not proven: they differ, and are valid later for all one knows.
"""


@pytest.fixture(scope="module", name="prover")
def _prover(tmp_path_factory: pytest.TempPathFactory) -> Prover:
    folder = tmp_path_factory.mktemp("delay")
    (folder / "delay.v").write_text(DELAY)
    run_yosys(f"read_verilog delay.v\nhierarchy -top delay\nproc\nmemory_collect\n{SCRIPT}", folder)
    return Prover(read(folder))


def test_equivalent_mutants_are_proven_and_no_others(prover: Prover) -> None:
    assert [number for number in range(1, 10) if prover.equivalent(number)] == EQUIVALENT


def test_what_survives_is_counted_and_listed_and_what_is_proven_is_not() -> None:
    core = {"name": "a", "mutants": 1100, "equivalent": 100, "survivors": ["inv A[0]: hdl/a.py:1"] * 20}
    sources = [{"file": "model/a.py", "test": "tests/a.py"}] * 9 + [{"file": "model/b.py", "test": ""}]
    good = judged([core], sources, 0.98)
    assert good.passed
    assert good.figure.startswith("of netlists 980 of 1000 (98.0 %, 95 % interval 96.9 to 98.7), 100 more proven")
    assert "; of model and codegen 9 of 10 (90.0 %" in good.figure
    assert good.facts == {"verilog": [core], "unnoticed": sources[-1:]}
    assert not judged([{**core, "equivalent": 99, "survivors": ["x"] * 21}], sources, 0.98).passed
    assert not judged([{**core, "equivalent": 101}], sources, 0.98).passed  # fewer than 1,000 are left
    assert not judged([core], [*sources, sources[-1]], 0.98).passed


@pytest.mark.long
def test_mutants_survive_too_few_frames_and_one_that_changes_nothing_survives_all(tmp_path: Path) -> None:
    mutants = Mutants(list(drawn(20, 1))[19], tmp_path, 20)
    directed = mutants.unnoticed(mutants.all, 0)
    assert 0 < len(directed) < len(mutants.all)
    none = Mutant(("mutate", "-ctrl", "mutant", "12", "4000"))
    assert mutants.unnoticed([none], 0) == [none]
    (tmp_path / "made_of" / "given").write_bytes(b"")
    assert set(directed) < set(mutants.unnoticed(mutants.all, 0))
