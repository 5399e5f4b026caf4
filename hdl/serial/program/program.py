"""The serial core's program of a frame: an estimator's stages between intake and the next frame."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from tfra.hdl.serial.isa import NOTHING, Instruction
from tfra.hdl.serial.program.memory import lengths
from tfra.hdl.serial.program.routines import Writer, label
from tfra.hdl.serial.sizes import Sizes

_Writer = TypeVar("_Writer", bound=Writer)


@dataclass(frozen=True)
class Program:
    """The program of a frame, and its cycles, none of which depends on data."""

    sizes: Sizes
    lengths: tuple[int, ...]  # numbers of products of a row, which MAC chooses from
    instructions: tuple[Instruction, ...]
    subroutines: int  # instructions before the first subroutine; after it there are only subroutines
    memory: tuple[int, ...]  # initial contents of the data memory
    operands: int  # the lowest words of the memory, of which the lanes have a copy
    names: dict[int, str]  # names of words of the memory, by address
    first: int  # cycles from the instruction that takes a frame's last taxel to that of its first result word
    last: int  # cycles from the instruction that takes a frame's last taxel to that of its last result word
    interval: int  # cycles from frame to frame
    intake: int  # cycles from the instruction that takes a frame's first taxel to that of its last
    taxel: int  # cycles from a taxel to the next one of its row


def write(
    w: _Writer,
    intake: Callable[[_Writer], tuple[int, int, int]],
    analysis: Sequence[Callable[[_Writer], None]],
    result: Sequence[Callable[[_Writer], None]],
) -> Program:
    """The program of an estimator, written by ``w``: its stages up to the first result word, and from there on.

    ``intake`` returns the cycle that takes the last code, the cycles since the first one, and those from one code to
    the next of its row.  Raises ``ValueError`` when the program does not fit the memories.
    """
    a = w.assembler
    a.stage = "reset"
    a.move(w.at("counter"), NOTHING)
    start, before = len(a.program), a.cycles
    a.stage = label(intake)
    taken, span, taxel = intake(w)
    _stages(w, analysis)
    first = a.cycles - taken + 1  # the header fetches the counter, its first word, with its first instruction
    _stages(w, result)
    last = a.cycles - taken - 1
    a.jump(start)
    interval = a.cycles - before
    subroutines = a.link()
    w.map.reserve(2)  # a product looks for a fifth parity after its table
    return Program(
        sizes=w.sizes,
        lengths=lengths(w.design),
        instructions=tuple(a.program),
        subroutines=subroutines,
        memory=tuple(w.map.words),
        operands=w.map.operands,
        names=w.map.names,
        first=first,
        last=last,
        interval=interval,
        intake=span,
        taxel=taxel,
    )


def _stages(w: _Writer, stages: Sequence[Callable[[_Writer], None]]) -> None:
    for stage in stages:
        w.assembler.stage = label(stage)
        stage(w)
