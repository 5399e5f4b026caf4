"""What is said of a prepared netlist is what is in it."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

from amaranth import Module
from amaranth.back import rtlil
from amaranth.lib import wiring

from tests.families.ecp5.test_copies import _Lanes
from tests.families.ecp5.test_registers import Times
from tfra.codegen.verilog.emit import run_yosys
from tfra.families.ecp5.prepare import prepare


class Both(wiring.Component):
    """Lanes that share an enable, and a multiplier between registers."""

    def __init__(self) -> None:
        self._lanes, self._times = _Lanes(12), Times(before=True)
        members = {f"t_{name}": port for name, port in self._times.signature.members.items()}
        super().__init__({**self._lanes.signature.members, **members})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.lanes, m.submodules.times = self._lanes, self._times
        for name, port in self._lanes.signature.members.items():
            inner, outer = getattr(self._lanes, name), getattr(self, name)
            m.d.comb += inner.eq(outer) if port.flow is wiring.In else outer.eq(inner)
        for name, port in self._times.signature.members.items():
            inner, outer = getattr(self._times, name), getattr(self, f"t_{name}")
            m.d.comb += inner.eq(outer) if port.flow is wiring.In else outer.eq(inner)
        return m


def kinds(netlist: dict[str, Any]) -> Counter[str]:
    return Counter(cell["type"] for cell in netlist["modules"]["top"]["cells"].values())


def test_cells_are_counted(tmp_path: Path) -> None:
    (tmp_path / "block.il").write_text(rtlil.convert(Both(), name="top"))
    run_yosys("read_rtlil block.il; synth_ecp5 -top top; write_json block.json", tmp_path)
    netlist = json.loads((tmp_path / "block.json").read_text())
    before = kinds(netlist)
    added = prepare(netlist, "top")
    after = kinds(netlist)
    assert added["TRELLIS_FF"] < 0 < added["LUT4"]
    assert all(after[kind] - before[kind] == added[kind] for kind in before | after)
