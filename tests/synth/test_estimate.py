"""The estimate: rules against what yosys mapped, prices against syntheses that were not fitted."""

import json
import re
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from tfra.families import FAMILIES, find, parts
from tfra.model.choices import SERIAL, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.cell_count import Memory
from tfra.synth.estimate import Placed, Prices, at_most, estimate, misfits, multipliers, place, price, prices

ECP5, ICE40 = FAMILIES["ecp5"], FAMILIES["ice40"]
GUIDE = Path(__file__).parents[2] / "docs" / "synth.md"
DATA = {
    kind: json.loads(files("tfra.synth").joinpath(f"estimate_{kind}.json").read_text())
    for kind in ("parallel", "serial", "serial_ecp5")
}
DRAWN = json.loads((Path(__file__).parents[2] / "bench" / "results" / "drawn.json").read_text())["rows"]


LUT_ERRORS = {"serial_ecp5": 0.17}
"""Where estimates of lookup tables are off by more than 10 %."""


def fitted(file: str) -> Prices:
    """The prices of a data file."""
    kind, _, family = file.partition("_")
    return prices(kind, family)


MEMORIES = {
    Memory(8, 14, 1, False): (0, 4),  # normaliser's banks; all of these as synth_ecp5 maps them in a 4x4 core
    Memory(17, 88, 1, False): (0, 44),
    Memory(34, 81, 1, False): (0, 63),
    Memory(64, 112, 1, False): (4, 0),  # forces of a 5x5 core
    Memory(64, 132, 1, False): (4, 0),
    Memory(26, 89, 1, False): (0, 46),
    Memory(144, 18, 1, True): (1, 0),
    Memory(1024, 36, 1, False): (2, 0),
    Memory(2048, 18, 2, True): (2, 0),
    Memory(2048, 18, 2, False): (4, 0),
    Memory(1325, 12, 1, True): (1, 0),  # three rows of 512 words side by side, coefficients of a 10x10 core
    Memory(1325, 13, 1, True): (2, 0),
    Memory(1325, 12, 1, False): (2, 0),  # a written word takes two units of nine bits
}
"""Block memories, and small ones of six lookup tables."""


def test_memories() -> None:
    placed = {memory: place(memory, ECP5) for memory in MEMORIES}
    assert {memory: (found.blocks, found.tables / 6) for memory, found in placed.items()} == MEMORIES
    assert place(Memory(101, 16, 1, True), ECP5) == Placed(0, tables=101, registers=16, levels=0)  # constants: logic
    assert place(Memory(8, 14, 1, False), ICE40).blocks == 1
    assert place(Memory(257, 18, 1, False), ICE40).blocks == 3
    assert place(Memory(1325, 12, 1, True), ECP5).levels == 24
    assert place(Memory(512, 72, 1, False), FAMILIES["xilinx"]).blocks == 1


MULTIPLIERS = {
    "ecp5": {(18, 18): 1, (19, 19): 1, (20, 18): 2, (20, 20): 4, (10, 18): 1, (24, 24): 4, (35, 18): 2, (37, 18): 2},
    "ice40": {(17, 17): 1, (18, 16): 2, (18, 18): 3, (21, 21): 3, (22, 22): 4, (18, 25): 4, (33, 16): 2, (37, 22): 6},
    "gowin": {(20, 20): 1},
    "xilinx": {(18, 24): 1, (20, 20): 2},
}
"""Cells of a product, as yosys 0.70 maps them."""


@pytest.mark.parametrize("name", MULTIPLIERS)
def test_multipliers(name: str) -> None:
    cell = FAMILIES[name].multiplier
    assert {widths: multipliers(widths, cell) for widths in MULTIPLIERS[name]} == MULTIPLIERS[name]


@pytest.mark.parametrize("key", ["fitted", "unseen"])
@pytest.mark.parametrize("kind", DATA)
def test_prices_meet_the_measurements(kind: str, key: str) -> None:
    """Sizes outside the fit too: LUT and FF within 10 % or the exception, multipliers within one, memories exactly."""
    assert len(DATA[kind][key]) >= 2
    for row in DATA[kind][key]:
        found, measured = price(row["features"], fitted(kind)), row["measured"]
        assert found["LUT"] == pytest.approx(measured["LUT"], rel=LUT_ERRORS.get(kind, 0.1)), row["name"]
        assert found["FF"] == pytest.approx(measured["FF"], rel=0.1), row["name"]
        assert found["DSP"] == pytest.approx(measured["DSP"], abs=kind == "serial_ecp5"), row["name"]
        assert found["BRAM"] == measured["BRAM"], row["name"]


