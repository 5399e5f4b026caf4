"""Instructions in readable text."""

from __future__ import annotations

import pytest

from tfra.hdl.serial.isa import NO_POINTER, Dest, Instruction, Left, Op, Post, Src, When
from tfra.hdl.serial.program.disassembler import destination, disassemble

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
    for op in Op:
        for left in range(8):
            for source in Src:
                for dest in Dest:
                    assert disassemble(Instruction(op, left, source, dest, NO_POINTER))


def test_destinations():
    assert destination(Instruction(Op.LENGTH), "3") == "T"
    assert destination(Instruction(dest=Dest.M), "3") == "m[3]"
    assert destination(Instruction(Op.MUL, dest=Dest.M), "3") == ""
    assert destination(Instruction(Op.SUB, flag=1), "3") == "F0"
