"""The trace of a frame names stages, texts and values."""

from __future__ import annotations

from tests.hdl.serial.designs import DESIGNS
from tfra.hdl.cores import as_serial, program
from tfra.hdl.serial.isa import Dest
from tfra.hdl.serial.trace import trace
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.pipeline import FixedTfra

DESIGN = DESIGNS["2×3"]
CODES = contact_codes(DESIGN, 1, seed=6)


def test_a_frame():
    steps = list(trace(as_serial(DESIGN), CODES))
    code = program(DESIGN)
    assert str(steps[0]).split() == ["0", "0", "reset", "m[counter]", "=", "0", "m[counter]", "<-", "0"]
    assert [s.step.cycle for s in steps] == list(range(len(steps)))
    words = [s.step.value for s in steps if s.step.instruction.written in (Dest.OUT, Dest.LAST)]
    assert words == FixedTfra(DESIGN)(CODES).words[0].tolist()
    callers = ("dependent.dependent", "friction.friction", "gain.gain", "gain.mu")
    assert {s.stage for s in steps if "quotient" in s.stage} == {f"{caller}, routines.quotient" for caller in callers}
    assert all((s.step.pc >= code.subroutines) == ("," in s.stage) for s in steps)


def test_what_is_not_written_has_no_value():
    kinds = {traced.text: str(traced) for traced in trace(as_serial(DESIGN), CODES) if traced.stage == "status.status"}
    assert kinds["R0 = 0 if F1"].endswith("R0 <- 0")
    assert kinds["R0 = 2 if F0"].endswith("R0 <- 2")
    assert kinds["R1 = 16 if F0"].endswith("R1 = 16 if F0")
    assert kinds["F1 = m[regular] < 0"].endswith("F1 <- True")
