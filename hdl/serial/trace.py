"""A frame, instruction by instruction: place in the program, operation as readable text, and written value."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from tfra.hdl.serial import isa
from tfra.hdl.serial.isa import Dest, Instruction, Left, Op, Post, Src, When
from tfra.hdl.serial.program.interpreter import Interpreter, Step
from tfra.hdl.serial.serial import Serial
from tfra.model.arrays import Ints

_CONDITIONS = {When.F0: "F0", When.NOT_F0: "not F0", When.F1: "F1", When.NOT_F1: "not F1"}

_MOVES = {Post.KEEP: "", Post.UP: "{pointer}++", Post.DOWN: "{pointer}--", Post.MOVE: "{pointer} += {by}"}

_ACTIONS = {
    Op.ADD: "{left} + {source}",
    Op.SUB: "{left} - {source}",
    Op.PLUS: "{left} + max({source}, 0)",
    Op.LESS: "{left} - min({source}, 0)",
    Op.ABS: "{left} + |{source}|",
    Op.OR: "{left} | bits({source})",
    Op.AND: "{left} & {source}",
    Op.FIT: "fit(T)",
    Op.LIMIT: "limit({source})",
    Op.DIV: "DIV {left} - {source}",
    Op.SHIFT: "T = {source} >> SH",
    Op.LENGTH: "T = bit length of {source}",
    Op.MUL: "product = {source} * Y",
    Op.MAC: "sums = m[{address} ...] * store[SP ...]",
    Op.DO: "DO {times} times",
    Op.JUMP: "JUMP {target}",
}
"""DIV writes its left operand, if at all."""

_OPERANDS = {"FLOOR": "floor(T)", "T": "round(T)", "ZERO": "0", "NOTHING": "0"}

Names = Mapping[int, str]
"""Names of words of the data memory, by address."""


@dataclass(frozen=True)
class TracedStep:
    """An executed instruction; ``str`` gives a line: cycle, place in the program, stage, text, what is written."""

    step: Step
    stage: str  # of the frame; a subroutine's name stands after its caller's: ``gain.mu, routines.quotient``
    text: str  # the instruction, with the memory's words by name
    destination: str  # what it writes to if its condition holds; a memory word by its address

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


def disassemble(instruction: Instruction, names: Names | None = None) -> str:
    """``instruction`` as text, for example ``R2 = R2 + m[P0 + 40] if F0, P0++``."""
    i = instruction
    parts = [_action(i, names or {})]
    if i.when:
        parts[0] += f" if {_CONDITIONS[i.when]}"
    if i.flag and i.written != Dest.NONE:
        parts.append(f"F{i.flag - 1} = sign")
    if i.post and i.pointer != isa.NO_POINTER:
        parts.append(_MOVES[i.post].format(pointer=f"P{i.pointer}", by=i.immediate))
    if i.end:
        parts.append("end of loop")
    return ", ".join(part for part in parts if part) or "NOP"


def destination(instruction: Instruction, address: str) -> str:
    """Name of what ``instruction`` writes, a memory word by ``address``; empty if it writes nothing."""
    i = instruction
    if i.op in (Op.SHIFT, Op.LENGTH):
        return "T"
    if i.written == Dest.NONE:
        return f"F{i.flag - 1}" if i.flag else ""
    if i.written == Dest.M:
        return f"m[{address}]"
    return f"P{i.pointer}" if i.written == Dest.P else _operand(Dest, i.written)


def _action(i: Instruction, names: Names) -> str:
    if i.op == Op.JUMP and i.left == Left.T:
        return "RETURN"
    if i.op == Op.JUMP and i.left == Left.R0:
        return f"CALL {i.immediate}"
    address = _address(i, names)
    into = destination(i, address)
    if i.op not in isa.NO_RESULT and not into:
        return ""
    form = _ACTIONS[i.op]
    if i.op == Op.ADD and i.source == Src.NOTHING:
        form = "{left}"
    elif i.op == Op.ADD and i.left == Left.ZERO:
        form = "{source}"
    left, source = _operand(Left, i.left), _source(i, address)
    text = form.format(left=left, source=source, address=address, times=i.immediate + 1, target=i.immediate)
    if i.op in isa.NO_RESULT or i.op == Op.DIV:
        return text
    return f"{into} = {text}" + (" < 0" if i.written == Dest.NONE else "")


def _source(i: Instruction, address: str) -> str:
    if i.source == Src.M:
        return f"m[{address}]"
    if i.source == Src.IMM:
        half = 1 << (isa.ADDRESS_BITS - 1)
        return str((i.immediate + half) % (2 * half) - half)
    return _operand(Src, i.source)


def _address(i: Instruction, names: Names) -> str:
    if i.pointer == isa.NO_POINTER:
        return names.get(i.immediate, str(i.immediate))
    return f"P{i.pointer} + {i.immediate}" if i.immediate else f"P{i.pointer}"


def _operand(kind: type[Left] | type[Src] | type[Dest], number: int) -> str:
    if kind.R0 <= number < kind.R0 + isa.REGISTERS:
        return f"R{number - kind.R0}"
    name = kind(number).name
    return _OPERANDS.get(name, name)
