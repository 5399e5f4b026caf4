"""A netlist computes the same before and after it is made tidy, as yosys proves; its text comes back as it was."""

from __future__ import annotations

import random
import re
from pathlib import Path
from typing import Any

import pytest
from amaranth import Array, Cat, Module, Mux, Shape, Signal, Value, signed
from amaranth.back import rtlil

from tests.codegen import lint
from tfra.codegen.verilog.emit import plain_verilog, run_yosys
from tfra.codegen.verilog.liveness import Liveness
from tfra.codegen.verilog.netlist import parse, written
from tfra.codegen.verilog.tidy import tidied
from tfra.runtime.processes import ToolError

PROOF = """\
read_rtlil before.il; hierarchy -top dut; proc; memory; flatten; rename -top before; design -stash first
read_verilog after.v; hierarchy -top dut; proc; memory; flatten; rename -top after; design -stash second
design -copy-from first before; design -copy-from second after
miter -equiv -flatten -make_assert before after proof; async2sync
sat -verify -prove-asserts -seq 1 -tempinduct -maxsteps 20 proof
"""
"""Equal outputs for every input and, by induction, in every cycle."""


def expression(rng: random.Random, words: list[Value]) -> Value:
    """An operation on some of ``words``, at most 12 bits long."""
    a, b, c = (rng.choice(words) for _ in range(3))
    few = b.as_unsigned()[:3]
    made: list[Any] = [
        lambda: a + b, lambda: a - b, lambda: -a, lambda: a[:5] * b[:4], lambda: a & b, lambda: a | b, lambda: a ^ b,
        lambda: ~a, lambda: a == b, lambda: a != b, lambda: a < b, lambda: a >= b, lambda: a > b, lambda: a <= b,
        lambda: Mux(a < c, b, c), lambda: a << few[:2], lambda: a >> few, lambda: a.as_signed() >> few,
        lambda: Cat(a, b)[1:9], lambda: Cat(a[:2], b[-1:], c), lambda: a.as_signed() + b, lambda: abs(a),
        lambda: a.any(), lambda: a.all() ^ b.xor(), lambda: Array(words[:3])[few[:2]], lambda: a.bit_select(few, 2),
        lambda: a.as_unsigned() < 0, lambda: a.as_unsigned() >= 0, lambda: a == 3, lambda: a.as_signed() < -2,
    ]  # fmt: skip
    word = Value.cast(rng.choice(made)())
    return word if len(word) <= 12 else word[rng.randrange(3) : 12]


def block(rng: random.Random, m: Module, inputs: list[Value], count: int) -> list[Value]:
    """``count`` results of operations on ``inputs``, parts of them behind registers."""
    words = list(inputs)
    for number in range(count):
        word = expression(rng, words)
        shape = word.shape() if rng.random() < 0.7 else Shape(len(word), rng.random() < 0.5)
        kept = Signal(shape, name=f"kept{number}")
        if rng.random() < 0.3:
            m.d.sync += kept.eq(word)
        else:
            m.d.comb += kept.eq(word)
        words.append(kept)
        if len(kept) > 3 and rng.random() < 0.3:
            words.append(kept[1:-1])
    return words[len(inputs) :]


def design(seed: int) -> str:
    """RTLIL of random logic in two modules."""
    rng = random.Random(seed)
    top, inner = Module(), Module()
    inputs = [Signal(Shape(bits, bits % 2 == 1), name=f"in{bits}") for bits in (1, 4, 5, 7)]
    passed = [Signal(signed(9), name=f"passed{number}") for number in range(3)]
    outputs = [Signal(Shape(bits, bits % 2 == 0), name=f"out{bits}") for bits in (3, 6, 9, 12)]
    top.submodules.inner = inner
    given = block(rng, top, list(inputs), 5)
    results = block(rng, inner, [*inputs[:2], *given[-2:]], 12)
    inner.d.comb += [to.eq(word) for to, word in zip(passed, results[-3:], strict=True)]
    last = block(rng, top, [*inputs, *passed], 10)
    top.d.comb += [to.eq(word) for to, word in zip(outputs, last[-4:], strict=True)]
    return str(rtlil.convert(top, name="dut", ports=[*inputs, *outputs], emit_src=False))