@pytest.mark.parametrize("row", DRAWN, ids=[row["text"] for row in DRAWN])
def test_designs_that_nobody_tuned_to(row: dict[str, Any]) -> None:
    """At most 10 % from the synthesis, or the exception; a part that is said to have room for the estimate has it."""
    kind, used = row["by"].partition("_")[0], row["measured"]
    found = {name: round(number) for name, number in price(row["features"], fitted(row["by"])).items()}
    for name in ("LUT", "FF", "DSP", "BRAM"):
        limit = LUT_ERRORS.get(row["by"], 0.1) if name == "LUT" else 0.1
        assert found[name] == pytest.approx(used[name], rel=limit), name
    for target in parts():
        if target.family.name == row["family"] and not misfits(found, target, kind, doubtful=True):
            assert all(used[name] <= have for name, have in target.available.items()), target.name
            most = at_most(found, target.family, kind)
            assert all(used[name] <= most.get(name, found[name]) + 1 for name in used), target.name


def test_errors_that_the_guide_states() -> None:
    """The table of docs/synth.md, from the data files."""
    row = r"^\| (parallel|serial|serial, ECP5): ([^|]+) \| ([^|]+) \| ([^|]+) \|$"
    rows = re.findall(row, GUIDE.read_text(), re.MULTILINE)
    names = {
        "lookup tables": ["LUT"],
        "logic cells": ["LUT"],
        "flip-flops": ["FF"],
        "multipliers, block memories": ["DSP", "BRAM"],
        "multipliers, memories of both kinds": ["DSP", "BRAM", "SPRAM"],
        "block memories": ["BRAM"],
    }
    assert len(rows) == 9
    for title, what, *stated in rows:
        kind = title.replace(", ECP5", "_ecp5")
        for key, text in zip(("fitted", "unseen"), stated, strict=True):
            errors = [
                100 * (price(row["features"], fitted(kind))[name] / row["measured"][name] - 1)
                for row in DATA[kind][key]
                for name in names[what]
                if row["measured"][name]
            ]
            if text == "exact":
                assert errors == [0.0] * len(errors), (kind, what)
                continue
            low, high = re.findall(r"([−+]?[\d.]+)", text)
            assert min(errors) == pytest.approx(float(low.replace("−", "-")), abs=0.051), (kind, what)
            digits = 0.51 if "." not in high else 0.051
            assert max(errors) == pytest.approx(float(high.replace("−", "-")), abs=digits), (kind, what)


def test_a_serial_core() -> None:
    """By its own prices, block by block; its coefficients are cells of the target."""
    design = TfraDesign(SensorArray(4, 4, 4e-3, 2e-3, 3e-3), search=Search(20), architecture=SERIAL, target="ice40")
    found = estimate(design, ICE40)
    assert found.blocks.keys() >= {"sequencer", "lanes", "product", "datapath"}
    assert found.total["SPRAM"] == 4
    assert sum(row["LUT"] for row in found.blocks.values()) == pytest.approx(found.total["LUT"], abs=1)
    (row,) = [row for row in DATA["serial"]["fitted"] if row["name"] == "s4x4"]
    for name, used in row["measured"].items():
        assert found.total[name] == pytest.approx(used, rel=0.1), name
    target, need = find("ice40up5k"), round(5280 * (1 + prices("serial").error["LUT"])) + 1
    assert misfits({**found.total, "LUT": need}, target, "serial") == [
        f"LUT: about {need:,} are needed, ice40up5k has 5,280"
    ]


def test_a_serial_core_on_another_family() -> None:
    """As ``synth_ecp5`` maps it (yosys 0.70), whose prices it does not have: its registers stay outside memories."""
    design = TfraDesign(SensorArray(10, 10, 4e-3, 2e-3, 3e-3), architecture=SERIAL)
    found = estimate(design, ECP5).total
    assert found["FF"] == pytest.approx(1729 - 64, rel=0.1)
    assert found["LUT"] == pytest.approx(4943, rel=0.1)
    assert (found["DSP"], found["BRAM"]) == (7, pytest.approx(33, abs=1))


def test_misfits() -> None:
    target = find("ecp5-25")
    assert misfits(target.available, target) == []
    assert misfits({**target.available, "DSP": 29, "LUT": 40000}, target) == [
        "LUT: about 40,000 are needed, ecp5-25-6 has 24,288",
        "DSP: about 29 are needed, ecp5-25-6 has 28",
    ]


@pytest.mark.parametrize("kind", DATA)
def test_how_short_an_estimate_may_be(kind: str) -> None:
    """The most that any measured core takes more than estimated, of each resource; those drawn by chance count, too."""
    for name, short in fitted(kind).short.items():
        rows = DATA[kind]["fitted"] + DATA[kind]["unseen"] + [row for row in DRAWN if row["by"] == kind]
        more = [row["measured"][name] / price(row["features"], fitted(kind))[name] - 1 for row in rows]
        assert short == pytest.approx(max(0.0, *more), abs=6e-4), name


def test_what_may_fit() -> None:
    """A core is refused if it can't fit, and not chosen if it may not."""
    target = find("ecp5-25")
    used = {**target.available, "LUT": 24_000}
    assert misfits(used, target) == []
    assert misfits(used, target, doubtful=True) == [
        "LUT: about 24,000, at most 25,704, are needed, ecp5-25-6 has 24,288",
        "FF: about 24,288, at most 25,624, are needed, ecp5-25-6 has 24,288",
    ]
