"""Cycles, products and lanes in prose are those of the design object."""

import re
from functools import cache

import numpy as np
import pytest

from bench import headline
from bench.cycles import cores
from bench.parts import axi_cost, presets
from bench.publish import ROOT, stored
from tfra.codegen.config.read import MOST_TAXELS, load
from tfra.codegen.registers.source import registers_of
from tfra.hdl.bus.registers import Registers
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import cut_through, latencies
from tfra.model.boussinesq import operators
from tfra.model.sensor import SensorArray
from tfra.synth.report import timing


@cache
def core(lanes):
    return microarchitecture(cores.design(lanes))


@cache
def preset(name):
    return microarchitecture(load(ROOT / "examples" / f"{name}.toml").design)


@cache
def products():
    return cores.design(16).multiplications


def interval(lanes):
    return core(lanes).initiation_interval


def zeros():
    """Products whose coefficient is zero."""
    return (products() - cores.design(16).nonzero_products,)


def condition():
    """cond(C33) of 10×10 taxels whose pitch is a third of the thickness."""
    return (round(float(np.linalg.cond(operators(SensorArray(10, 10, 1e-3, 1e-3, 3e-3)).c33))),)


def cycles(name, *attributes):
    """What a preset states of itself, evaluated when it is asked for."""
    return lambda: tuple(getattr(preset(name), attribute) for attribute in attributes)


ALL = "latency", "frame_latency", "initiation_interval"
INTERVAL = "initiation_interval"

STATED = [
    ("docs/measured.md", r"A 10×10 frame takes ([\d,]+) real products", lambda: (products(),)),
    ("README.md", r"cond\(C33\) of 10×10\s+taxels is ([\d,]+)", condition),
    ("README.md", r"2×2 to ([\d,]+) taxels", lambda: (MOST_TAXELS,)),
    ("CHANGELOG.md", r"10×10 on 64 lanes takes a\s+frame every ([\d,]+) cycles", lambda: (interval(64),)),
    ("docs/parallel.md", r"For 10×10 that is ([\d,]+) real products", lambda: (products(),)),
    ("docs/parallel.md", r"(\d+) of them have a coefficient that is zero", zeros),
    ("docs/parallel.md", r"an interval of ([\d,]+) cycles, where", lambda: (interval(16),)),
    ("docs/parallel.md", r"where ([\d,]+) / 16 would", lambda: (products(),)),
    ("docs/serial.md", r"\| \*\*frame\*\* \| \*\*([\d,]+)\*\*", cycles("small", INTERVAL)),
    ("docs/serial.md", r"to the first word, is ([\d,]+) cycles", cycles("small", "latency")),
    ("docs/serial.md", r"to the last word ([\d,]+)\.", cycles("small", "frame_latency")),
    ("docs/serial.md", r"Taxels of a frame in ([\d,]+) cycles", cycles("small", "intake")),
    ("docs/ip.md", r"`small` takes ([\d,]+) cycles", cycles("small", "intake")),
    ("docs/ip.md", r"`balanced`: ([\d,]+), then ([\d,]+) cycles", lambda: tuple(preset("balanced").intervals[:2])),
    ("docs/studies/schedule.md", r"\| `matvec` \| ([\d,]+) \| 100% \|", cycles("fast", INTERVAL)),
    ("docs/learned.md", r"direction, friction \| (\d+) \| (\d+) \| (\d+) \|", cycles("learned_resultant", *ALL)),
    ("docs/learned.md", r"and forces at the taxels \| (\d+) \| (\d+) \| (\d+) \|", cycles("learned_fast", *ALL)),
    ("docs/learned.md", r"units, (\d+) lanes, in cycles", cycles("learned_fast", "lanes")),
    ("examples/learned_fast.toml", r"frame every (\d+) cycles, its", cycles("learned_fast", INTERVAL)),
    ("examples/learned_fast.toml", r"first word (\d+) cycles", cycles("learned_fast", "latency")),
    ("examples/learned_fast.toml", r"alone: a frame every (\d+) cycles", cycles("learned_resultant", INTERVAL)),
    ("examples/learned_resultant.toml", r"a frame every (\d+) cycles", cycles("learned_resultant", INTERVAL)),
    ("examples/learned_small.toml", r"a frame every ([\d,]+) cycles", cycles("learned_small", INTERVAL)),
    ("examples/small.toml", r"a frame every ([\d,]+) cycles", cycles("small", INTERVAL)),
]
"""Where numbers are stated, the groups that find them, and what they have to be."""

