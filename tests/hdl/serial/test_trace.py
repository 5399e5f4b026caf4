"""The trace of a frame names stages, texts and values; instructions in readable text."""

from itertools import product

import pytest

from tests.hdl.serial.designs import DESIGNS
from tfra.hdl.cores import as_serial, program
from tfra.hdl.serial.isa import NO_POINTER, Dest, Instruction, Left, Op, Post, Src, When
from tfra.hdl.serial.trace import destination, disassemble, trace
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.pipeline import FixedTfra

DESIGN = DESIGNS["2×3"]
CODES = contact_codes(DESIGN, 1, seed=6)


def test_a_frame():
    steps = list(trace(as_serial(DESIGN), CODES))
    code = program(DESIGN)
    assert str(steps[0]).split() == ["0", "0", "reset", "m[counter]", "=", "0", "m[counter]", "<-", "0"]
    assert [s.step.cycle for s in steps] == list(range(len(steps)))
    words = [s.step.value for s in steps if s.step.instruction.written in (Dest.OUT, Dest.LAST)]
    assert words == FixedTfra(DESIGN)(CODES).words[0].tolist()
    callers = ("dependent.dependent", "friction.friction", "gain.gain", "gain.mu")
    assert {s.stage for s in steps if "quotient" in s.stage} == {f"{caller}, routines.quotient" for caller in callers}
    assert all((s.step.pc >= code.subroutines) == ("," in s.stage) for s in steps)


def test_what_is_not_written_has_no_value():
    kinds = {traced.text: str(traced) for traced in trace(as_serial(DESIGN), CODES) if traced.stage == "status.status"}
    assert kinds["R0 = 0 if F1"].endswith("R0 <- 0")
    assert kinds["R0 = 2 if F0"].endswith("R0 <- 2")
    assert kinds["R1 = 16 if F0"].endswith("R1 = 16 if F0")
    assert kinds["F1 = m[regular] < 0"].endswith("F1 <- True")


R2 = Left.R0 + 2


@pytest.mark.parametrize(
    ("instruction", "text"),
    [
        (Instruction(), "NOP"),
        (Instruction(end=True), "end of loop"),
        (Instruction(Op.ADD, R2, Src.M, Dest.M, 0, Post.UP, 40, When.F0), "m[P0 + 40] = R2 + m[P0 + 40] if F0, P0++"),
        (Instruction(Op.ADD, Left.ZERO, Src.M, Dest.R0, immediate=7), "R0 = m[counter]"),
        (Instruction(Op.ADD, Left.T, Src.NOTHING, Dest.R0), "R0 = round(T)"),
        (Instruction(Op.SUB, R2, Src.IMM, Dest.SH, immediate=-13), "SH = R2 - -13"),
        (Instruction(Op.SUB, R2, Src.R0, flag=2), "F1 = R2 - R0 < 0"),
        (Instruction(Op.DIV, R2, Src.FLOOR, Dest.R0 + 2), "DIV R2 - floor(T)"),
        (Instruction(Op.ADD, Left.ZERO, Src.IMM, Dest.P, 3, immediate=9), "P3 = 9"),
        (Instruction(pointer=1, post=Post.MOVE, immediate=-5), "P1 += -5"),
        (Instruction(Op.SHIFT, source=Src.PRODUCT), "T = PRODUCT >> SH"),
        (Instruction(Op.MAC, pointer=0), "sums = m[P0 ...] * store[SP ...]"),
        (Instruction(Op.DO, immediate=24), "DO 25 times"),
        (Instruction(Op.JUMP, immediate=12), "JUMP 12"),
        (Instruction(Op.JUMP, R2 - 2, immediate=12), "CALL 12"),
        (Instruction(Op.JUMP, Left.T), "RETURN"),
    ],
)
def test_text(instruction, text):
    assert disassemble(instruction, {7: "counter"}) == text


def test_every_combination_has_a_text():
    for op, left, source, dest in product(Op, range(8), Src, Dest):
        assert disassemble(Instruction(op, left, source, dest, NO_POINTER))


def test_destinations():
    assert destination(Instruction(Op.LENGTH), "3") == "T"
    assert destination(Instruction(dest=Dest.M), "3") == "m[3]"
    assert destination(Instruction(Op.MUL, dest=Dest.M), "3") == ""
    assert destination(Instruction(Op.SUB, flag=1), "3") == "F0"
