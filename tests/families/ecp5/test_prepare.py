"""What is said of a prepared netlist is what is in it."""

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from amaranth.back import rtlil

from tests.families.ecp5.test_copies import _Lanes
from tests.families.ecp5.test_registers import Times
from tfra.codegen.verilog.emit import run_yosys
from tfra.families.ecp5.prepare import prepare


def kinds(netlist: dict[str, Any]) -> Counter[str]:
    return Counter(cell["type"] for cell in netlist["modules"]["top"]["cells"].values())


@pytest.mark.parametrize(("block", "changed", "sign"), [(_Lanes(12), "LUT4", 1), (Times(True), "TRELLIS_FF", -1)])
def test_cells_are_counted(block: Any, changed: str, sign: int, tmp_path: Path) -> None:
    """Copies for lanes that share an enable, and a multiplier between registers."""
    (tmp_path / "block.il").write_text(rtlil.convert(block, name="top"))
    run_yosys("read_rtlil block.il; synth_ecp5 -top top; write_json block.json", tmp_path)
    netlist = json.loads((tmp_path / "block.json").read_text())
    before, added = kinds(netlist), prepare(netlist, "top")
    after = kinds(netlist)
    assert all(after[kind] - before[kind] == added[kind] for kind in before | after)
    assert sign * added[changed] > 0
