"""Coverage: a branch that is never reached, an empty bin and a file with half of its branches miss the target."""

from collections import Counter
from typing import Any

import pytest

from bench.scorecard.coverage import bins, measure, python
from bench.scorecard.coverage.run import Covered
from bench.scorecard.coverage.verilog import Point, block_of, points
from bench.scorecard.coverage.waivers import waived
from bench.scorecard.line import Measured

VERILOG = """\
module core__add(a, b);
  assign _0_ = a[3] | b[12];
  assign _1_ = 1'h0 | _2_;
  assign _2_ = ~ 1'h1;
  assign o = _0_ ? a : b;
  assign p = _1_ ? a : b;
  assign q = _0_ ? b : a;
endmodule
"""
NAMES = ("one point", "several")
PYTHON = {"stale": "", "branches": 100, "taken": 95}


def entry(line: int, kind: str, count: int, module: str = "core__add") -> str:
    page = "v_line" if kind == "block" else "v_branch"
    fields = {"f": "/tmp/core.v", "l": line, "n": 3, "t": "line", "page": f"{page}/{module}", "o": kind, "h": "TOP"}
    return "C '" + "".join(f"\x01{name}\x02{value}" for name, value in fields.items()) + f"' {count}\n"


def test_points() -> None:
    data = "# SystemC::Coverage-3\n" + entry(2, "block", 7) + entry(5, "cond_then", 0) + entry(5, "cond_else", 3)
    data += entry(6, "cond_then", 0) + entry(7, "cond_else", 4)
    assert points(data, ["core"], {"core.v": VERILOG}) == {
        Point("add", "block", "line 2 of core__add"): 7,
        Point("add", "cond_then", "(a[N] | b[N])"): 0,
        Point("add", "cond_else", "(a[N] | b[N])"): 7,
    }


@pytest.mark.parametrize(
    ("module", "block"),
    [("c2x3", "top"), ("c2x3__core__e1", "core__e"), ("c2x3_axi__core__crc_12__crc_3", "core__crc__crc")],
)
def test_blocks(module: str, block: str) -> None:
    assert block_of(module, ["c2x3", "c2x3_axi"]) == block


def judged(reached: int, hit: int = 1, wrong: int = 0, packaged: dict[str, Any] | None = PYTHON) -> Measured:
    point = Point("core__add", "cond_then", "(a[N] | b[N])")
    counts = Counter({NAMES[0]: 5, NAMES[1]: hit})
    return measure.judged([Covered({point: reached}, counts, 9, wrong)], NAMES, packaged)


def test_what_is_not_reached_misses_the_target(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measure, "WAIVERS", ())
    assert judged(1).passed
    assert not judged(0).passed
    assert judged(0).facts["verilog"]["missed"] == ["core__add | cond_then | (a[N] | b[N])"]
    assert not judged(1, hit=0).passed
    assert judged(1, hit=0).facts["empty"] == ["several"]
    assert not judged(1, wrong=1).passed
    assert not judged(1, packaged={**PYTHON, "taken": 94}).passed
    assert not judged(1, packaged={**PYTHON, "stale": "a test failed"}).passed


def test_a_quick_run_tells_branches_and_judges_the_rest() -> None:
    assert judged(0, packaged=None).passed
    assert judged(0, packaged=None).facts["verilog"]["missed"]
    assert not judged(1, hit=0, packaged=None).passed
    assert not judged(1, wrong=1, packaged=None).passed


def test_a_waiver_is_for_its_points_alone() -> None:
    point = Point("core__weights__fold", "cond_else", "advance")
    assert waived(point)
    assert not waived(Point("core__weights__fold", "cond_then", "advance"))
    assert not waived(Point("core__sweep", "cond_else", "advance"))


def test_bins_are_declared_once_and_pairs_exclude_what_can_not_be() -> None:
    names = bins.declared()
    assert len(names) == len(set(names))
    assert "status: tfra, NO_CONTACT + INPUT_SATURATED" in names
    assert not any("NO_CONTACT + OUTPUT_SATURATED" in name or "NO_CONTACT + NO_DIR" in name for name in names)


def test_half_of_the_branches_of_a_file(tmp_path) -> None:
    summary = {"num_branches": 4, "covered_branches": 2, "num_statements": 9, "covered_lines": 8}
    files = {"a.py": {"summary": {**summary, "covered_branches": 4}}, "b.py": {"summary": summary}}
    least, whole = python.read({"files": files})
    assert (least.file, least.share, whole.share) == ("b.py", 50, 100)
