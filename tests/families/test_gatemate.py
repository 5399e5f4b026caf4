"""GateMate: a multiplier of logic through all tools."""

from pathlib import Path

import pytest

from tfra.codegen.verilog.emit import to_rtlil
from tfra.codegen.verilog.pins import Pins
from tfra.families import find
from tfra.hdl.primitives import Multiplier
from tfra.synth.flow import pack, route, synthesise


@pytest.mark.long
def test_a_multiplier_of_logic(tmp_path: Path) -> None:
    """It has no hard multiplier, and a frequency with the delay of its logic in it."""
    target = find("gatemate-a1")
    made = synthesise({"times.il": to_rtlil(Pins(Multiplier(18, 18, "portable")), "times")}, target, tmp_path)
    assert made.cells["CC_MULT"] == 1
    assert set(made.resources) == {"LUT", "FF", "BRAM"}
    routed = route(target, tmp_path, 1, target.clock_mhz)
    assert 312 <= routed.resources["LUT"] <= 1.5 * made.resources["LUT"]
    assert routed.resources["FF"] == made.resources["FF"]
    assert 30 < routed.mhz < 100
    assert routed.path.logic_ns + routed.path.routing_ns == pytest.approx(1e3 / routed.mhz, abs=0.01)
    assert (tmp_path / pack(target, tmp_path, 1, "times")).stat().st_size > 10_000
