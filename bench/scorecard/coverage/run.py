"""A core of a configuration, Verilated with coverage, in sessions that resets end."""

import json
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.scorecard.coverage import bins
from bench.scorecard.coverage.verilog import Point, points
from bench.scorecard.words.harness import Configuration, built, ran
from bench.scorecard.words.measure import directed
from tfra.hdl.cores import microarchitecture

SOURCE = Path(__file__).with_name("sessions.cpp")
SEED = 1


@dataclass(frozen=True)
class Covered:
    """Of a configuration: how often each point was reached, what was compared in each bin, and words that are wrong."""

    points: dict[Point, int]
    bins: Counter[str]
    words: int
    wrong: int


def covered(configuration: Configuration, cycles: int) -> Covered:
    """Run directed frames and those of the bins, then random ones, for about so many ``cycles``."""
    sensor = configuration.array.sensor
    each = microarchitecture(configuration.design).initiation_interval + sensor.taxels
    codes = np.concatenate([bins.chosen(configuration, SEED), directed(configuration)])
    most = max(1, int(cycles / 9 / each))
    codes, random = codes[:most], max(0, most - len(codes))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        program = built(configuration, folder, SOURCE, options=("--coverage-line",))
        (folder / "given").write_bytes(codes.astype("<i4").tobytes())
        counts: dict[str, Any] = json.loads(ran(program, "./core.so", SEED, random, "given"))
        data = (folder / "coverage.dat").read_text(errors="replace")
    own = (f"{configuration.array.name}.v", f"{configuration.top}.v")  # without models of a device's cells
    texts = {name: text for name, text in configuration.texts.items() if name in own}
    cores = {configuration.array.name, configuration.design.name, configuration.top}
    reached = points(data, cores, texts)
    wrong = counts["differ"] + counts["broken"] + counts["missing"]
    return Covered(reached, bins.hit(configuration, codes, counts), counts["words"], wrong)
