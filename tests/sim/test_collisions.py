"""No block looks at a word that a memory gives while it is written: ``no_rw_check`` leaves open what that is."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.emit import Top, plain_verilog, to_rtlil
from tfra.model.choices import Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.sensor import SensorArray
from tfra.sim.run import Netlist, Run, SimulationError, simulate

COLLISION = re.compile(
    r"(?<=TRANSPARENCY_MASK 1'0)(\n +parameter \\COLLISION_X_MASK) 1'0(?=(\n +param.*)*\n +parameter \\CLK_ENABLE 1\b)"
)

DESIGNS = [
    TfraDesign(SensorArray(4, 4, 4e-3, 2e-3, 3e-3), "even", search=Search(20), architecture=Architecture(16)),
    TfraDesign(SensorArray(3, 5, 3e-3, 3e-3, 2e-3), "odd", search=Search(7, 1.5), architecture=Architecture(4)),
]


def unknown(design: Design) -> Netlist:
    """The core, with unknown words from memories where they are read while they are written.

    Amaranth specifies the old word, for which block memories need extra registers and comparators.
    """
    free = COLLISION.sub(r"\1 1'1", to_rtlil(Top(design), design.name))
    assert len(re.findall(r"COLLISION_X_MASK 1'1", free)) > 15
    return Netlist(design.name, plain_verilog(free, design.name), sidecar(design))


def play(design: Design, core: Netlist, cache: Path) -> Run:
    """Frames back to back with stalls, more than the core holds."""
    rng = np.random.default_rng(3)
    codes = rng.integers(-3000, 1500, (12, design.sensor.rows, design.sensor.columns))
    expected = FixedTfra(design)(codes).words
    return simulate(design, codes, "icarus", 5, "bursts", "bursts", cache, expected=expected, core=core)


@pytest.mark.long
@pytest.mark.parametrize("design", DESIGNS, ids=lambda design: design.name)
def test_words_do_not_depend_on_collisions(design: Design, tmp_path: Path) -> None:
    run = play(design, unknown(design), tmp_path)
    assert (run.compared, run.mismatches) == (run.words.size, 0)


@pytest.mark.long
def test_an_unknown_word_is_seen(tmp_path: Path) -> None:
    """Memories give unknown words whenever anything is written to them."""
    design = DESIGNS[0]
    core = unknown(design)
    text, number = re.subn(r"(if \([^&\n]+) && [^\n]* == [^\n]*\) begin", r"\1) begin", core.verilog)
    assert number > 15
    with pytest.raises(SimulationError, match="contains non-0/1 values"):
        play(design, replace(core, verilog=text), tmp_path)
