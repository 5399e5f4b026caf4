"""Programs of a few instructions: pauses, cycles, loops and calls, as the interpreter executes them."""

from functools import partial

import pytest

from tfra.hdl.serial.isa import FLOOR, NOTHING, R0, R1, Dest, K, Op, Operand, Src, T, imm, mem, pointer
from tfra.hdl.serial.program.assembler import Assembler
from tfra.hdl.serial.program.interpreter import Hazard, Interpreter
from tfra.hdl.serial.sizes import Sizes

SIZES = Sizes(32, 8, 12, 16, 2, 24, 16, 16, 16, 8, 16)


def execute(a: Assembler) -> tuple[Interpreter, int]:
    """The machine behind the program of ``a``, and the cycles it took."""
    end = len(a.program)
    a.jump(end)
    a.link()
    machine = Interpreter(SIZES, (1,), a.program, [0] * 64, [])
    for step in machine.steps(iter([])):
        if step.pc == end:
            break
    return machine, machine.cycle


def count(a: Assembler) -> None:
    a.add(R0, R0, imm(1))


@pytest.mark.parametrize(
    ("write", "read"),
    [
        (partial(Assembler.move, dest=pointer(1), source=imm(5)), partial(Assembler.move, dest=R0, source=mem(2, 1))),
        (partial(Assembler.move, dest=mem(7), source=R1), partial(Assembler.move, dest=R0, source=mem(7))),
        (partial(Assembler.move, dest=R0, source=imm(5)), partial(Assembler.act, op=Op.LENGTH, source=R0)),
        (partial(Assembler.move, dest=Dest.SH, source=imm(1)), partial(Assembler.act, op=Op.SHIFT, source=R0)),
        (partial(Assembler.op, op=Op.DIV, dest=R0, left=R0, source=FLOOR), partial(Assembler.move, dest=R1, source=K)),
        (partial(Assembler.op, op=Op.DIV, dest=R0, left=R0, source=FLOOR), partial(Assembler.move, dest=R1, source=R0)),
    ],
)
def test_pauses_are_as_long_as_needed(write, read):
    a = Assembler()
    write(a)
    read(a)
    _, cycles = execute(a)
    assert cycles == a.cycles - 2  # behind the end stand a jump and its delay slot
    early = [i for i in a.program if i.op != Op.ADD or i.dest != Dest.NONE]
    assert len(early) < len(a.program) - 1
    with pytest.raises(Hazard):
        list(Interpreter(SIZES, (1,), early, [0] * 64, []).steps(iter([])))


@pytest.mark.parametrize("times", range(10))
@pytest.mark.parametrize("inner", [1, 4])
def test_loops_nest_and_are_counted(times, inner):
    a = Assembler()
    for _ in a.unrolled(times):
        count(a)
    with a.loop(times + 1), a.loop(inner):
        count(a)
    machine, cycles = execute(a)
    assert machine.registers[0] == times + (times + 1) * inner
    assert cycles == a.cycles - 2


@pytest.mark.parametrize("length", range(40))
def test_pauses_of_any_length(length):
    a = Assembler()
    a.nop(length)
    assert execute(a)[1] == length


def test_calls_are_written_once_and_marked():
    a = Assembler()
    a.stage = "main"
    a.call("double", lambda: a.add(R1, R1, R0))
    for value in (3, 4):
        a.move(R0, imm(value))
        a.call("double", lambda: a.add(R1, R1, R0))
    a.stage = "end"
    machine, cycles = execute(a)
    assert machine.registers[1] == 7
    assert cycles == a.cycles - 2
    assert [i.stage for i in a.program].count("double") == 3  # the sum, the return and its delay slot


def test_operands_without_one_address_are_refused():
    a = Assembler()
    with pytest.raises(ValueError, match="same address"):
        a.move(mem(3), mem(4))
    with pytest.raises(ValueError, match="additions only"):
        a.sub(R0, T, NOTHING)
    with pytest.raises(ValueError, match="11 bits"):
        a.move(R0, Operand(Src.IMM, immediate=1 << 11))
    assert not a.program
