"""Small blocks as yosys maps them to an ECP5."""

import json
from pathlib import Path
from typing import Any

from amaranth.lib import wiring

from tfra.codegen.verilog.emit import plain_verilog, run_yosys, to_rtlil


def mapped(block: wiring.Component, folder: Path) -> dict[str, Any]:
    """The netlist of ``block``, module ``top``."""
    (folder / "block.v").write_text(plain_verilog(to_rtlil(block, "top"), "top"))
    run_yosys("read_verilog block.v; synth_ecp5 -top top; write_json block.json", folder)
    netlist: dict[str, Any] = json.loads((folder / "block.json").read_text())
    return netlist
