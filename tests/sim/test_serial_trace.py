"""A fault in the serial core's gateware is named at its instruction; an intact core shows none."""

from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from amaranth import Module

from tests.hdl.serial.designs import DESIGNS, LEARNED
from tfra.hdl.cores import as_serial
from tfra.hdl.serial import alu, core, datapath
from tfra.hdl.serial.core import SerialCore
from tfra.hdl.serial.isa import Op, Src
from tfra.hdl.serial.product import Product
from tfra.hdl.serial.trace import trace
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.sim.serial_trace import first_difference

DESIGN = DESIGNS["2×3"]
CODES = contact_codes(DESIGN, 1, seed=6)


@pytest.mark.parametrize("design", [DESIGN, LEARNED["2×2"]], ids=["TFRA", "learned"])
def test_an_intact_core(design: Design) -> None:
    assert first_difference(design, contact_codes(design, 2, seed=6)) is None


class WrongProduct(Product):
    """One too much."""

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.right = right = Product(len(self.a), len(self.b), len(self.o))
        m.d.comb += [
            right.a.eq(self.a),
            right.b.eq(self.b),
            right.start.eq(self.start),
            right.enable.eq(self.enable),
            self.o.eq(right.o + 1),
        ]
        return m


def test_a_wrong_product(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core, "Product", WrongProduct)
    found = first_difference(DESIGN, CODES)
    first = next(t for t in trace(as_serial(DESIGN), CODES) if t.step.instruction.source == Src.PRODUCT)
    assert found is not None
    assert (found.step, found.address) == (first, first.step.pc)
    assert str(found).split(": ")[0].endswith("centroids.centroids")
    assert "R0 = PRODUCT" in str(found)
    assert int(found.observed) == int(found.expected) + 1


@pytest.mark.parametrize(
    ("room", "name", "op", "stage"),
    [(alu, "saturate", Op.LIMIT, "scaling.resultant_words"), (datapath, "coarse", Op.SHIFT, "normaliser.normaliser")],
)
def test_a_wrong_operation(monkeypatch: pytest.MonkeyPatch, room: ModuleType, name: str, op: Op, stage: str) -> None:
    right = getattr(room, name)
    monkeypatch.setattr(room, name, lambda *args: ~right(*args))
    found = first_difference(DESIGN, CODES)
    first = next(t for t in trace(as_serial(DESIGN), CODES) if t.step.instruction.op == op)
    assert found is not None
    assert (found.step, found.step.stage) == (first, stage)


def test_a_wrong_instruction() -> None:
    serial = as_serial(DESIGN)
    instructions = list(serial.program.instructions)
    place = 40
    instructions[place] = instructions[place + 1]
    wrong = SerialCore(DESIGN, replace(serial.program, instructions=tuple(instructions)), serial.coefficients)
    found = first_difference(DESIGN, CODES, wrong)
    assert found is not None
    assert found.address == place
    assert "another instruction" in str(found)


def test_a_standstill() -> None:
    """A core that waits for more coefficients than there are."""
    serial = as_serial(DESIGN)
    waits = SerialCore(DESIGN, serial.program, np.concatenate([serial.coefficients] * 2))
    found = first_difference(DESIGN, CODES, waits)
    assert found is not None
    assert (found.address, found.observed) == (0, "a standstill")
