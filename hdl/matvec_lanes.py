"""The lanes of the matrix-vector unit: groups in a row, through which operands and addresses pass one by one."""

from __future__ import annotations

from typing import Any

from amaranth import Array, Cat, Elaboratable, Module, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.codegen.images import depth, lane_images
from tfra.hdl.arithmetic import count
from tfra.hdl.parts import in_parts, nth_part
from tfra.hdl.pipeline import delayed, register, walk
from tfra.hdl.primitives import Multiplier, Rom
from tfra.model.design import Design
from tfra.model.fixed.numbers import Ints
from tfra.model.fixed.widths import widths

GROUP = 4
"""Lanes of a group, one for each word of an operand quad; a core may have fewer."""

_NEIGHBOURS = 4
"""Groups that share a register on the way from their sums to the drain."""

LANES_LATENCY = 2
"""Cycles from complete sums of the first group to its first words in ``sums``."""


def group_size(design: Design) -> int:
    """Lanes of a group: operand words that are multiplied in a cycle."""
    return min(GROUP, design.architecture.mac_lanes)


def drain_words(design: Design) -> int:
    """W: words that leave the lanes in a cycle."""
    return min(design.architecture.vector_words, design.architecture.mac_lanes)


def drain_steps(design: Design) -> int:
    """Cycles in which the words of a pass leave the lanes."""
    return design.architecture.mac_lanes // drain_words(design)


def link(design: Design) -> data.StructLayout:
    """What passes from group to group: operand words, and the address of their coefficients two cycles before them.

    While coefficients are loaded, it is where ``word`` is written: lane and address.
    """
    layout = {"words": data.ArrayLayout(signed(design.formats.operand), group_size(design))}
    layout |= {"address": count(depth(design) - 1)}
    if design.images == "load":
        lane = count(design.architecture.mac_lanes - 1)
        layout |= {"write": 1, "lane": lane, "word": signed(design.formats.coefficient)}
    return data.StructLayout(layout)


MARKS = data.StructLayout({"valid": 1, "complete": 1})
"""Two cycles behind the words, products are valid; a cycle behind the last of them, sums are complete."""


class Lanes(wiring.Component):
    """Sums of all lanes, W words a cycle: those of a group are complete when it is their turn to leave.

    ::

        i, marks -> group -> group -> group -> ...      each ``parts`` cycles behind the one before
                      |        |        |
                     sums     sums     sums  -> a register for each four groups -> W words

    So the operands are not broadcast and the sums wait nowhere.  The next pass may begin when the words of this one
    have begun to leave as many cycles ago as they are steps.

    Members:
        i, marks: what enters the first group.
        sums, step, valid: words of a pass, and which they are.
        begins: high in the cycle before the first of them.

    Resources: L multipliers (coefficient x operand) with registers on both sides, a memory of coefficients for each.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._parts = design, group_size(design) // drain_words(design)
        accumulator = signed(widths(design).accumulator)
        super().__init__(
            {
                "i": In(link(design)),
                "marks": In(MARKS),
                "sums": Out(data.ArrayLayout(accumulator, drain_words(design))),
                "step": Out(count(drain_steps(design) - 1)),
                "valid": Out(1),
                "begins": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        groups = self._groups(m)
        gathered = [self._gather(m, groups[k : k + _NEIGHBOURS]) for k in range(0, len(groups), _NEIGHBOURS)]
        leaving = Signal()
        step, last = walk(m, leaving, drain_steps(self._design), "leaves")
        m.d.comb += [
            self.begins.eq(register(m, groups[0].passed.complete, "begins", control=True)),
            leaving.eq(in_parts(m, self.begins, last)),
            self.valid.eq(register(m, leaving, "valid", control=True)),
            self.step.eq(register(m, step)),
        ]
        steps = (_NEIGHBOURS * self._parts - 1).bit_length()  # bits of a step within neighbours
        words = Array(gathered)[step >> steps] if len(gathered) > 1 else gathered[0]
        part = nth_part(words, step[: (self._parts - 1).bit_length()], self._parts)
        m.d.comb += self.sums.eq(register(m, part, "sums"))
        return m

    def _groups(self, m: Module) -> list[_Group]:
        """All of them, each linked to the one before."""
        design, size = self._design, group_size(self._design)
        images, groups = lane_images(design), list[_Group]()
        passed, marks = self.i, self.marks
        for number, first in enumerate(range(0, len(images), size)):
            group = _Group(design, first, images[first : first + size], self._parts if number else 1)
            m.submodules[f"group{number}"] = group
            m.d.comb += [group.i.eq(passed), group.marks.eq(marks)]
            passed, marks = group.o, group.passed
            groups.append(group)
        return groups

    def _gather(self, m: Module, groups: list[_Group]) -> Value:
        """Sums of the group of a few neighbours that was complete last; they take turns."""
        complete = Cat(group.passed.complete for group in groups).any()
        turn, _ = walk(m, complete, len(groups), "turn")
        sums = [Cat(group.sums) for group in groups]
        with m.If(complete):
            return register(m, Array(sums)[turn] if len(sums) > 1 else sums[0], "gathered")


class _Group(Elaboratable):
    """Neighbouring lanes, one for each word of an operand quad, and the memories of their coefficients."""

    def __init__(self, design: Design, first: int, images: Ints, cycles: int) -> None:
        self._design, self._first, self._images, self._cycles = design, first, images, cycles
        self.i, self.o = (Signal(link(design), name=name) for name in ("i", "o"))
        self.marks, self.passed = (Signal(MARKS, name=name) for name in ("marks", "passed"))
        self.sums = [Signal(signed(widths(design).accumulator), name=f"sum{n}") for n in range(len(images))]

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design, loaded = self._design, self._design.images == "load"
        m.d.comb += [
            self.o.eq(delayed(m, self.i.as_value(), self._cycles, "passed")),
            self.passed.eq(delayed(m, self.marks.as_value(), self._cycles, "marks", control=True)),
        ]
        m.submodules.rom = rom = Rom(self._images, design.formats.coefficient, design.target, loaded=loaded)
        m.d.comb += rom.address.eq(self.o.address)
        if loaded:
            m.d.comb += [
                rom.write.eq(Cat(self.o.write & (self.o.lane == self._first + n) for n in range(len(self.sums)))),
                rom.data.eq(self.o.word),
            ]
        for number, coefficient in enumerate(rom.words):
            m.submodules[f"lane{number}"] = lane = _Lane(design)
            m.d.comb += [
                lane.coefficient.eq(coefficient),
                lane.word.eq(self.o.words[number]),
                lane.valid.eq(self.passed.valid),
                self.sums[number].eq(lane.sum),
            ]
        return m


class _Lane(Elaboratable):
    """Multiplier and accumulator.

        coefficient, word -> multiply -> product -> + -> sum

    ``valid`` comes two cycles after the factors; ``sum`` a cycle later.  The sum runs on from pass to pass, modulo
    its word, which saves a multiplexer a bit: the drain takes the sum of the pass before away.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self.coefficient = Signal(signed(design.formats.coefficient))
        self.word = Signal(signed(design.formats.operand))
        self.valid = Signal()
        self.sum = Signal(signed(widths(design).accumulator))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.multiplier = multiplier = Multiplier(len(self.coefficient), len(self.word), self._design.target)
        m.d.comb += [multiplier.a.eq(self.coefficient), multiplier.b.eq(self.word)]
        with m.If(self.valid):
            m.d.sync += self.sum.eq(multiplier.product + self.sum)
        return m