def prove(before: str, after: str, place: Path) -> None:
    (place / "before.il").write_text(before)
    (place / "after.v").write_text(after)
    run_yosys(PROOF.replace("\n", "; "), place)


@pytest.mark.parametrize("seed", [0, 1, 2, 109])  # in the last, an output repeats a bit of its own
def test_random_logic_stays_what_it_is(seed: int, tmp_path: Path) -> None:
    """And linters have nothing to say about it, but for ports of the top, which stay as they are."""
    before = design(seed)
    after = plain_verilog(before, "dut")
    prove(before, after, tmp_path)
    file = tmp_path / "dut.v"
    file.write_text(after)
    assert lint.icarus(file) == ""
    found = [line for line in lint.verilator(file, tmp_path).splitlines() if line.startswith("%Warning")]
    assert [line for line in found if not re.search(r"(UNUSEDSIGNAL|UNOPTFLAT).*'(in|out)\d'", line)] == []


@pytest.mark.long
@pytest.mark.parametrize("seed", range(100, 140))
def test_more_random_logic(seed: int, tmp_path: Path) -> None:
    before = design(seed)
    prove(before, plain_verilog(before, "dut"), tmp_path)


def test_the_proof_notices_a_wrong_operation(tmp_path: Path) -> None:
    before = design(0)
    after = plain_verilog(before, "dut")
    assert " + " in after
    with pytest.raises(ToolError, match="proof did fail"):
        prove(before, after.replace(" + ", " - ", 1), tmp_path)


NETLIST = """\
module \\top.inner
  attribute \\init 4'01x0
  wire width 4 offset 2 input 2 signed \\a$1
  wire width 1 offset 0 input 1 \\clk
  wire width 6 offset 0 output 3 \\y
  wire width 4 offset 0 $1
  cell $add $2
    parameter \\A_SIGNED 1
    parameter \\Y_WIDTH 4
    connect \\A { \\a$1 [3] \\a$1 [2:0] }
    connect \\B { 2'01 \\a$1 [1:0] }
    connect \\Y $1
  end
  connect \\y { 2'x0 $1 }
end
"""


def test_a_netlist_comes_back() -> None:
    """With the terms of a word joined."""
    text = written(parse(NETLIST))
    assert text == NETLIST.replace("{ \\a$1 [3] \\a$1 [2:0] }", "\\a$1")
    assert written(parse(text)) == text


def test_numbers_have_32_bits() -> None:
    (module,) = parse("module \\m\n  attribute \\init -2\n  wire width 32 \\a\n  connect \\a 5\nend\n").values()
    assert module.wires["\\a"].init == "1" * 31 + "0"
    assert module.aliases == [(list(range(32)), [*"101", *"0" * 29])]


@pytest.mark.parametrize("line", ["  process $1", "  wire width \\a", "  connect \\a ?"])
def test_what_is_not_understood_is_no_guesswork(line: str) -> None:
    with pytest.raises(ValueError, match="not understood"):
        parse(f"module \\m\n  wire width 1 \\a\n{line}\nend\n")


def test_an_unknown_operation_is_refused() -> None:
    text = NETLIST.replace("$add", "$magic")
    with pytest.raises(ValueError, match=r"the operation \$magic is not known"):
        tidied(parse(text), "\\top.inner")


def test_liveness_of_a_sum() -> None:
    """Bit 1 of a sum depends on bits 0 and 1 of its operands."""
    text = NETLIST.replace("connect \\y { 2'x0 $1 }", "connect \\y { 5'x0000 $1 [1] }")
    modules = parse(text.replace("output 3 ", "").replace("wire width 6", "attribute \\keep 1\n  wire width 6"))
    module = modules["\\top.inner"]
    live = Liveness({**modules, "\\top.inner": module}, "\\top.inner").live["\\top.inner"]
    ones = module.wires["$1"]
    assert list(live[ones.first : ones.first + 4]) == [0, 1, 0, 0]
