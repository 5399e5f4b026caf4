"""The registers are as small as docs/registers.md says."""

from pathlib import Path

import pytest

from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.codegen.registers.source import parameters, register_map
from tfra.codegen.verilog.emit import to_rtlil
from tfra.families import find
from tfra.hdl.bus.registers import Registers
from tfra.synth.flow import synthesise


@pytest.mark.long
def test_size(tmp_path: Path) -> None:
    registers = Registers(register_map(parameters(load(ROOT / "examples" / "fast.toml").design)))
    found = synthesise(to_rtlil(registers, "registers"), "registers", find("ecp5-25-6"), tmp_path).resources
    assert found["LUT"] == pytest.approx(706, rel=0.05)
    assert found["FF"] == pytest.approx(592, rel=0.05)
    assert "take 706 LUT and 592 FF of an ECP5" in (ROOT / "docs" / "registers.md").read_text()
