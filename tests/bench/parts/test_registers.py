"""The size of the registers is the published one, and leaves most of a small core's budget to the rest of its bus."""

from __future__ import annotations

import json

import pytest

from bench.parts.registers import measure
from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.codegen.registers.source import register_map
from tfra.codegen.registers.values import parameters

MOST = 800
"""Lookup tables on an ECP5."""


@pytest.mark.long
def test_size() -> None:
    registers = register_map(parameters(load(ROOT / "examples" / "fast.toml").design))
    found = measure(registers, "ecp5-25-6")
    told = json.loads((ROOT / "bench" / "results" / "registers.json").read_text())["ecp5-25-6"]
    assert found["LUT"] < MOST
    assert found == pytest.approx(told, rel=0.05)
