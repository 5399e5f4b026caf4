"""The estimate: rules against what yosys mapped, prices against syntheses that were not fitted."""

import json
import re
from importlib.resources import files
from pathlib import Path

import pytest

from tfra.families import FAMILIES, Family, find
from tfra.model.choices import SERIAL, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.cell_count import CellCount, Memory
from tfra.synth.estimate import KINDS, Prices, estimate, features, misfits, multipliers, place, price, prices

ECP5, ICE40, GOWIN, XILINX = (FAMILIES[name] for name in ("ecp5", "ice40", "gowin", "xilinx"))
GUIDE = Path(__file__).parents[2] / "docs" / "synth.md"
DATA = {
    kind: json.loads(files("tfra.synth").joinpath(name).read_text())
    for kind, name in (("parallel", "estimate_parallel.json"), ("serial", "estimate_serial.json"))
}


@pytest.mark.parametrize(
    ("memory", "blocks", "small"),
    [
        (Memory(8, 14, 1, False), 0, 4),  # normaliser's banks; all of these as synth_ecp5 maps them in a 4x4 core
        (Memory(17, 88, 1, False), 0, 44),
        (Memory(34, 81, 1, False), 0, 63),
        (Memory(64, 112, 1, False), 4, 0),  # forces of a 5x5 core
        (Memory(64, 132, 1, False), 4, 0),
        (Memory(26, 89, 1, False), 0, 46),
        (Memory(144, 18, 1, True), 1, 0),
        (Memory(1024, 36, 1, False), 2, 0),
        (Memory(2048, 18, 2, True), 2, 0),
        (Memory(2048, 18, 2, False), 4, 0),
    ],
)
def test_memories_of_ecp5(memory: Memory, blocks: int, small: int) -> None:
    found = place(memory, ECP5)
    assert found.blocks == blocks
    assert found.tables == 6 * small


def test_a_small_table_of_constants_becomes_logic() -> None:
    found = place(Memory(101, 16, 1, True), ECP5)
    assert (found.blocks, found.tables, found.registers, found.levels) == (0, 101, 16, 0)


def test_memories_of_other_families() -> None:
    assert place(Memory(8, 14, 1, False), ICE40).blocks == 1
    assert place(Memory(257, 18, 1, False), ICE40).blocks == 3
    assert place(Memory(512, 72, 1, False), XILINX).blocks == 1


@pytest.mark.parametrize(
    ("widths", "family", "cells"),
    [
        ((18, 18), ECP5, 1),  # all of these as yosys 0.70 maps them
        ((19, 19), ECP5, 1),
        ((20, 18), ECP5, 2),
        ((20, 20), ECP5, 4),
        ((10, 18), ECP5, 1),
        ((24, 24), ECP5, 4),
        ((35, 18), ECP5, 2),
        ((37, 18), ECP5, 2),
        ((17, 17), ICE40, 1),
        ((18, 16), ICE40, 2),
        ((18, 18), ICE40, 3),
        ((21, 21), ICE40, 3),
        ((22, 22), ICE40, 4),
        ((18, 25), ICE40, 4),
        ((33, 16), ICE40, 2),
        ((37, 22), ICE40, 6),
        ((20, 20), GOWIN, 1),
        ((18, 24), XILINX, 1),
        ((20, 20), XILINX, 2),
    ],
)
def test_multipliers(widths: tuple[int, int], family: Family, cells: int) -> None:
    assert multipliers(widths, family.multiplier) == cells


def test_instances_count_as_what_they_are() -> None:
    counts = CellCount()
    counts.instances.update({"MULT18X18D": 7, "DP16KD": 2})
    found = features(counts, ECP5)
    assert (found["DSP"], found["BRAM"]) == (7, 2)


def test_price_is_the_sum_of_its_parts() -> None:
    rates = Prices("ecp5", "tfra", dict.fromkeys(KINDS, 0.5), 0.9, {})
    found = dict.fromkeys((*KINDS, "table", "ff", "DSP", "BRAM", "SPRAM"), 10.0)
    assert price(found, rates) == {"LUT": 35.0, "FF": 9.0, "DSP": 10, "BRAM": 10, "SPRAM": 10}


@pytest.mark.parametrize("key", ["fitted", "unseen"])
@pytest.mark.parametrize(("kind", "blocks"), [("parallel", 0.1), ("serial", 0.2)])
def test_prices_meet_the_measurements(kind: str, blocks: float, key: str) -> None:
    """Sizes outside the fit too: LUT, FF and DSP within 10 %, BRAM within ``blocks``."""
    assert len(DATA[kind][key]) >= 2
    for row in DATA[kind][key]:
        found, measured = price(row["features"], prices(kind)), row["measured"]
        assert found["LUT"] == pytest.approx(measured["LUT"], rel=0.1), row["name"]
        assert found["FF"] == pytest.approx(measured["FF"], rel=0.1), row["name"]
        assert found["DSP"] == pytest.approx(measured["DSP"], rel=0.1), row["name"]
        assert found["BRAM"] == pytest.approx(measured["BRAM"], rel=blocks, abs=1), row["name"]


def test_errors_that_the_guide_states() -> None:
    """The table of docs/synth.md, from the data files."""
    rows = re.findall(r"^\| (parallel|serial): ([^|]+) \| ([^|]+) \| ([^|]+) \|$", GUIDE.read_text(), re.MULTILINE)
    names = {
        "lookup tables": ["LUT"],
        "logic cells": ["LUT"],
        "flip-flops": ["FF"],
        "multipliers, block memories": ["DSP", "BRAM"],
        "multipliers, memories of 256 kbit": ["DSP", "SPRAM"],
        "block memories": ["BRAM"],
    }
    assert len(rows) == 7
    for kind, what, *stated in rows:
        for key, text in zip(("fitted", "unseen"), stated, strict=True):
            errors = [
                100 * (price(row["features"], prices(kind))[name] / row["measured"][name] - 1)
                for row in DATA[kind][key]
                for name in names[what]
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
    fits = dict(target.available)
    assert misfits(fits, target) == []
    assert misfits({**fits, "DSP": 29}, target) == ["DSP: about 29 are needed, ecp5-25-6 has 28"]
    assert misfits({**fits, "LUT": 40000}, target) == ["LUT: about 40,000 are needed, ecp5-25-6 has 24,288"]
