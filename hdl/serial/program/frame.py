"""The serial core's program: one frame of TFRA, phase by phase, in the order of :mod:`tfra.model.fixed.tfra.pipeline`.

A fact is a word whose sign says that it is true.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tfra.hdl.serial.isa import (
    FLOOR,
    IN,
    LIMITED,
    MUL_DELAY,
    NOTHING,
    PRODUCT,
    R0,
    R1,
    R2,
    R3,
    R4,
    R5,
    ZERO,
    Dest,
    Instruction,
    K,
    Left,
    Op,
    Operand,
    Post,
    T,
    When,
    imm,
    mem,
    pointer,
)
from tfra.hdl.serial.program.memory import operator_of, stride
from tfra.hdl.serial.program.routines import Routines
from tfra.hdl.serial.sizes import sweep_bits
from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.fixed.cordic import ANGLE_GUARD
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import gain_constants, normal_gain
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.fixed.scalars import scalar_fraction
from tfra.model.fixed.tfra.centroids import pitch_ratio
from tfra.model.fixed.tfra.sweep import tolerance
from tfra.model.fixed.widths import DIVISION_GUARD, MU_LIMIT, force_drop
from tfra.model.tfra import COEFFICIENT_LIMIT, Status

F0, NOT_F0, F1, NOT_F1 = When.F0, When.NOT_F0, When.F1, When.NOT_F1


@dataclass(frozen=True)
class Program:
    """``instructions``; ``memory``: first contents of the data memory, the lowest ``operands`` words of which the
    lanes read, too.

    Cycles: ``first`` from the instruction that takes a frame's last taxel to that of its first result word, ``last`` to
    that of its last one; ``interval`` from frame to frame; ``taxel`` from one to the next in a row.
    """

    instructions: tuple[Instruction, ...]
    memory: tuple[int, ...]
    operands: int
    first: int
    last: int
    interval: int
    taxel: int


def program(design: Design) -> Program:
    """The program of ``design``; raises ``ValueError`` when it does not fit the memories."""
    return _Frame(design).program()


class _Frame(Routines):
    def __init__(self, design: Design) -> None:
        super().__init__(design)
        self.fraction = scalar_fraction(design)
        self.bits = design.widths.division
        self.operand = design.formats.operand

    def program(self) -> Program:
        a = self.a
        a.move(self.at("counter"), NOTHING)
        start, before = len(a.program), a.cycles
        taken, taxel = self._intake()
        self._stress()
        self._direction()
        self._contact()
        self._residual()
        self._dependent()
        self._normal()
        self._sweep()
        self._choose()
        self._friction()
        self._force_operand()
        self._resultant()
        self._gain()
        self._phi()
        first = a.cycles - taken + 1  # behind the counter, which is fetched first
        self._header()
        self._forces()
        self._status()
        last = a.cycles - taken - 1
        a.jump(start)
        interval = a.cycles - before
        a.link()
        self.map.reserve(2)  # a product looks for a fifth parity behind its table
        memory = tuple(self.map.words)
        return Program(tuple(a.program), memory, self.map.operands, first, last, interval, taxel)

    def _set_flag(self, flag: int, word: Operand) -> None:
        self.a.op(Op.ADD, Dest.NONE, ZERO, word, flag=1 + flag)

    def _intake(self) -> tuple[int, int]:
        """Codes as they come, and their prefix sums: moments of compression (R1, R2) and traction (R3, R4); R5: the
        bits of the largest code, sign folded away; F0: it is below the contact threshold.

        Returns the cycle of the last one, and the cycles from one to the next of its row.
        """
        a, sensor, top = self.a, self.design.sensor, (1 << (self.design.adc.bits - 1)) - 1
        names = ("sum_c", "sum_t", "v_c", "v_t")
        for name in names:
            a.move(self.at(name), NOTHING)
        for register in (R1, R2, R3, R4, R5):
            a.move(register, imm(0))
        self.points(p0=self.map.stress)
        with a.loop(sensor.rows):
            with a.loop(sensor.columns):
                start = a.here
                a.move(R0, IN)
                a.move(mem(0, 0, Post.UP), R0)
                a.op(Op.LESS, R1, R1, R0)
                a.add(R2, R2, R1)
                a.op(Op.PLUS, R3, R3, R0)
                a.add(R4, R4, R3)
                a.op(Op.OR, R0, ZERO, R0)
                a.sign(0, R5, R0)
                a.move(R5, R0, F0)
                taxel, behind = a.here, a.here - start
            start = a.here
            a.add(self.at("sum_c"), R1, self.at("sum_c"))
            a.add(self.at("sum_t"), R3, self.at("sum_t"))
            for zone in "ct":
                a.move(R0, self.at(f"sum_{zone}"))
                a.add(self.at(f"v_{zone}"), R0, self.at(f"v_{zone}"))
            a.move(R1, imm(0))
            a.move(R3, imm(0))
            behind += a.here - start
        taken = a.cycles - behind
        a.move(self.at("u_c"), R2)
        a.move(self.at("u_t"), R4)
        a.move(R0, self.const(top - 1))
        a.sub(self.at("input_saturated"), R0, R5)
        a.sign(0, R5, self.const(self.design.adc.threshold))
        self.length(R5, R5)
        return taken, taxel

    def _stress(self) -> None:
        """Normalise the frame, and fold it into d = b; F0 says that it stays below the contact threshold."""
        a, top, design = self.a, self.design.adc.bits - 1, self.design
        a.move(R0, imm(top))
        a.sub(R0, R0, R5)
        a.move(self.at("exponent"), R0)
        a.sub(Dest.SH, R5, imm(top))
        a.move(R1, self.at("sum_c"))
        a.add(R1, R1, self.at("sum_t"))
        self.shift(self.at("magnitude"), R1)
        self.shift(self.at("traction_sum"), self.at("sum_t"))
        a.sub(R2, ZERO, self.at("sum_t"))
        a.sub(R1, ZERO, self.at("sum_c"), NOT_F0)  # else the sum of magnitudes: not negative, no contact
        a.move(self.at("contact"), R1)
        a.op(Op.AND, self.at("regular"), R1, R2)
        a.sub(Dest.SH, R5, imm(top + design.formats.vector_fraction))
        self.points(p0=self.map.stress)
        with a.loop(design.sensor.taxels):
            a.act(Op.SHIFT, mem(0, 0))
            a.rounded(mem(0, 0, Post.UP))
        self._over_quads(self.map.stress, lambda: self.butterfly(self.mirrors(), self.quad(self.map.d, 4)))

    def _over_quads(self, taxels: int, body: Callable[[], None]) -> None:
        """Run ``body`` for every quad: pointers 0 to 3 at the mirror taxels of a map, pointer 4 at the quad."""
        self.start_mirrors(taxels)
        self.points(p4=0)
        with self.a.loop(self.design.quad_rows):
            with self.a.loop(self.design.quad_columns):
                body()
            self.next_mirrors()

    def _direction(self) -> None:
        """cos and sin of the tangential force, and what is swept."""
        a = self.a
        a.move(Dest.Y, self.at("sum_c"))
        self.multiply_all((R0, self.at("u_t")), (R1, self.at("v_t")))
        a.move(Dest.Y, self.at("sum_t"))
        self.multiply_all((R2, self.at("u_c")), (R3, self.at("v_c")))
        a.sub(R0, R0, R2)
        a.sub(R1, R1, R3)
        self.normalise([R0, R1], self.bits, self.at("scratch"))
        for word, ratio in zip((R0, R1), pitch_ratio(self.design), strict=True):
            if ratio > 1:
                a.move(Dest.Y, self.const(ratio))
                self.multiply_all((word, word))
        a.op(Op.ABS, R2, ZERO, R0)
        a.op(Op.ABS, R3, ZERO, R1)
        a.op(Op.SUB, R4, R2, R3, flag=1)
        a.move(self.at("sweep_y"), R4)
        a.move(R4, R0)
        a.move(R4, R1, F0)
        a.move(self.at("negative"), R4)
        a.add(R2, R2, R3)
        a.add(R2, R2, imm(-1))
        a.move(self.at("no_direction"), R2)
        self.normalise([R0, R1], self.operand, self.at("scratch"))
        self._set_flag(0, self.at("no_direction"))
        a.move(R0, self.const((1 << (self.operand - 1)) - 1), F0)
        a.move(self.at("cos"), R0)
        a.move(self.at("sin"), R1)

    def _contact(self) -> None:
        """n = the compressive part of C33^-1 b, folded, as multiplier words."""
        a, result, bits = self.a, self.map.result, self.at("bits", 4)
        self.fill(self.map.d, self.map.operand, bits)
        self.points(p2=result)
        self.product("c33_inv", self.map.operand, bits)
        self.points(p2=self.map.sums_b)
        self.product("sums_b", self.map.operand, bits)
        self._set_flag(1, self.at("regular"))
        a.move(Dest.SH, imm(2))
        self.points(p4=0)
        taxels = (R1, R3, R4, R0)
        with a.loop(self.q):
            self.butterfly(self.quad(result, 4, up=False), taxels)
            for word in taxels:
                self.round_shift(word, word)
            for word in taxels:
                a.op(Op.LESS, word, ZERO, word, F1)
                a.sub(word, ZERO, word, NOT_F1)
            self.fold(taxels, (R2, R5), self.quad(result, 4))
        self.fill(result, self.map.weights, self.at("bits_n", 4))

    def _residual(self) -> None:
        """g = C33 n, d = b + g, the tangential residuals by the part they play in the sweep, and the other sums."""
        a, places, weights, bits = self.a, self.map, self.map.weights, self.at("bits_n", 4)
        self.points(p2=places.g)
        self.product("c33", weights, bits)
        self._set_flag(0, self.at("sweep_y"))
        for name, here, there in (("c31", F0, NOT_F0), ("c32", NOT_F0, F0)):
            a.move(pointer(2), self.address(places.dependent), here)
            a.move(pointer(2), self.address(places.independent), there)
            self.product(name, weights, bits)
        self.points(p2=places.sums_n)
        self.product("sums_n", weights, bits)
        self.points(p0=0)
        with a.loop(4 * self.q):
            a.move(R0, mem(places.g, 0))
            a.add(mem(places.d, 0, Post.UP), R0, mem(places.d, 0, Post.UP))

    def _dependent(self) -> None:
        """mu_dep = alpha + beta mu_ind."""
        a = self.a
        b, n = self._sums_b, self._sums_n
        for quad, parity in ((0, OX), (0, OY), (2, EE)):
            a.move(R0, b(parity))
            a.add(n(quad, parity), R0, n(quad, parity))
        self._normalise_sums()
        registers = (R0, R1, R2), (R3, R4, R5)
        for row, name in enumerate(("sin", "cos")):
            a.move(Dest.Y, self.at(name))
            self.multiply_all(*zip(registers[row], self._row(row), strict=True))
        for first, second in zip(*registers, strict=True):
            a.sub(first, first, second)
        self._set_flag(0, self.at("sweep_y"))
        a.sub(R3, ZERO, R2)
        a.move(R4, R1)
        a.move(R4, R3, F0)
        a.move(R3, R1, F0)
        a.sub(R0, ZERO, R0, F0)
        self.normalise([R0, R4, R3], self.bits, self.at("scratch"))
        a.move(Dest.SH, imm(-(int(COEFFICIENT_LIMIT).bit_length() - 1)))
        a.op(Op.ABS, R1, ZERO, R3)
        self.shift(R1, R1)
        for name, word in (("numerator0", R0), ("numerator1", R4), ("denominator", R3)):
            a.move(self.at(name), word)
        a.op(Op.ABS, R5, ZERO, R4)
        a.sub(R5, R5, R1)
        a.op(Op.ABS, R2, ZERO, R0)
        a.sub(R2, R2, R1)
        a.op(Op.AND, R2, R2, R5)
        a.move(self.at("determined"), R2)
        a.op(Op.AND, R2, R2, self.at("regular"))
        a.op(Op.ADD, Dest.NONE, ZERO, R2, flag=2)
        for name, number in (("alpha", 0), ("beta", 1)):
            a.op(Op.ABS, R0, ZERO, self.at(f"numerator{number}"))
            a.op(Op.ABS, R1, ZERO, self.at("denominator"))
            self.divide(self.fraction)
            self._set_flag(0, self.at("denominator"))
            a.move(R2, self.at(f"numerator{number}"))
            a.sub(R2, ZERO, R2, F0)
            self._set_flag(0, R2)
            a.sub(R0, ZERO, R0, F0)
            a.move(R0, NOTHING, NOT_F1)
            a.move(self.at(name), R0)

    def _sums_b(self, parity: int) -> Operand:
        return mem(self.map.sums_b + parity * stride(self.design, operator_of(self.design, "sums_b")))

    def _sums_n(self, quad: int, parity: int) -> Operand:
        return mem(self.map.sums_n + parity * stride(self.design, operator_of(self.design, "sums_n")) + quad)

    def _row(self, row: int) -> tuple[Operand, Operand, Operand]:
        """A_p0, A_px and A_py of axis p."""
        n = self._sums_n
        return (
            (n(0, OX), n(0, EE), n(0, OO)),
            (n(0, OY), n(1, OO), n(1, EE)),
            (n(2, EE), n(1, OX), n(1, OY)),
        )[row]

    def _normalise_sums(self) -> None:
        """All A_pq as operand words, and the bits they need; words between them are zero."""
        a, start = self.a, self.map.sums_n
        count = 4 * stride(self.design, operator_of(self.design, "sums_n"))
        self.points(p0=start)
        a.move(R5, NOTHING)
        with a.loop(count):
            a.op(Op.OR, R5, R5, mem(0, 0, Post.UP))
        self.length(R5, R5)
        a.move(self.at("sums_bits"), R5)
        a.sub(Dest.SH, R5, imm(self.operand - 1))
        self.points(p0=start)
        with a.loop(count):
            a.act(Op.SHIFT, mem(0, 0))
            a.op(Op.FIT, mem(0, 0, Post.UP), T, NOTHING)

    def _normal(self) -> None:
        """e0 in d, e1's words in the operand; then p and q, taxel by taxel."""
        a, places, bits = self.a, self.map, self.at("bits", 4)
        self.fill(places.dependent, places.operand, bits)
        for name, vector in (("alpha", places.d), ("beta", places.independent)):
            a.move(Dest.Y, self.at(name))
            self.combine(vector, places.operand, bits)
        for vector, result in ((places.d, places.result), (places.independent, places.dependent)):
            self.fill(vector, places.operand, bits)
            self.points(p2=result)
            self.product("normal", places.operand, bits)
        less = places.g - places.result
        self._over_quads(places.p, lambda: self.butterfly(self.quad(places.result, 4), self.mirrors(), less))
        self._over_quads(places.result, lambda: self.butterfly(self.quad(places.dependent, 4), self.mirrors()))

    def _sweep(self) -> None:
        """B^z and B^xy of all candidates, from the one candidate where each taxel's part begins or ends.

        With w = x or -x, so that a taxel's term changes at the first candidate k with w - k |q| <= 0, the division
        (w + |q|) / |q| gives k, and its remainder what the term is worth there.
        """
        a, places, tables = self.a, self.map, self.map.tables
        steps, bits = self.design.search.steps, sweep_bits(self.design)
        a.move(Dest.Y, self.const(steps))
        a.move(Dest.SH, imm(-(2 + self.design.formats.vector_fraction)))
        self.multiply_all((R0, self.at("traction_sum")))
        self.shift(self.at("measured"), R0)
        self.points(p0=0)
        with a.loop(self.design.candidates):
            for number, table in enumerate(tables):
                a.move(mem(table, 0, Post.UP if number == 3 else Post.KEEP), NOTHING)
        sums = [[self.at(f"{name}_{what}") for what in ("start", "slope")] for name in ("b_z", "b_xy")]
        for word in (*sums[0], *sums[1]):
            a.move(word, NOTHING)
        self._set_flag(1, self.at("negative"))
        a.move(Dest.SH, imm(1 - bits))
        self.points(p0=0)
        self._next_taxel()
        with a.loop(self.design.sensor.taxels):
            a.sub(R0, R0, R1, F1)
            a.act(Op.MUL, mem(places.stress, 0, Post.UP))
            a.act(Op.MUL, R0)
            a.op(Op.ABS, R2, ZERO, R1)
            a.move(R4, PRODUCT)
            a.move(R3, PRODUCT)
            self._taxel_parts(sums)
        self._sum_up(sums)

    def _next_taxel(self) -> None:
        """q to R1 with its sign in F0, and p to R0."""
        self.a.op(Op.ADD, R1, ZERO, mem(self.map.result, 0), flag=1)
        self.a.move(R0, mem(self.map.p, 0))

    def _taxel_parts(self, sums: list[list[Operand]]) -> None:
        """Enter a taxel: x in R3, a quarter of its S in R4, q in R1, |q| in R2; F0 says that q is negative.

        The two divisions wait for each other's results, and fill these pauses with each other's rest; the next taxel
        is fetched while the last pointer settles.
        """
        a, tables = self.a, self.map.tables
        a.add(R0, R2, R3, F0)
        a.sub(R0, R2, R3, NOT_F0)
        a.add(R0, R0, imm(-1), F0)
        self._divide_into(
            R0,
            lambda: a.add(R4, R4, R4),
            lambda: a.add(R4, R4, R4),
            lambda: a.sub(R5, R4, R3),  # S - x
            lambda: a.move(R4, R5),
            lambda: a.sub(R4, ZERO, R5, F0),
            lambda: a.add(R4, R4, R2),
            lambda: a.add(R4, R4, imm(-1), NOT_F0),
        )
        a.add(R0, R0, imm(1), F0)
        a.move(pointer(1), K)
        self._divide_into(
            R4,
            lambda: a.add(sums[0][0], R3, sums[0][0], F0),
            lambda: a.add(mem(tables[1], 1), R2, mem(tables[1], 1)),
            lambda: a.add(mem(tables[0], 1), R0, mem(tables[0], 1)),
            lambda: a.add(sums[0][1], R1, sums[0][1], F0),
            lambda: a.add(sums[1][0], R5, sums[1][0], NOT_F0),
            lambda: a.add(sums[1][1], R2, sums[1][1], NOT_F0),
        )
        a.add(R4, R4, imm(1), NOT_F0)
        a.move(pointer(1), K)
        self._next_taxel()
        a.add(mem(tables[3], 1), R2, mem(tables[3], 1))
        a.add(mem(tables[2], 1), R4, mem(tables[2], 1))

    def _divide_into(self, word: Operand, *pauses: Callable[[], None]) -> None:
        """K = word / R2, word = the remainder; instructions of ``pauses`` stand behind the divisions' steps."""
        a = self.a
        a.act(Op.SHIFT, R2)
        waiting = list(pauses)
        for _ in range(sweep_bits(self.design)):
            a.op(Op.DIV, word, word, FLOOR)
            if waiting:
                waiting.pop(0)()
        for pause in waiting:
            pause()

    def _sum_up(self, sums: list[list[Operand]]) -> None:
        """Running sums: B^z and B^xy of every candidate in the first and third table; R5 = the smallest B^z."""
        a, tables = self.a, self.map.tables
        a.move(R1, sums[0][1])
        a.move(R0, sums[0][0])
        a.sub(R0, R0, R1)
        a.sub(R3, ZERO, sums[1][1])
        a.move(R2, sums[1][0])
        a.sub(R2, R2, R3)
        a.sub(R2, R2, self.at("measured"))
        a.move(R5, self._huge())
        self.points(p0=0)
        with a.loop(self.design.candidates):
            a.add(R1, R1, mem(tables[1], 0))
            a.add(R0, R0, R1)
            a.sub(R0, R0, mem(tables[0], 0))
            a.move(mem(tables[0], 0), R0)
            a.add(R3, R3, mem(tables[3], 0))
            a.add(R2, R2, R3)
            a.sub(R2, R2, mem(tables[2], 0))
            a.sign(0, R0, R5)
            a.move(R5, R0, F0)
            a.op(Op.ABS, mem(tables[2], 0, Post.UP), ZERO, R2)

    def _huge(self) -> Operand:
        return self.const((1 << (self.sizes.word - 1)) - 1)

    def _choose(self) -> None:
        """R5 = the first candidate with the smallest B^xy among those within the tolerance of the smallest B^z."""
        a, tables, allowed = self.a, self.map.tables, tolerance(self.design)
        if allowed.any():
            a.move(R0, self.at("exponent"))
            a.move(pointer(1), R0)
            a.nop()
            a.add(R5, R5, mem(self.map.constants(*allowed.tolist()), 1))
        a.move(R0, R5)
        a.move(R1, self._huge())
        a.move(R3, R1)
        a.move(R4, imm(0))
        self.points(p0=0)
        with a.loop(self.design.candidates):
            a.sign(0, R0, mem(tables[0], 0))
            a.move(R2, mem(tables[2], 0, Post.UP))
            a.move(R2, R3, F0)
            a.sign(1, R2, R1)
            a.move(R1, R2, F1)
            a.move(R5, R4, F1)
            a.add(R4, R4, imm(1))

    def _friction(self) -> None:
        """Index, mu_ind and mu_dep of the winner."""
        a, top = self.a, 1 << (self.operand - 1)
        self._set_flag(1, self.at("regular"))
        a.move(R5, NOTHING, NOT_F1)
        a.move(self.at("sweep_index"), R5)
        self._set_flag(0, self.at("negative"))
        a.move(R1, self.const(self.design.search.steps))
        a.move(R0, R5)
        a.sub(R0, R1, R5, F0)
        self.divide(self.fraction)
        a.sub(R0, ZERO, R0, F0)
        a.move(R0, NOTHING, NOT_F1)
        a.move(self.at("mu_ind"), R0)
        a.move(Dest.Y, R0)
        a.act(Op.MUL, self.at("beta"))
        a.move(Dest.SH, imm(self.fraction))
        a.nop(MUL_DELAY - 2)
        a.act(Op.SHIFT, PRODUCT)
        a.add(R2, T, self.at("alpha"))
        self.least(R2, top - 1)
        a.sign(0, R2, self.const(-top))
        a.move(R2, self.const(-top), F0)
        a.op(Op.ABS, R3, ZERO, R2)
        a.move(R4, self.const(1 << self.fraction))
        a.sub(R4, R4, R3)
        a.move(self.at("out_of_range"), R4)
        self._set_flag(0, self.at("sweep_y"))
        a.move(R1, R2)
        a.move(R1, R0, F0)
        a.move(R0, R2, F0)
        a.move(self.at("mu_x"), R0)
        a.move(self.at("mu_y"), R1)

    def _force_operand(self) -> None:
        """d = e0 + mu_ind e1 as multiplier words."""
        bits = self.at("bits", 4)
        self.a.move(Dest.Y, self.at("mu_ind"))
        self.combine(self.map.d, self.map.operand, bits)
        self.fill(self.map.d, self.map.operand, bits)

    def _resultant(self) -> None:
        """F* from the sums; F_x = F_y = 0 where nothing is swept."""
        a, total = self.a, self.map.scalar("total", 3)
        registers = (R0, R1, R2), (R3, R4, R5)
        for number, (name, words) in enumerate(zip(("mu_x", "mu_y"), registers, strict=True), 1):
            a.move(Dest.Y, self.at(name))
            self.multiply_all(*((word, self._row(row)[number]) for row, word in enumerate(words)))
        a.move(Dest.SH, imm(-self.fraction))
        self._set_flag(1, self.at("regular"))
        for row, (first, second) in enumerate(zip(*registers, strict=True)):
            a.add(first, first, second)
            a.act(Op.SHIFT, self._row(row)[0])
            a.add(first, first, FLOOR)
            if row < 2:
                a.move(first, NOTHING, NOT_F1)
            a.move(mem(total + row), first)
        self.normalise([mem(total + row) for row in range(3)], self.bits, self.at("scratch"))
        a.move(R0, self.const(self.operand - 1 + self.fraction + self.bits - 1))
        a.sub(R0, R0, self.at("sums_bits"))
        a.sub(R0, R0, self.at("scratch"))
        a.move(self.at("total_exponent"), R0)

    def _gain(self) -> None:
        """|F*|, mu, and the factor of the forces: mantissa and shifts."""
        a, operand, bits = self.a, self.operand, self.bits
        total, (first, second) = self.map.scalar("total", 3), gain_constants(self.design)
        a.op(Op.ABS, R0, ZERO, mem(total))
        a.op(Op.ABS, R1, ZERO, mem(total + 1))
        self.cordic()
        a.move(self.at("tangential"), R0)
        a.move(Dest.Y, self.const(first))
        a.op(Op.ABS, R1, ZERO, mem(total + 2))
        a.act(Op.MUL, R1)
        a.move(Dest.SH, imm(operand - 2))
        a.nop(MUL_DELAY - 2)
        self.shift(R1, PRODUCT)
        a.move(self.at("normal"), R1)
        self.cordic()
        a.move(self.at("modulus"), R0)
        a.move(Dest.Y, self.const(second))
        self.multiply_all((R1, self.at("magnitude")))
        self.length(R2, R1)
        self.length(R3, R0)
        a.move(R4, self.const(2 * operand - 4))
        a.add(R4, R4, R3)
        a.sub(R4, R4, R2)
        a.sub(Dest.SH, R2, imm(bits))
        a.sub(R4, R4, self.at("total_exponent"))
        a.act(Op.SHIFT, R1)
        a.sub(Dest.SH, R3, imm(bits))
        a.move(R0, FLOOR)
        self.shift(R1, self.at("modulus"))
        self.divide(operand - 1)
        longest, (mantissa, exponent) = (1 << operand) - 1, normal_gain(self.design)
        self.least(R0, longest)
        a.op(Op.SUB, R5, ZERO, self.at("modulus"), flag=1)
        a.move(R0, self.const(longest), NOT_F0)
        self._set_flag(1, self.at("regular"))
        a.move(R0, self.const(mantissa), NOT_F1)
        a.move(R4, self.const(exponent), NOT_F1)
        self._factors(R0)
        self._shifts()
        self._mu()

    def _factors(self, mantissa: Operand) -> None:
        """The mantissa where a frame keeps its tangential, or normal, forces; zero elsewhere."""
        a = self.a
        self._set_flag(0, self.at("contact"))
        a.move(mantissa, NOTHING, NOT_F0)
        a.move(self.at("normal_factor"), mantissa)
        a.move(mantissa, NOTHING, NOT_F1)
        a.move(self.at("tangential_factor"), mantissa)

    def _shifts(self) -> None:
        """Shifts from the exponent in R4; R5, negative if the modulus is not zero, collects what is as it should be."""
        a, grid = self.a, self.design.formats.force_fraction
        a.move(Dest.SH, imm(-(MU_LIMIT.bit_length() - 1)))
        a.move(R3, self.at("normal"))
        self.shift(R3, R3)
        a.move(R2, self.at("tangential"))
        a.sub(R2, R2, R3)
        a.move(self.at("bounded"), R2)
        a.op(Op.AND, R5, R5, R2)
        a.move(R5, imm(-1), NOT_F1)
        a.add(R0, R4, self.const(2 - force_drop(self.design) - grid))
        a.add(R1, R4, self.at("total_exponent"))
        a.add(R1, R1, self.const(-grid))
        for name, word in (("force_shift", R0), ("resultant_shift", R1)):
            a.move(R2, imm(-1))
            a.sub(R2, R2, word)
            a.op(Op.PLUS, word, ZERO, word)
            a.op(Op.AND, R5, R5, R2)
            a.move(self.at(name), word)
        a.move(self.at("limits_kept"), R5)

    def _mu(self) -> None:
        """mu = tangential / normal, limited; F1 says that the frame is regular."""
        a, top = self.a, (1 << (self.operand - 1)) - 1
        a.move(R0, self.at("tangential"))
        a.move(R1, self.at("normal"))
        self.divide(self.fraction)
        self.least(R0, top)
        self._set_flag(0, self.at("bounded"))
        a.move(R0, self.const(top), NOT_F0)
        a.move(R0, NOTHING, NOT_F1)
        a.move(self.at("mu"), R0)

    def _phi(self) -> None:
        """The direction's angle."""
        a = self.a
        a.move(Dest.SH, imm(-DIVISION_GUARD))
        a.move(R2, self.const(1 << (ANGLE_GUARD - 1)))
        self.shift(R0, self.at("cos"))
        self.shift(R1, self.at("sin"))
        self._set_flag(0, R0)
        a.move(R2, self.const((1 << (ANGLE_GUARD - 1)) + (1 << (self.operand + ANGLE_GUARD - 1))), F0)
        a.sub(R0, ZERO, R0, F0)
        a.sub(R1, ZERO, R1, F0)
        self.cordic()
        a.move(Dest.SH, imm(ANGLE_GUARD))
        self._set_flag(1, self.at("regular"))
        self.shift(R2, R2)
        a.op(Op.AND, R2, R2, self.const((1 << self.operand) - 1))
        a.move(R2, NOTHING, NOT_F1)
        a.move(self.at("phi"), R2)

    def _header(self) -> None:
        """Counter, exponent, index, phi, mu and the resultant."""
        a, total = self.a, self.map.scalar("total", 3)
        a.move(R0, self.at("counter"))
        a.move(Dest.OUT, R0)
        a.add(R0, R0, imm(1))
        a.op(Op.AND, R0, R0, self.const((1 << COUNTER_BITS) - 1))
        a.move(self.at("counter"), R0)
        for name in ("exponent", "sweep_index", "phi", "mu", "mu_x", "mu_y"):
            a.move(Dest.OUT, self.at(name))
        a.move(Dest.SH, self.at("resultant_shift"))
        for row, (word, factor) in enumerate(zip((R0, R1, R2), ("tangential", "tangential", "normal"), strict=True)):
            a.move(Dest.Y, self.at(f"{factor}_factor"))
            a.act(Op.MUL, mem(total + row))
            a.nop(MUL_DELAY - 1)
            self.round_shift(word, PRODUCT)
        for word in (R0, R1, R2):
            a.op(Op.LIMIT, Dest.OUT, ZERO, word)

    def _forces(self) -> None:
        """The three planes of forces: f = A-dagger d + mu n, unfolded and scaled."""
        a, places = self.a, self.map
        for axis, (scalar, factor) in enumerate((("mu_x", "tangential"), ("mu_y", "tangential"), (None, "normal"))):
            self.points(p2=places.result)
            self.product(f"pinv{axis + 1}", places.operand, self.at("bits", 4))
            a.move(Dest.Y, self.at(scalar) if scalar else self.const(-1 << self.fraction))
            a.move(R5, self.at(f"{factor}_factor"))
            a.move(self.at("factor"), R5)
            a.call("plane", self._plane)

    def _plane(self) -> None:
        """Add Y times n to A-dagger d, and send the plane."""
        a, places, taxels = self.a, self.map, (R1, R3, R4, R0)
        self.points(p0=places.weights, p1=places.result, p2=self.at("bits_n", 4).immediate)
        self.add_scaled()
        a.move(Dest.SH, self.const(force_drop(self.design)))

        def unfold() -> None:
            self.butterfly(self.quad(places.result, 4), taxels)
            for taxel, place in zip(taxels, self.mirrors(), strict=True):
                self.round_shift(place, taxel)

        self._over_quads(places.d, unfold)
        self.points(p0=places.d)
        a.move(Dest.Y, self.at("factor"))
        a.move(Dest.SH, self.at("force_shift"))
        a.act(Op.MUL, mem(0, 0, Post.UP))
        a.nop(MUL_DELAY - 2)
        a.act(Op.MUL, mem(0, 0, Post.UP))
        a.act(Op.SHIFT, PRODUCT)
        a.rounded(R0)
        with a.loop(self.design.sensor.taxels - 1):
            a.act(Op.MUL, mem(0, 0, Post.UP))
            a.act(Op.SHIFT, PRODUCT)
            a.op(Op.LIMIT, Dest.OUT, ZERO, R0)
            a.rounded(R0)
        a.op(Op.LIMIT, Dest.OUT, ZERO, R0)

    def _status(self) -> None:
        """What was special about the frame."""
        a = self.a
        self._set_flag(0, self.at("contact"))
        self._set_flag(1, self.at("regular"))
        a.move(R0, imm(Status.NO_CONTACT))
        a.move(R0, imm(Status.COMPRESSION_ONLY), F0)
        a.move(R0, NOTHING, F1)
        self._flag_status(Status.NO_DIRECTION, ZERO, self.at("no_direction"), F1)
        a.move(R1, imm(-1))
        self._flag_status(Status.VANISHING_DENOMINATOR, R1, self.at("determined"), F1)
        self._flag_status(Status.DEPENDENT_OUT_OF_RANGE, ZERO, self.at("out_of_range"), F1)
        self._flag_status(Status.INPUT_SATURATED, ZERO, self.at("input_saturated"))
        a.move(R1, imm(-1))
        a.sub(R1, R1, self.at("limits_kept"))
        a.op(Op.AND, Dest.NONE, R1, self.at("contact"), flag=1)
        a.move(R1, LIMITED)
        a.move(R1, imm(-1), F0)
        self._flag_status(Status.OUTPUT_SATURATED, ZERO, R1)
        a.move(Dest.LAST, R0)

    def _flag_status(self, status: Status, left: Operand | Left, right: Operand, when: When = When.ALWAYS) -> None:
        """Add ``status`` to R0 if left - right, or right alone, is a fact that holds, and ``when``, F1, does."""
        a = self.a
        a.op(Op.ADD if left == ZERO else Op.SUB, Dest.NONE, left, right, flag=1)
        a.move(R1, NOTHING)
        a.move(R1, imm(status), F0)
        a.add(R0, R0, R1, when)
