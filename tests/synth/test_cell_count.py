"""What is counted, by hand and against the RTLIL of modules and cores."""

from collections import Counter

import pytest
from amaranth import Cat, Const, Elaboratable, Module, Mux, Signal, signed
from amaranth.back import rtlil
from amaranth.hdl import Array, Fragment

from tests.marks import long
from tests.synth.rtlil import count as count_text
from tfra.codegen.verilog.emit import Top, to_rtlil
from tfra.families.hierarchy import block_of
from tfra.model.choices import FORMATS, SERIAL, Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.cell_count import CellCount, cell_counts, count


class Whole(Elaboratable):
    """``part`` as a block of a core."""

    def __init__(self, part: Elaboratable) -> None:
        self.part = part

    def elaborate(self, platform: object) -> Module:
        m, core = Module(), Module()
        core.submodules.part = self.part
        m.submodules.core = core
        return m


def both(part: Elaboratable) -> tuple[CellCount, CellCount]:
    """Counts of ``part``, a fresh one each: as they are made, and in its RTLIL."""
    ports = part.inputs
    found = count(Fragment.get(Whole(part), None))
    text = count_text(rtlil.convert(Whole(part), name="whole", ports=ports, emit_src=False))
    assert found["top"] == text["top"] == CellCount()
    return found["part"], text["part"]


class Odd(Elaboratable):
    """What hides in expressions: choices of words and places, signs, constants, both ways to write a part."""

    def __init__(self) -> None:
        self.inputs = Signal(signed(9)), Signal(5), Signal(signed(3))

    def elaborate(self, platform: object) -> Module:
        m = Module()
        a, b, s = self.inputs
        words = Array([Signal(6, name=f"word{number}") for number in range(3)])
        kept, flags = Signal(16), Signal(4)
        m.d.sync += [words[b[:2]].eq(a), flags.bit_select(b[:2], 1).eq(a.any())]
        m.d.comb += kept.eq(words[a[:2]] + (-a) + Mux(a, s, b) + a.bit_select(b, 4))
        with m.If((a < b) & (s != -2)):
            m.d.sync += flags[1:3].eq(kept.xor())
        with m.Elif(a >= 100):
            m.d.sync += [flags.eq(kept - s), words[0].eq((a << b[:2]) ^ s)]
        with m.Switch(b):
            with m.Case(3):
                m.d.sync += words[1].as_signed().eq(a * s)
            with m.Default():
                m.d.sync += Cat(words[2], flags[0]).eq(a * 5)
        return m


def test_every_expression() -> None:
    """By hand, too."""
    found, text = both(Odd())
    assert found == text
    assert found.registers == 3 * 6 + 4
    assert found.operators == {"add": 77, "shift": 40, "logic": 13, "reduce": 37, "mux": 71}
    assert sorted(found.multipliers) == [(9, 3), (9, 4)]


class Spare(Elaboratable):
    """Registers that no flip-flop is needed for, and their likes that one is needed for."""

    def __init__(self) -> None:
        self.inputs = Signal(8), Signal(8)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        a, b = self.inputs
        zero, one, twin = Signal(3), Signal(5, init=1), [Signal(8, name=f"twin{number}") for number in range(3)]
        other, late, chained = Signal(8, init=7), Signal(8), Signal(8)
        m.d.sync += [zero.eq((Const(0) << 2) + 0), one.eq(0), other.eq(a), chained.eq(late)]
        m.d.sync += [each.eq(a) for each in twin]
        with m.If(b[0]):
            m.d.sync += [zero.eq(0), late.eq(a)]
        return m


def test_registers_that_vanish() -> None:
    found, text = both(Spare())
    assert text.registers == 3 + 5 + 3 * 8 + 8 + 8 + 8
    assert found.registers == text.registers - 3 - 2 * 8


DESIGNS: dict[str, Design] = {
    name: TfraDesign(SensorArray(rows, columns, 4e-3, 2e-3, 3e-3), **others)
    for name, rows, columns, others in (
        ("parallel", 2, 2, {"architecture": Architecture(4, 2), "target": "ecp5"}),
        ("serial", 2, 3, {"architecture": SERIAL, "target": "ice40"}),
        ("loaded", 3, 4, {"architecture": Architecture(8, 4), "images": "load", "search": Search(7)}),
        ("wide", 3, 3, {"architecture": Architecture(4, 1), "formats": FORMATS["wide"]}),
        ("plain serial", 4, 4, {"architecture": SERIAL, "formats": FORMATS["wide"]}),
    )
}
SPARED = {"sweep": 9, "lanes": {"serial": 2 * 18, "plain serial": 24 + 2 * 48}, "product": {"plain serial": 38 + 25}}
"""Bits of registers that vanish: a queue's flag and counter, and two delays of what others delay; in lanes, operands
that all of them have; products' low digits where multipliers need none."""


@pytest.mark.parametrize("name", ["serial", *long("parallel", "loaded", "wide", "plain serial")])
def test_cores_as_their_text(name: str) -> None:
    """Block by block.  A constant that a wire brings shortens an operand in the text, by a bit or two."""
    design = DESIGNS[name]
    found, text = cell_counts(design), count_text(to_rtlil(Top(design), design.name))
    assert found.keys() == text.keys()
    for block, one in found.items():
        other = text[block]
        spared = SPARED.get(block, 0)
        assert other.registers - one.registers == (spared if isinstance(spared, int) else spared.get(name, 0)), block
        assert sorted(one.multipliers) == sorted(other.multipliers), block
        assert Counter(one.memories) == Counter(other.memories), block
        assert one.instances == other.instances, block
        for kind in ("add", "shift", "logic", "reduce", "mux"):
            assert one.operators[kind] == pytest.approx(other.operators[kind], abs=2), (block, kind)


def test_blocks_by_name() -> None:
    blocks = {
        "core.sweep.winner.z_TRELLIS_FF_Q_3": "sweep",
        "top.core.matvec.lane0": "matvec",
        "\\core.matvec": "matvec",
        "core": "top",
        "$nextpnr_1": "top",
        "score.matvec": "top",
    }
    assert {path: block_of(path) for path in blocks} == blocks
