"""A serial core in all simulators and as gates; a fault in its gateware is named at its instruction."""

from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tests.hdl.serial.designs import DESIGNS, LEARNED
from tests.marks import long
from tfra.hdl.cores import as_serial, microarchitecture
from tfra.hdl.serial import alu, datapath
from tfra.hdl.serial.core import SerialCore
from tfra.hdl.serial.isa import Op
from tfra.hdl.serial.trace import trace
from tfra.model.choices import SERIAL, Adc, Formats, Search
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.sensor import SensorArray
from tfra.sim.run import simulate
from tfra.sim.serial_trace import first_difference
from tfra.sim.verify import verify
from tfra.synth.gates import synthesised

DESIGN = TfraDesign(
    SensorArray(4, 4, 4e-3, 2.5e-3, 3e-3),
    name="serial",
    adc=Adc(8),
    search=Search(2),
    formats=Formats("short", 10, 10, 4, 3),
    architecture=SERIAL,
)
FRAMES = 5
"""The first pattern of stalls gets two of them, which show the interval."""


@pytest.fixture(autouse=True)
def cache(builds: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TFRA_CACHE", str(builds))
    return builds


@pytest.mark.long
@pytest.mark.parametrize(
    ("design", "target"),
    [(DESIGN, "portable"), (DESIGN, "ice40"), (replace(LEARNED["2×3, forces"], name="learned"), "ice40")],
)
def test_verify(design: Design, target: str) -> None:
    """Words under all stalls, and the timing as stated; the coefficients in a model of the target's memories."""
    frames = contact_codes(design, FRAMES, 1) * design.adc.lsb
    found = verify(replace(design, target=target), frames, "icarus", random=0)
    stated = microarchitecture(design)
    assert found.passed
    assert (found.timing.latency, found.timing.interval) == (stated.latency, stated.initiation_interval)


def test_in_amaranth() -> None:
    codes = contact_codes(DESIGN, 1, 2)
    run = simulate(DESIGN, codes, "amaranth", 1, "random", "bursts", expected=FixedTfra(DESIGN)(codes).words)
    assert (run.compared, run.mismatches) == (run.words.size, 0)


@pytest.mark.long
def test_gates(cache: Path) -> None:
    """A smaller core, since gates run at some hundred cycles a second."""
    design = replace(DESIGN, sensor=SensorArray(2, 2, 4e-3, 4e-3, 3e-3), adc=Adc(6), search=Search(1), target="ice40")
    codes = contact_codes(design, 1, 1)
    core = synthesised(design, "ice40", cache)
    run = simulate(design, codes, "icarus", expected=FixedTfra(design)(codes).words, core=core)
    assert (run.compared, run.mismatches) == (run.words.size, 0)
    assert run.latency[0] == core.sidecar["latency_cycles"]["first_word"]


TRACED = DESIGNS["2×3"]
CODES = contact_codes(TRACED, 1, seed=6)


@pytest.mark.parametrize("design", [*long(TRACED), LEARNED["2×2"]], ids=["TFRA", "learned"])
def test_an_intact_core(design: Design) -> None:
    assert first_difference(design, contact_codes(design, 2, seed=6)) is None


@pytest.mark.parametrize(
    ("unit", "name", "op", "stage"),
    [(alu, "saturate", Op.LIMIT, "scaling.resultant_words"), (datapath, "coarse", Op.SHIFT, "normaliser.normaliser")],
)
def test_a_wrong_operation(monkeypatch: pytest.MonkeyPatch, unit: ModuleType, name: str, op: Op, stage: str) -> None:
    right = getattr(unit, name)
    monkeypatch.setattr(unit, name, lambda *args: ~right(*args))
    found = first_difference(TRACED, CODES)
    first = next(t for t in trace(as_serial(TRACED), CODES) if t.step.instruction.op == op)
    assert found is not None
    assert (found.step, found.step.stage) == (first, stage)
    where = f"instruction {first.step.pc}, cycle {first.step.cycle}, {stage}: {first.text}"
    assert str(found) == f"{where}: expected {found.expected}, observed {found.observed}"


def test_a_wrong_instruction() -> None:
    serial = as_serial(TRACED)
    instructions = list(serial.program.instructions)
    instructions[40] = instructions[41]
    wrong = SerialCore(TRACED, replace(serial.program, instructions=tuple(instructions)), serial.coefficients)
    found = first_difference(TRACED, CODES, wrong)
    assert found is not None
    assert found.step.step.pc == 40
    assert "another instruction" in str(found)


def test_a_standstill() -> None:
    """A core that waits for more coefficients than there are."""
    serial = as_serial(TRACED)
    waits = SerialCore(TRACED, serial.program, np.concatenate([serial.coefficients] * 2))
    found = first_difference(TRACED, CODES, waits)
    assert found is not None
    assert (found.step.step.pc, found.observed) == (0, "a standstill")
