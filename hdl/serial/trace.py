"""A frame, instruction by instruction: place in the program, operation and written value."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tfra.hdl.serial.program.disassembler import destination, disassemble
from tfra.hdl.serial.program.interpreter import Interpreter, Step
from tfra.hdl.serial.serial import Serial
from tfra.model.arrays import Ints


@dataclass(frozen=True)
class TracedStep:
    """An executed instruction; ``str`` gives a line: cycle, place in the program, stage, text, what is written."""

    step: Step
    stage: str
    """Stage of the frame; a subroutine's name stands after its caller's: ``gain.mu, routines.quotient``."""
    text: str
    """The instruction, with the memory's words by name."""
    destination: str
    """The value that it writes if its condition holds; a memory word by its address."""

    def __str__(self) -> str:
        step = self.step
        line = f"{step.cycle:7} {step.pc:5}  {self.stage:36} {self.text:44}"
        if self.destination and step.value is not None:
            value = step.value < 0 if self.destination.startswith("F") else step.value
            line += f" {self.destination} <- {value}"
        return line.rstrip()


def trace(core: Serial, codes: Ints) -> Iterator[TracedStep]:
    """Every instruction of ``core`` for the frames ``codes (n, rows, columns)``, in the interpreter.

    It ends where the program waits for the first code of one more frame.
    """
    code = core.program
    machine = Interpreter(code.sizes, code.lengths, code.instructions, list(code.memory), core.coefficients.tolist())
    caller = ""
    for step in machine.steps(iter(codes.ravel().tolist())):
        i = step.instruction
        inside = step.pc >= code.subroutines
        caller = caller if inside else i.stage
        stage = f"{caller}, {i.stage}" if inside else caller
        into = destination(i, code.names.get(step.address, str(step.address)))
        yield TracedStep(step, stage, disassemble(i, code.names), into)
