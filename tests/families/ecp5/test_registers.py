"""Flip-flops around block memories and multipliers move into them, and only those that may."""

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from amaranth import Module, Signal, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tests.families.ecp5.netlists import mapped
from tests.families.ecp5.test_copies import Lanes
from tests.marks import long
from tfra.families.ecp5 import prepare
from tfra.families.ecp5.registers import absorb


class Store(wiring.Component):
    """A memory of 36 bits with ``stages`` registers behind it; ``enabled``: they stand still at times."""

    def __init__(self, stages: int, enabled: bool = True, reset: bool = False) -> None:
        self._stages, self._enabled, self._reset = stages, enabled, reset
        super().__init__(
            {"address": In(9), "data": In(36), "write": In(1), "enable": In(1), "clear": In(1), "word": Out(36)}
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.memory = memory = Memory(shape=unsigned(36), depth=512, init=[])
        write, read = memory.write_port(), memory.read_port()
        m.d.comb += [
            write.addr.eq(self.address),
            write.data.eq(self.data),
            write.en.eq(self.write),
            read.addr.eq(self.address + 1),
            read.en.eq(1),
        ]
        word: Any = read.data
        for _ in range(self._stages):
            register = Signal(36, reset_less=True)
            with m.If(self.enable if self._enabled else 1):
                m.d.sync += register.eq(word)
            if self._reset:
                with m.If(self.clear):
                    m.d.sync += register.eq(0)
            word = register
        m.d.comb += self.word.eq(word)
        return m


class Times(wiring.Component):
    """A product with a register behind it and, if ``before``, one before each factor, which others may read."""

    def __init__(self, before: bool, shared: bool = False) -> None:
        self._before, self._shared = before, shared
        super().__init__({"a": In(signed(18)), "b": In(signed(18)), "product": Out(signed(36)), "too": Out(signed(18))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        a, b, product = Signal(signed(18)), Signal(signed(18)), Signal(signed(36), reset_less=True)
        for word, port in ((a, self.a), (b, self.b)):
            if self._before:
                register = Signal(signed(18), reset_less=True)
                m.d.sync += register.eq(port)
                m.d.comb += word.eq(register)
            else:
                m.d.comb += word.eq(port)
        m.d.sync += product.eq(a * b)
        m.d.comb += [self.product.eq(product), self.too.eq(a if self._shared else 0)]
        return m


def cells(block: wiring.Component, tmp_path: Path) -> tuple[int, list[dict[str, Any]], int]:
    """How many flip-flops moved into the one block, its cell, and the flip-flops that are left."""
    netlist = mapped(block, tmp_path)
    moved = absorb(netlist, "top")
    found = list(netlist["modules"]["top"]["cells"].values())
    hard = [cell for cell in found if cell["type"] in ("DP16KD", "MULT18X18D")]
    return moved, hard, sum(cell["type"] == "TRELLIS_FF" for cell in found)


@pytest.mark.parametrize(("stages", "left"), [*long((1, 0)), (2, 36)])
@pytest.mark.parametrize("enabled", [*long(False), True])
def test_the_output_register_of_a_memory(stages: int, left: int, enabled: bool, tmp_path: Path) -> None:
    moved, (memory,), flipflops = cells(Store(stages, enabled), tmp_path)
    assert (moved, flipflops) == (36, left)
    assert {memory["parameters"][f"REGMODE_{port}"] for port in "AB"} == {"OUTREG"}
    assert (memory["connections"]["OCEB"] == ["1"]) == (not enabled)
    assert memory["connections"]["OCEA"] == memory["connections"]["OCEB"]


@pytest.mark.parametrize("block", [*long(Store(0)), Store(1, reset=True)], ids=["none", "reset"])
def test_memories_without_a_register_of_their_own(block: Store, tmp_path: Path) -> None:
    moved, (memory,), _ = cells(block, tmp_path)
    assert moved == 0
    assert memory["parameters"]["REGMODE_B"] == "NOREG"


@pytest.mark.parametrize(
    ("block", "moved", "left", "before"),
    [
        *long((Times(before=True), 72, 0, True)),
        (Times(before=True, shared=True), 54, 18, True),  # a factor that others read stays as well
        (Times(before=False), 36, 0, False),
    ],
    ids=["both", "read by others", "none before"],
)
def test_registers_of_a_product(block: Times, moved: int, left: int, before: bool, tmp_path: Path) -> None:
    number, (product,), flipflops = cells(block, tmp_path)
    assert (number, flipflops) == (moved, left)
    registers = {name for name in ("INPUTA", "INPUTB", "OUTPUT") if f"REG_{name}_CLK" in product["parameters"]}
    assert registers == ({"INPUTA", "INPUTB", "OUTPUT"} if before else {"OUTPUT"})
    assert {product["parameters"][f"REG_{name}_CLK"] for name in registers} == {"CLK0"}
    assert product["connections"]["CE0"] == ["1"]


@pytest.mark.parametrize(("block", "changed", "sign"), [(Lanes(12), "LUT4", 1), (Times(True), "TRELLIS_FF", -1)])
def test_added_cells_are_counted(block: Any, changed: str, sign: int, tmp_path: Path) -> None:
    """Copies for lanes that share an enable, and a multiplier between registers."""
    netlist = mapped(block, tmp_path)
    kinds = [Counter(cell["type"] for cell in netlist["modules"]["top"]["cells"].values())]
    added = prepare(netlist, "top")
    kinds.append(Counter(cell["type"] for cell in netlist["modules"]["top"]["cells"].values()))
    assert all(kinds[1][kind] - kinds[0][kind] == added[kind] for kind in kinds[0] | kinds[1])
    assert sign * added[changed] > 0
