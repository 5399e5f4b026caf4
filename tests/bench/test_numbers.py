"""Cycles, products and lanes that are told in prose are those of the design object."""

import json
import re
from functools import cache

import numpy as np
import pytest

from bench import headline
from bench.cycles import cores
from bench.publish import ROOT
from tfra.codegen.config.read import MOST_TAXELS, load
from tfra.codegen.sidecar.build import sidecar
from tfra.hdl.cores import microarchitecture
from tfra.model.boussinesq import operators
from tfra.model.sensor import SensorArray


@cache
def core(lanes):
    return microarchitecture(cores.design(lanes))


@cache
def preset(name):
    return microarchitecture(load(ROOT / "examples" / f"{name}.toml").design)


@cache
def products():
    return cores.design(16).multiplications


def condition():
    """cond(C33) of 10×10 taxels whose pitch is a third of the thickness."""
    return round(float(np.linalg.cond(operators(SensorArray(10, 10, 1e-3, 1e-3, 3e-3)).c33)))


TOLD = [
    ("docs/measured.md", r"A 10×10 frame takes ([\d,]+) real products", products),
    ("README.md", r"cond\(C33\) of 10×10\s+taxels is ([\d,]+)", condition),
    ("README.md", r"2×2 to ([\d,]+) taxels", lambda: MOST_TAXELS),
    ("CHANGELOG.md", r"10×10 on 64 lanes takes a\s+frame every ([\d,]+) cycles", lambda: core(64).initiation_interval),
    ("docs/parallel.md", r"For 10×10 that is ([\d,]+) real products", products),
    (
        "docs/parallel.md", r"(\d+) of them have a coefficient that is zero",
        lambda: products() - cores.design(16).nonzero_products,
    ),
    ("docs/parallel.md", r"an interval of ([\d,]+) cycles, where", lambda: core(16).initiation_interval),
    ("docs/parallel.md", r"where ([\d,]+) / 16 would be", products),
    ("docs/parallel.md", r"22,900 / 16 would be ([\d,]+)\.", lambda: -(-products() // 16)),
    ("docs/serial.md", r"\| \*\*frame\*\* \| \*\*([\d,]+)\*\*", lambda: preset("small").initiation_interval),
    ("docs/serial.md", r"to the first word, is ([\d,]+) cycles", lambda: preset("small").latency),
    ("docs/serial.md", r"to the last word ([\d,]+)\.", lambda: preset("small").frame_latency),
    ("docs/studies/schedule.md", r"\| `matvec` \| ([\d,]+) \| 100% \|", lambda: preset("fast").initiation_interval),
    (
        "docs/learned.md", r"direction, friction \| (\d+) \| \d+ \| \d+ \|",
        lambda: preset("learned_resultant").latency,
    ),
    (
        "docs/learned.md", r"direction, friction \| \d+ \| (\d+) \| \d+ \|",
        lambda: preset("learned_resultant").frame_latency,
    ),
    (
        "docs/learned.md", r"direction, friction \| \d+ \| \d+ \| (\d+) \|",
        lambda: preset("learned_resultant").initiation_interval,
    ),
    ("docs/learned.md", r"and forces at the taxels \| (\d+) \| \d+ \| \d+ \|", lambda: preset("learned_fast").latency),
    (
        "docs/learned.md", r"forces at the taxels \| \d+ \| (\d+) \| \d+ \|",
        lambda: preset("learned_fast").frame_latency,
    ),
    (
        "docs/learned.md", r"and forces at the taxels \| \d+ \| \d+ \| (\d+) \|",
        lambda: preset("learned_fast").initiation_interval,
    ),
    ("docs/learned.md", r"units, (\d+) lanes, in cycles", lambda: preset("learned_fast").lanes),
    (
        "examples/learned_fast.toml", r"frame every (\d+) cycles, its",
        lambda: preset("learned_fast").initiation_interval,
    ),
    ("examples/learned_fast.toml", r"first word (\d+) cycles", lambda: preset("learned_fast").latency),
    (
        "examples/learned_fast.toml", r"alone: a frame every (\d+) cycles",
        lambda: preset("learned_resultant").initiation_interval,
    ),
    (
        "examples/learned_resultant.toml", r"a frame every (\d+) cycles",
        lambda: preset("learned_resultant").initiation_interval,
    ),
    (
        "examples/learned_small.toml", r"a frame every ([\d,]+) cycles",
        lambda: preset("learned_small").initiation_interval,
    ),
    ("examples/small.toml", r"a frame every ([\d,]+) cycles", lambda: preset("small").initiation_interval),
]
"""Where a number is told, the one group that finds it, and what it has to be."""

AT_MOST = [
    ("examples/balanced.toml", r"within ([\d,]+) cycles", lambda: preset("balanced").latency),
    ("examples/fast.toml", r"within ([\d,]+) cycles", lambda: preset("fast").latency),
    ("examples/fast.toml", r"a frame every ([\d,]+)\.", lambda: preset("fast").initiation_interval),
]
"""Bounds that are told, and what has to be within them."""


def number(text, pattern):
    """The only number that ``pattern`` finds in ``text``."""
    found = re.findall(pattern, text)
    assert len(found) == 1, f"{pattern}: found {len(found)} times"
    return int(found[0].replace(",", ""))


@pytest.mark.parametrize(("file", "pattern", "value"), TOLD)
def test_prose(file, pattern, value):
    assert number((ROOT / file).read_text(), pattern) == value()


@pytest.mark.parametrize(("file", "pattern", "value"), AT_MOST)
def test_bounds(file, pattern, value):
    assert value() <= number((ROOT / file).read_text(), pattern)


def test_a_wrong_or_missing_number_is_found():
    text = (ROOT / "docs" / "measured.md").read_text()
    wrong = text.replace("takes 22,900 real", "takes 25,000 real")
    assert number(wrong, TOLD[0][1]) != products()
    with pytest.raises(AssertionError, match="found 0 times"):
        number(text.replace("real products", "products"), TOLD[0][1])


def test_headline():
    assert headline.table() in (ROOT / "README.md").read_text()


def test_table_of_cores():
    record, lines = cores.rows()
    assert "\n".join(lines) in (ROOT / "docs" / "measured.md").read_text()
    stored = json.loads((ROOT / "bench" / "results" / "cores.json").read_text())
    assert stored["rows"] == record
    assert stored["multiplications"] == products()


@pytest.mark.parametrize("lanes", [16, 64])
def test_growth(lanes):
    found = core(lanes)
    row = f"| 10×10 | {lanes} | {products():,} | {found.initiation_interval:,} | "
    assert row in (ROOT / "docs" / "studies" / "large_arrays.md").read_text()


@pytest.mark.parametrize("name", ["fast", "balanced", "small", "learned_fast", "learned_resultant", "learned_small"])
def test_presets(name):
    cycles = preset(name)
    page = (ROOT / "docs" / "measured.md").read_text()
    rows = [line for line in page.splitlines() if line.startswith(f"| `{name}` | ")]
    assert rows
    for row in rows:
        cells = row.split(" | ")
        assert cells[8:10] == [f"{cycles.latency:,}", f"{cycles.initiation_interval:,}"]


def test_sidecar():
    found = sidecar(cores.design(16))
    assert found["multiplications_per_frame"] == products()
    assert found["interval_cycles"] == core(16).initiation_interval
