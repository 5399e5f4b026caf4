"""Copies of what drives many lanes: each drives neighbours, and taken back they leave the netlist as it was."""

import copy
import json
from typing import Any

import pytest
from amaranth import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tests.families.ecp5.netlists import mapped
from tests.marks import long
from tfra.codegen.verilog.emit import run_yosys
from tfra.families.ecp5.copies import LANES, spread
from tfra.families.hierarchy import lane_of
from tfra.synth.gates import rename_wires


class Lanes(wiring.Component):
    """``number`` registers under lanes' names, whose enable is a lookup table behind two registers."""

    def __init__(self, number: int) -> None:
        self._number = number
        super().__init__({"a": In(1), "b": In(1), "word": In(number), "taken": Out(number), "enabled": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m, core, matvec = Module(), Module(), Module()
        m.submodules.core = core
        core.submodules.matvec = matvec
        a, b = Signal(), Signal()
        m.d.sync += [a.eq(self.a), b.eq(self.b), self.enabled.eq(a ^ b)]
        for number in range(self._number):
            lane, register = Module(), Signal(name="register", reset_less=True)
            matvec.submodules[f"lane{number}"] = lane
            with lane.If(a ^ b):
                lane.d.sync += register.eq(self.word[number])
            m.d.comb += self.taken[number].eq(register)
        return m


def taken_back(module: dict[str, Any], known: set[str]) -> dict[str, Any]:
    """The cells without those that are not ``known``, whose readers read what the original drives."""
    cells = copy.deepcopy(module["cells"])
    for name in cells.keys() - known:
        twin, original = cells.pop(name), cells[name.rpartition(".matvec.")[0]]
        (output,) = (port for port, way in twin["port_directions"].items() if way == "output")
        (old,), (new,) = original["connections"][output], twin["connections"][output]
        for cell in cells.values():
            for bits in cell["connections"].values():
                bits[:] = [old if bit == new else bit for bit in bits]
    return cells


@pytest.mark.parametrize("number", [LANES, LANES + 1, *long(1, 3 * LANES)])
def test_copies(tmp_path, number):
    netlist = mapped(Lanes(number), tmp_path)
    before, module = copy.deepcopy(netlist["modules"]["top"]["cells"]), netlist["modules"]["top"]
    added = spread(netlist, "top")
    groups = -(-number // LANES)
    # The lookup table that enables the lanes stays with the first ones; the two registers before it drive it and its
    # first copy, their own copies the others.
    assert added == {"LUT4": groups - 1, "TRELLIS_FF": 2 * max(groups - 2, 0)}
    assert taken_back(module, set(before)) == before
    enables = {}
    for name, cell in module["cells"].items():
        if cell["type"] == "TRELLIS_FF" and name in before and (lane := lane_of(name)) is not None:
            enables.setdefault(cell["connections"]["CE"][0], set()).add(lane // LANES)
    assert sorted(enables.values(), key=min) == [{group} for group in range(groups)]


def test_yosys_reads_copies_whose_wires_have_names_of_their_own(tmp_path):
    netlist = mapped(Lanes(3 * LANES), tmp_path)
    spread(netlist, "top")
    (tmp_path / "copies.json").write_text(json.dumps(netlist))
    with pytest.raises(RuntimeError, match="count_id"):
        run_yosys("read_json copies.json", tmp_path)
    rename_wires(netlist["modules"]["top"])
    (tmp_path / "copies.json").write_text(json.dumps(netlist))
    run_yosys("read_json copies.json", tmp_path)


def test_a_reader_of_something_else_is_noticed(tmp_path):
    netlist = mapped(Lanes(2 * LANES), tmp_path)
    module = netlist["modules"]["top"]
    before = copy.deepcopy(module["cells"])
    spread(netlist, "top")
    next(cell for cell in module["cells"].values() if "CE" in cell["connections"])["connections"]["CE"] = ["1"]
    assert taken_back(module, set(before)) != before
