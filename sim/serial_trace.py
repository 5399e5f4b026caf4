"""The serial core's gateware against its interpreter: the first instruction that writes a different value."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from amaranth import Value

from tfra.hdl.cores import as_serial
from tfra.hdl.serial.core import SerialCore
from tfra.hdl.serial.isa import ADDRESS_BITS, NO_RESULT, Dest, Instruction, Op
from tfra.hdl.serial.program.interpreter import wrap
from tfra.hdl.serial.sizes import Sizes
from tfra.hdl.serial.trace import TracedStep, trace
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.sim.harness import Driver, Port
from tfra.sim.protocol import flowing

_PATIENCE = 1000
"""Cycles without an instruction, loading excluded, after which the core hangs."""


@dataclass(frozen=True)
class Difference:
    """The first instruction at which gateware and interpreter differ."""

    step: TracedStep
    expected: str
    observed: str

    def __str__(self) -> str:
        where = f"instruction {self.step.step.pc}, cycle {self.step.step.cycle}, {self.step.stage}"
        return f"{where}: {self.step.text}: expected {self.expected}, observed {self.observed}"


def first_difference(design: Design, codes: Ints, core: SerialCore | None = None) -> Difference | None:
    """The first instruction of the frames ``codes (n, rows, columns)`` that writes another value, or to another word,
    in ``core`` than in the interpreter; ``None`` if there is none.

    The core is the gateware of ``design`` by default, with a plain memory as its store; it runs in Amaranth's
    simulator.
    """
    serial = as_serial(replace(design, target="portable"))
    core = core or serial.build()
    path, size = core.datapath, core.program.sizes
    patience = _PATIENCE + serial.loaded.size
    differences: list[Difference] = []

    def compare(ctx: Any) -> Port:
        """Compare every executed instruction with the interpreter's, up to the first that differs."""
        ctx.set(core.result.ready, 1)
        for traced in _frames(design, codes):
            for _ in range(patience):
                advances, *signals = yield
                if advances:
                    break
            standstill = None if advances else Difference(traced, "its execution", "a standstill")
            if difference := standstill or _compare(traced, size, *signals):
                differences.append(difference)
                return

    driver = Driver(core, 0)
    driver.add_source("load", serial.loaded.tolist(), flowing)
    driver.add_source("taxel", codes.ravel().tolist(), flowing)
    word, address = Value.cast(path.executing.instruction), path.executing.address
    written = (path.acts, path.total, path.result, path.shifted)
    driver.add_watch(compare, path.advance & path.executing.valid, word, address, *written)
    driver.simulate()
    return differences[0] if differences else None


def _frames(design: Design, codes: Ints) -> Iterator[TracedStep]:
    """The interpreter's instructions up to the last result word."""
    frames = 0
    for traced in trace(as_serial(design), codes):
        yield traced
        frames += traced.step.instruction.written == Dest.LAST
        if frames == len(codes):
            return


def _compare(
    traced: TracedStep, size: Sizes, word: int, address: int, acts: int, total: int, result: int, shifted: int
) -> Difference | None:
    """The difference of a step from the observed signals of the instruction that the datapath executes, if any."""
    step, i = traced.step, traced.step.instruction
    if word != i.word:
        return Difference(traced, f"the word {i.word:#x}", f"another instruction, {word:#x}")
    if not traced.destination:
        return None
    value = _written(i, size, total, result, shifted) if acts else None
    if value == step.value and (value is None or i.written != Dest.M or address == step.address):
        return None
    return Difference(traced, _write(i, step.value, step.address), _write(i, value, address))


def _written(i: Instruction, size: Sizes, total: int, result: int, shifted: int) -> int | None:
    """The value that ``i`` writes where its condition holds; ``None`` if nothing is."""
    if i.op in (Op.SHIFT, Op.LENGTH):
        return shifted
    if i.op in NO_RESULT or (i.op == Op.DIV and result < 0):
        return None
    if i.dest == Dest.P:
        return total % (1 << ADDRESS_BITS)
    short: dict[int, int] = {Dest.Y: size.multiplier, Dest.SH: size.shift, Dest.SP: size.word}
    return wrap(total, short[i.dest]) if i.dest in short else result


def _write(i: Instruction, value: int | None, address: int) -> str:
    if value is None:
        return "nothing written"
    return f"{value} to word {address}" if i.written == Dest.M else str(value)
