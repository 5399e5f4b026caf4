"""Line 1: words of the Verilog against those of the model, by the million."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, find, settings
from hypothesis import strategies as st
from hypothesis.errors import NoSuchExample

from bench.exactness.designs import core
from bench.scorecard import words
from bench.scorecard.line import GATEWARE, Line, Measured, progress
from bench.scorecard.record import kept
from bench.scorecard.words.drawn import drawn, presets
from bench.scorecard.words.harness import SOURCE, Configuration, Harness, Outcome, replayed
from tfra import model
from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Ints
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.skin.scenes import recorded
from tfra.model.skin.skin import Skin
from tfra.runtime.digest import digest, sources
from tfra.sim.compiled import library
from tfra.sim.compiled_skin import skin_library
from tfra.sim.run import simulate

SEED, COUNT, CYCLES = 1, 32, 15_000_000
"""Of the configurations, their number, and simulated cycles of each, stalls aside."""
QUICK_COUNT, QUICK_CYCLES, QUICK_PRESETS = 6, 300_000, 0
ICARUS_CYCLES = 8_000
"""Simulated cycles that Icarus repeats."""


def directed(configuration: Configuration) -> Ints:
    """Frames ``(n, rows, columns)`` that are sent first: contacts, corners of the input, noise."""
    array, design = configuration.array, configuration.design
    if isinstance(array, Skin):
        return np.concatenate([recorded(array), wild_codes(array, 20, SEED)])
    return np.concatenate([contact_codes(design, 40, SEED), directed_codes(design), wild_codes(design, 100, SEED)])


def shrunk(harness: Harness, codes: Ints) -> Ints | None:
    """The frame with as few taxels of ``codes (taxels,)`` as still show a wrong word; None if it shows none alone.

    The others are 0, as hypothesis finds.
    """
    shape = harness.configuration.array.sensor.rows, harness.configuration.array.sensor.columns

    def frame(kept: list[int]) -> Ints:
        return np.where(kept, codes, 0).reshape(1, *shape)

    def wrong(kept: list[int]) -> bool:
        return not harness.run(frame(kept), 0, SEED).passed

    most = st.lists(st.integers(0, 9), min_size=codes.size, max_size=codes.size)
    options = settings(
        max_examples=300, database=None, derandomize=True, deadline=None, suppress_health_check=list(HealthCheck),
        phases=[Phase.generate, Phase.shrink],
    )  # fmt: skip
    try:
        return np.asarray(frame(find(most, wrong, settings=options))[0])
    except NoSuchExample:
        return None


def record(configuration: Configuration, cycles: int) -> dict[str, Any]:
    """That of a configuration, from the cache while nothing that decides it has changed."""
    array = configuration.array
    made = skin_library(array) if isinstance(array, Skin) else library(array)
    harness = (file.read_text() for file in sorted(SOURCE.parent.glob("*.[ch]*")))
    key = digest(str(cycles), *configuration.texts.values(), made.hex(), *harness, *sources(model, words))
    return kept(f"words-{array.name}", key, lambda: compared(configuration, cycles))


def compared(configuration: Configuration, cycles: int) -> dict[str, Any]:
    """The record of a configuration; frames are as many as ``cycles`` take."""
    with tempfile.TemporaryDirectory() as folder:
        harness = Harness(configuration, Path(folder))
        interval = microarchitecture(configuration.design).initiation_interval
        frames = int(cycles / (interval + configuration.array.sensor.taxels))
        outcome = harness.run(directed(configuration), frames, SEED)
        wrong = None if outcome.passed or "codes" not in outcome.counts else shrunk(harness, _codes(outcome))
    replay, other = replayed(configuration, outcome)
    array = configuration.array
    facts = {
        "name": configuration.name,
        "array": f"{array.sensor.rows}×{array.sensor.columns}",
        "estimator": configuration.design.estimator,
        "core": core(configuration.design),
        "axi": ("cut through" if configuration.cut_through else "whole frames") if configuration.wrapped else "",
        "converter": array.adc.bits,
        "formats": str(configuration.design.formats),
        **{name: outcome.counts[name] for name in ("frames", "words", "differ", "broken", "missing", "cycles")},
        "replayed": replay,
        "replayed_differ": other,
        "icarus": _icarus(configuration, int(ICARUS_CYCLES / interval) + 1),
    }
    if not outcome.passed:
        facts |= {"first": outcome.counts["first"], "shrunk": None if wrong is None else wrong.tolist()}
    return facts


def _codes(outcome: Outcome) -> Ints:
    return np.array(outcome.counts["codes"], dtype=np.int64)


def _icarus(configuration: Configuration, frames: int) -> dict[str, int]:
    """Words of some directed frames that Icarus compares with the model in Python; none of a skin or behind AXI."""
    design = configuration.design
    if configuration.wrapped or isinstance(configuration.array, Skin):
        return {"compared": 0, "differ": 0}
    codes = directed(configuration)[-frames:]
    ran = simulate(design, codes, "icarus", SEED, "random", "bursts", expected=design.model(codes).words)
    return {"compared": ran.compared, "differ": ran.mismatches}


def wrong_words(record: dict[str, Any]) -> int:
    """Words that differ, are missing or break the rules of a stream, in any of the comparisons."""
    here = sum(record[name] for name in ("differ", "broken", "missing", "replayed_differ"))
    return int(here + record["icarus"]["differ"])


def measure(quick: bool) -> Measured:
    """All configurations, or some of them with fewer frames."""
    count, cycles = (QUICK_COUNT, QUICK_CYCLES) if quick else (COUNT, CYCLES)
    records = []
    for configuration in (*drawn(count, SEED), *(() if quick else presets())):
        records.append(record(configuration, cycles))
        progress("{name}: {array} {estimator}, {core}{axi:.>13}: {words:,} words".format(**records[-1]))
    bad = [record["name"] for record in records if wrong_words(record)]
    total, wrong = sum(record["words"] for record in records), sum(map(wrong_words, records))
    replay = sum(record["replayed"] for record in records)
    icarus = sum(record["icarus"]["compared"] for record in records)
    figure = f"{total:,} words in {len(records)} configurations, {wrong:,} wrong in {len(bad)} of them"
    figure += f"; {replay:,} of them replayed in Python, {icarus:,} in Icarus"
    enough = quick or (total >= 1e8 and len(records) >= 30)
    return Measured(figure, enough and not bad, {"seed": SEED, "configurations": records})


LINE = Line(
    1,
    "words of the Verilog equal those of the model: both estimators, serial and parallel, alone and behind AXI, a skin",
    "1e8 words, 30 configurations, 0 wrong",
    "the words are those of the core in C, of which a sample is compared with the model in Python; a frame that is"
    " missing or out of place counts as well. Frames behind AXI all have the right length: `make axi` sends others.",
    (*GATEWARE, "sim", "bench/exactness/axi.py", "bench/exactness/designs.py", "bench/scorecard/words"),
    measure,
)
