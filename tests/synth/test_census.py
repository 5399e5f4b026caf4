"""What is counted in RTLIL, against a module that is counted by hand and a core whose parts are known."""

from __future__ import annotations

from collections import Counter

import pytest
from amaranth import Elaboratable, Instance, Module, Mux, Signal, signed, unsigned
from amaranth.back import rtlil
from amaranth.lib.memory import Memory as AmaranthMemory

from tfra.model.choices import Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.census import Census, Memory, block_of, census, count


class Part(Elaboratable):
    """One of everything."""

    def __init__(self) -> None:
        self.inputs = Signal(signed(12)), Signal(signed(12)), Signal(3)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        a, b, s = self.inputs
        total, product, kept = Signal(13), Signal(24), Signal(8)
        m.submodules.table = table = AmaranthMemory(shape=unsigned(9), depth=40, init=[1, 2, 3])
        m.submodules.store = store = AmaranthMemory(shape=unsigned(5), depth=20, init=[])
        read, other, write = store.read_port(), table.read_port(), store.write_port()
        m.submodules.cell = Instance("MULT18X18D", i_A0=a[0])
        m.d.sync += [total.eq(a + b), product.eq(a * b)]
        m.d.comb += [write.data.eq(a >> s), write.en.eq(read.data == other.data), read.addr.eq(Mux(s[0], a, b))]
        m.d.comb += [write.addr.eq((a ^ b) << 2), other.addr.eq(s)]
        with m.If(s[1]):
            m.d.sync += kept.eq(a)
        return m


class Whole(Elaboratable):
    """``Part`` as a block of a core."""

    def __init__(self) -> None:
        self.part = Part()

    def elaborate(self, platform: object) -> Module:
        m, core = Module(), Module()
        core.submodules.part = self.part
        m.submodules.core = core
        return m


def test_counts_of_a_module() -> None:
    whole = Whole()
    blocks = count(rtlil.convert(whole, name="whole", ports=whole.part.inputs, emit_src=False))
    found = blocks["part"]
    assert found.registers == 13 + 24 + 8
    assert found.multipliers == [(12, 12)]
    assert found.memories == [Memory(40, 9, 1, True), Memory(20, 5, 1, False)]
    assert found.instances == Counter({"MULT18X18D": 1})
    assert found.operators["logic"] == 12
    assert found.operators["shift"] == 12 * 3  # a >> s; << 2 is wiring
    assert found.operators["reduce"] == 9
    assert found.operators["add"] in (12, 13)
    assert found.operators["mux"] == 12 + 8  # Mux and the enable, not the reset
    assert blocks["top"] == Census()


@pytest.mark.parametrize(
    ("path", "block"),
    [
        ("core.sweep.winner.z_TRELLIS_FF_Q_3", "sweep"),
        ("top.core.matvec.lane0", "matvec"),
        ("\\core.matvec", "matvec"),
        ("core", "top"),
        ("$nextpnr_1", "top"),
        ("score.matvec", "top"),
    ],
)
def test_blocks_by_name(path: str, block: str) -> None:
    assert block_of(path) == block


@pytest.mark.long
def test_a_core() -> None:
    design = TfraDesign(SensorArray(2, 3, 4e-3, 2e-3, 3e-3), architecture=Architecture(4))
    blocks = census(design)
    assert {"normaliser", "matvec", "combine", "sweep", "scaling"} <= blocks.keys()
    coefficients = [memory for memory in blocks["matvec"].memories if memory.rom]
    lanes = len(blocks["matvec"].multipliers) + blocks["matvec"].instances["MULT18X18D"]
    assert lanes == 4
    assert sum(memory.reads for memory in coefficients) == 4
    more = census(TfraDesign(design.sensor, architecture=Architecture(8)))
    assert len(more["matvec"].multipliers) + more["matvec"].instances["MULT18X18D"] == 8
    assert more["gain"] == blocks["gain"]
