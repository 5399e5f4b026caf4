"""Gates of both families give the model's words; gates with a fault don't."""

import re
from collections import Counter, defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tfra.families import FAMILIES
from tfra.families.family import Gates
from tfra.families.hierarchy import block_of, lane_of
from tfra.model.choices import Adc, Architecture, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.sensor import SensorArray
from tfra.runtime.errors import InputError
from tfra.sim.run import Netlist, Run, SimulationError, generated, simulate
from tfra.synth import gates as netlist
from tfra.synth.gates import cells, synthesised

GATES = [name for name, family in FAMILIES.items() if family.gates]

DESIGN = TfraDesign(
    SensorArray(2, 2, 4e-3, 4e-3, 3e-3),
    name="gates",
    adc=Adc(6),
    search=Search(2),
    formats=Formats("short", coefficient=10, operand=10, vector_fraction=0, force_fraction=0),
    architecture=Architecture(mac_lanes=4),
)
"""Every block in few gates: they compile slowly and run at some hundred cycles a second."""

CODES = np.array([[[-20, -9], [-5, 3]], [[-32, 31], [31, -32]], [[-4, 3], [-1, 2]]])
"""The last frame is just below the contact threshold."""


FIRST_ROW = re.compile(r"(\.INITVAL_00\(320'h)([0-9a-f]+)")
SIGNS = sum(1 << (20 * place + DESIGN.formats.coefficient - 1) for place in range(16))


@pytest.fixture(params=GATES, name="gates", scope="module")
def _gates(request: pytest.FixtureRequest, cache: Path) -> Netlist:
    return synthesised(replace(DESIGN, target=request.param), request.param, cache)


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


def play(core: Netlist | None, cache: Path, design: Design = DESIGN, frames: int = len(CODES)) -> Run:
    expected = FixedTfra(DESIGN)(CODES[:frames]).words
    return simulate(design, CODES[:frames], "icarus", 1, "random", "none", cache, expected=expected, core=core)


@pytest.mark.long
def test_gates_equal_the_model(gates: Netlist, cache: Path) -> None:
    run = play(gates, cache)
    assert (run.compared, run.mismatches) == (run.words.size, 0)


@pytest.mark.long
def test_cells_know_their_lanes(gates: Netlist) -> None:
    """By names that hdl gives: each lane has its multiplier, and as many cells of every kind as any other."""
    cells = re.findall(r"^  ([A-Z]\w+) (?:#\([^;]*?\n  \) )?(\S+) +\($", gates.verilog, re.MULTILINE)
    lanes = range(DESIGN.architecture.mac_lanes)
    kinds = defaultdict[str, list[int]](list)
    for kind, name in cells:
        if (lane := lane_of(name)) is not None:
            assert block_of(name) == "matvec"
            kinds[kind].append(lane)
        else:
            assert not re.search(r"lane\d", name)
    kinds.pop("DP16KD", None)
    memories = [lane_of(name) for kind, name in cells if kind == "DP16KD"]
    assert memories in ([], list(lanes)[::2])  # two lanes share one
    multipliers = [kind for kind, _ in cells if kind in ("MULT18X18D", "SB_MAC16")]
    assert sorted(kinds[multipliers[0]]) == list(lanes)
    assert all(Counter(found) == dict.fromkeys(lanes, len(found) // len(lanes)) for found in kinds.values())
    sums = r"\.matvec\.lane\d+\.sum|\.drain\.sums__\d"  # a sum has all these names
    for register in (sums, r"\.drain\.captured\d"):
        assert {lane_of(name) for _, name in cells if re.search(register, name)} == set(lanes), register


@pytest.mark.long
@pytest.mark.parametrize("gates", ["ecp5"], indirect=True)
def test_a_fault_is_found(gates: Netlist, cache: Path) -> None:
    """The signs of the first coefficients are flipped in both memories."""
    text, number = FIRST_ROW.subn(lambda row: f"{row[1]}{int(row[2], 16) ^ SIGNS:080x}", gates.verilog)
    assert number == 2
    run = play(replace(gates, verilog=text), cache, frames=1)
    assert run.mismatches > 0


def test_cells_of_yosys_leave_room_for_models() -> None:
    text = cells(FAMILIES["ecp5"])
    assert "module TRELLIS_FF(" in text
    assert not re.search("module (DP16KD|MULT18X18D)|`include", text)
    assert "module SB_MAC16" in cells(FAMILIES["ice40"])


CHANGED = (
    "codegen/verilog/emit.py",
    "hdl/primitives/models/DP16KD.v",
    "model/fixed/widths.py",
    "families/ecp5/copies.py",
    "runtime/digest.py",
    "synth/gates.py",
)


@pytest.mark.long
def test_gates_of_other_sources_are_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    named, root, works = list[str](), Path(__file__).parents[2], Path.read_text
    monkeypatch.setattr(netlist, "cached", lambda place, make: named.append(place.name) or {"gates.v": b""})
    for changed in ("", "", *CHANGED):

        def read(file: Path, changed: Path = root / changed, **how: Any) -> str:
            return works(file, **how) + "changed" * (file.resolve() == changed)

        monkeypatch.setattr(Path, "read_text", read)
        synthesised(DESIGN, "ecp5", tmp_path)
    assert named[0] == named[1]
    assert len(set(named)) == 1 + len(CHANGED)


def test_another_target_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="netlist: ice40: the design's target is ecp5"):
        synthesised(replace(DESIGN, target="ecp5"), "ice40", tmp_path)


@pytest.mark.long
def test_failing_synthesis_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAMILIES, "ecp5", replace(FAMILIES["ecp5"], gates=Gates("synth_nothing -top {top}")))
    with pytest.raises(SimulationError, match=r"synthesis for ecp5: yosys failed: .*No such command: synth_nothing"):
        synthesised(DESIGN, "ecp5", tmp_path)
    assert not list(tmp_path.iterdir())


def test_amaranth_cannot_run_gates_or_cells() -> None:
    line = "simulator: amaranth: can't run Verilog, Icarus can: apt-get install iverilog"
    with pytest.raises(InputError, match=line):
        simulate(DESIGN, CODES, "amaranth", core=Netlist("gates", "", {}))
    with pytest.raises(InputError, match=line):
        simulate(replace(DESIGN, target="ecp5"), CODES, "amaranth")


@pytest.mark.long
@pytest.mark.parametrize("target", GATES)
def test_the_core_of_a_target_equals_the_model(target: str, cache: Path) -> None:
    """Before synthesis: Verilog with instances, and the models of their cells."""
    run = play(None, cache, replace(DESIGN, target=target))
    assert (run.compared, run.mismatches) == (run.words.size, 0)


@pytest.mark.long
def test_a_target_has_instances(cache: Path) -> None:
    text = generated(replace(DESIGN, target="ecp5"), cache).verilog
    assert text.count("MULT18X18D #(") == 4
    assert text.count("DP16KD #(") == 2  # two lanes share one
