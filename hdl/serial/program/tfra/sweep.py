"""The exact sweep: B^z and B^xy of all candidates from the sign changes of the taxels' terms, and the choice (Eqs.
23-27).

There are two tables for each sum, with a word a candidate:

======  ==============================================================================
height  what the sum loses at the candidate; later the sum itself
slope   what its increase from candidate to candidate changes by
======  ==============================================================================
"""

from tfra.hdl.serial import isa
from tfra.hdl.serial.isa import FLOOR, NOTHING, PRODUCT, R0, R1, R2, R3, R4, R5, ZERO, Dest, Op, Post, When, imm, mem
from tfra.hdl.serial.program.butterfly import butterfly, butterfly_of_difference, each_quad, mirrors, quad
from tfra.hdl.serial.program.tfra.memory import TfraWriter, sweep_bits
from tfra.model.fixed.tfra.sweep import tolerance

# Stages


def unfold(w: TfraWriter) -> None:
    """p = C33 A-dagger_3 e0 - g and q = C33 A-dagger_3 e1, taxel by taxel, in place of the normal products."""
    memory = w.map
    with each_quad(w, memory.p):
        butterfly_of_difference(w, quad(memory.result, w.quads, 4), memory.g - memory.result, mirrors())
    with each_quad(w, memory.result):
        butterfly(w, quad(memory.dependent, w.quads, 4), mirrors())


def clear(w: TfraWriter) -> None:
    """Empty tables and sums; the measured sum of traction in the units of B^xy."""
    a = w.assembler
    a.move(Dest.Y, w.const(w.design.search.steps))
    a.move(Dest.SH, imm(-(2 + w.design.formats.vector_fraction)))
    w.multiply_all((R0, w.at("traction_sum")))
    w.shift(w.at("measured"), R0)
    w.points(p0=0)
    with a.loop(w.design.candidates):
        for table in w.map.tables:
            a.move(mem(table, 0, Post.UP if table == w.map.tables[-1] else Post.KEEP), NOTHING)
    for sum_ in ("b_z", "b_xy"):
        for what in ("start", "slope"):
            a.move(w.at(f"{sum_}_{what}"), NOTHING)


def terms(w: TfraWriter) -> None:
    """Enter every taxel's term of B^z and of B^xy at the candidate where it begins or ends.

    A term is max(0, x + k q) at candidate k, or S - x and -q for B^xy.  With v = x or -x, so that the term changes at
    the first candidate k with v - k |q| <= 0, the division (v + |q|) / |q| gives k, and its remainder the value of the
    term there.  F1: the sweep is over negative mu.
    """
    a, memory = w.assembler, w.map
    w.set_flag(1, w.at("negative"))
    a.move(Dest.SH, imm(1 - sweep_bits(w.design)))
    w.points(p0=0)
    _fetch_taxel(w)
    with a.loop(w.design.sensor.taxels):
        a.sub(R0, R0, R1, When.F1)
        a.act(Op.MUL, mem(memory.stress, 0, Post.UP))
        a.act(Op.MUL, R0)
        a.op(Op.ABS, R2, ZERO, R1)
        a.move(R4, PRODUCT)
        a.move(R3, PRODUCT)
        _enter_taxel(w)


def running_sums(w: TfraWriter) -> None:
    """B^z and |B^xy - measured| of every candidate, in the heights' tables; R5 = the smallest B^z."""
    a, (z_height, z_slope, xy_height, xy_slope) = w.assembler, w.map.tables
    a.move(R1, w.at("b_z_slope"))
    a.move(R0, w.at("b_z_start"))
    a.sub(R0, R0, R1)
    a.sub(R3, ZERO, w.at("b_xy_slope"))
    a.move(R2, w.at("b_xy_start"))
    a.sub(R2, R2, R3)
    a.sub(R2, R2, w.at("measured"))
    a.move(R5, w.huge())
    w.points(p0=0)
    with a.loop(w.design.candidates):
        a.add(R1, R1, mem(z_slope, 0))
        a.add(R0, R0, R1)
        a.sub(R0, R0, mem(z_height, 0))
        a.move(mem(z_height, 0), R0)
        a.add(R3, R3, mem(xy_slope, 0))
        a.add(R2, R2, R3)
        a.sub(R2, R2, mem(xy_height, 0))
        a.sign(0, R0, R5)
        a.move(R5, R0, When.F0)
        a.op(Op.ABS, mem(xy_height, 0, Post.UP), ZERO, R2)