AT_MOST = [
    ("examples/balanced.toml", r"within ([\d,]+) cycles", cycles("balanced", "latency")),
    ("examples/fast.toml", r"within ([\d,]+) cycles", cycles("fast", "latency")),
    ("examples/fast.toml", r"a frame every ([\d,]+)\.", cycles("fast", INTERVAL)),
]
"""Bounds that are stated, and what has to be within them."""


def numbers(text, pattern):
    """The numbers of the only place that ``pattern`` finds in ``text``."""
    found = list(re.finditer(pattern, text))
    assert len(found) == 1, f"{pattern}: found {len(found)} times"
    return tuple(int(group.replace(",", "")) for group in found[0].groups())


@pytest.mark.parametrize(("file", "pattern", "values"), STATED)
def test_prose(file, pattern, values):
    assert numbers((ROOT / file).read_text(), pattern) == values()


@pytest.mark.parametrize(("file", "pattern", "values"), AT_MOST)
def test_bounds(file, pattern, values):
    assert values() <= numbers((ROOT / file).read_text(), pattern)


def test_a_missing_number_is_found():
    with pytest.raises(AssertionError, match="found 0 times"):
        numbers("takes 22,900 products", STATED[0][1])


def test_latencies_behind_axi():
    record = stored("axi_cost")
    assert axi_cost.table(record) in (ROOT / "docs" / "ip.md").read_text()
    for name, found in record["intervals"].items():
        first, _, most, _ = latencies(preset(name))
        cut, _ = cut_through(preset(name))
        assert found["latency"] == [preset(name).latency, first, cut, most]
        assert found["behind_axi"] == found["alone"] == preset(name).initiation_interval


def test_headline():
    assert headline.table() in (ROOT / "README.md").read_text()


def test_table_of_cores():
    record, lines = cores.rows()
    assert "\n".join(lines) in (ROOT / "docs" / "measured.md").read_text()
    kept = stored("cores")
    assert kept["rows"] == record
    assert kept["multiplications"] == products()


@pytest.mark.parametrize("lanes", [16, 64])
def test_growth(lanes):
    found = core(lanes)
    row = f"| 10×10 | {lanes} | {products():,} | {found.initiation_interval:,} | "
    assert row in (ROOT / "docs" / "studies" / "large_arrays.md").read_text()


@pytest.mark.parametrize("row", presets.rows(), ids=lambda row: row["name"])
def test_presets(row):
    core = microarchitecture(presets.design(row))
    stated = timing(core, row["clock"]["median_mhz"] if row["clock"] else None, package=row["package"])
    assert row["timing"] == pytest.approx(stated, rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("row", presets.rows(), ids=lambda row: row["name"])
def test_presets_are_of_the_verilog_of_today(row):
    """A preset without a row was not placed since it changed."""
    assert row["netlist"] == presets.current(row), "measure again, or drop it: python -m bench.parts.presets"


@pytest.mark.long
def test_registers_are_as_small_as_the_page_says():
    found = axi_cost.size(Registers(registers_of(preset("fast").design)))
    assert [found["LUT"], found["FF"]] == pytest.approx([561, 695], rel=0.05)
    assert "take 561 LUT and 695 FF of an ECP5" in (ROOT / "docs" / "registers.md").read_text()


def test_table_of_presets():
    assert presets.table() in (ROOT / "docs" / "measured.md").read_text()
