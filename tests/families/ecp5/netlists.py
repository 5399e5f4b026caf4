"""Small blocks as yosys maps them to an ECP5."""

import json
from pathlib import Path
from typing import Any

from amaranth.back import rtlil
from amaranth.lib import wiring

from tfra.codegen.verilog.emit import run_yosys, with_free_collisions


def mapped(block: wiring.Component, folder: Path) -> dict[str, Any]:
    """The netlist of ``block``, module ``top``."""
    (folder / "block.il").write_text(with_free_collisions(str(rtlil.convert(block, name="top", emit_src=False))))
    run_yosys("read_rtlil block.il; synth_ecp5 -top top; write_json block.json", folder)
    netlist: dict[str, Any] = json.loads((folder / "block.json").read_text())
    return netlist