def choose(w: TfraWriter) -> None:
    """R5 = the winner: the first candidate with the smallest B^xy among those within the tolerance of the least B^z.

    R0: limit of B^z; R1: smallest B^xy yet; R2: this candidate's, or R3, the largest word; R4: its number.
    """
    a, (z_sums, _, xy_sums, _), allowed = w.assembler, w.map.tables, tolerance(w.design)
    if allowed.any():
        a.move(R0, w.at("exponent"))
        a.move(isa.pointer(1), R0)
        a.nop()
        a.add(R5, R5, mem(w.map.constants(*allowed.tolist()), 1))
    a.move(R0, R5)
    a.move(R1, w.huge())
    a.move(R3, R1)
    a.move(R4, imm(0))
    w.points(p0=0)
    with a.loop(w.design.candidates):
        a.sign(0, R0, mem(z_sums, 0))
        a.move(R2, mem(xy_sums, 0, Post.UP))
        a.move(R2, R3, When.F0)
        a.sign(1, R2, R1)
        a.move(R1, R2, When.F1)
        a.move(R5, R4, When.F1)
        a.add(R4, R4, imm(1))


# One taxel


def _fetch_taxel(w: TfraWriter) -> None:
    """q to R1 with its sign in F0, and p to R0."""
    a = w.assembler
    a.op(Op.ADD, R1, ZERO, mem(w.map.result, 0), flag=1)
    a.move(R0, mem(w.map.p, 0))


def _enter_taxel(w: TfraWriter) -> None:
    """Enter a taxel: x in R3, a quarter of its S in R4, q in R1, |q| in R2; F0 says that q is negative.

    A division waits for its own result in every other instruction.  Independent instructions fill these pauses: in the
    first division (for B^z) the second one's dividend, in the second one (for B^xy) the entries for B^z.  The next
    taxel is fetched while the last pointer settles.
    """
    a, (z_height, z_slope, xy_height, xy_slope) = w.assembler, w.map.tables
    with a.deferred() as dividend_of_xy:  # R5 = S - x, R4 = the dividend for the term of B^xy
        a.add(R4, R4, R4)
        a.add(R4, R4, R4)
        a.sub(R5, R4, R3)
        a.move(R4, R5)
        a.sub(R4, ZERO, R5, When.F0)
        a.add(R4, R4, R2)
        a.add(R4, R4, imm(-1), When.NOT_F0)
    with a.deferred() as entry_of_z:  # of B^z at pointer 1, and what counts from the first candidate on
        a.add(w.at("b_z_start"), R3, w.at("b_z_start"), When.F0)
        a.add(mem(z_slope, 1), R2, mem(z_slope, 1))
        a.add(mem(z_height, 1), R0, mem(z_height, 1))
        a.add(w.at("b_z_slope"), R1, w.at("b_z_slope"), When.F0)
        a.add(w.at("b_xy_start"), R5, w.at("b_xy_start"), When.NOT_F0)
        a.add(w.at("b_xy_slope"), R2, w.at("b_xy_slope"), When.NOT_F0)
    a.add(R0, R2, R3, When.F0)
    a.sub(R0, R2, R3, When.NOT_F0)
    a.add(R0, R0, imm(-1), When.F0)
    _divide(w, R0, dividend_of_xy)
    a.add(R0, R0, imm(1), When.F0)
    a.move(isa.pointer(1), isa.K)
    _divide(w, R4, entry_of_z)
    a.add(R4, R4, imm(1), When.NOT_F0)
    a.move(isa.pointer(1), isa.K)
    _fetch_taxel(w)
    a.add(mem(xy_slope, 1), R2, mem(xy_slope, 1))
    a.add(mem(xy_height, 1), R4, mem(xy_height, 1))


def _divide(w: TfraWriter, word: isa.Operand, pauses: list[isa.Instruction]) -> None:
    """K = word / R2, word = the remainder; one of ``pauses`` after every step, and the rest of them at the end."""
    a, steps = w.assembler, sweep_bits(w.design)
    a.act(Op.SHIFT, R2)
    for number in range(steps):
        a.op(Op.DIV, word, word, FLOOR)
        for instruction in pauses[number : number + 1]:
            a.emit(instruction)
    for instruction in pauses[steps:]:
        a.emit(instruction)
