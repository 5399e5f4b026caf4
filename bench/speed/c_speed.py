"""Time of one 10x10 frame as a C program on one core, checked against the float model on every frame it is given.

``python -m bench.speed.c_speed [--frames N]`` compiles ``bench/c``, measures, writes ``bench/results/c_speed.json`` and
the table in docs/studies/c_speed.md.  ``--table`` makes the table again from that file and from what
``bench.parts.presets`` stored.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bench.publish import ROOT, insert, publish
from bench.speed.c_program import Library, Program, compiler
from tfra.model.arrays import Floats
from tfra.model.cover.scenes import contact_codes, wild_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status, Tfra

SENSOR = SensorArray(10, 10, 4e-3, 2e-3, 3e-3)
PAGE = "docs/studies/c_speed.md"
BATCH, WARM, PASSES = 10_000, 1000, 5
EXACT = 1e-9
"""Largest difference of a double from the float model, relative (:func:`compare`)."""

PLAIN = ("-O3",)
PROGRAMS = {
    "C, folded, `double`": Program("tfra", "double"),
    "C, folded, `float`": Program("tfra", "float"),
    "C, folded, `double`, plain `-O3`": Program("tfra", "double", PLAIN),
    "C, folded, `float`, plain `-O3`": Program("tfra", "float", PLAIN),
    "C, literal, `double`": Program("literal", "double"),
    "C, literal, `double`, plain `-O3`": Program("literal", "double", PLAIN),
}
LITERAL_SHARE = 10
"""The literal loop, far slower, runs every tenth frame."""

PUBLISHED = {
    "published, SpTFRA hardware": (58.68e3, "10.3390/s24237829"),
    "published, TFRA in Matlab, longest": (32.28e3, "10.1016/j.mechatronics.2023.103070"),
}
"""Time of a frame in us, and the DOI that states it."""

SCALARS = ("phi_deg", "mu", "mu_x", "mu_y")


@dataclass
class Tally:
    """Results of one program: times in us, one row a pass; frames compared, how many differ, and the largest difference
    of the rest."""

    times: list[Floats] = field(default_factory=list)
    compared: int = 0
    indices: int = 0
    states: int = 0
    worst: float = 0.0

    def row(self) -> dict[str, Any]:
        """The measurements for the record; ``steady``: the longest of the frames' shortest passes."""
        times = np.concatenate(self.times, axis=1)
        return {
            "compared": self.compared,
            "timed": times.shape[1],
            "median_us": float(np.median(times)),
            "p999_us": float(np.percentile(times, 99.9)),
            "max_us": float(times.max()),
            "steady_us": float(times.min(axis=0).max()),
            "other_index": self.indices,
            "other_status": self.states,
            "worst": self.worst,
        }


def compare(found: Result, expected: Result) -> tuple[int, int, float]:
    """Frames with another sweep index, with another status, and the largest difference of the rest.

    Differences are relative: of forces to the frame's largest, of phi to 360 degrees, of mu to 1 or itself if larger.
    NaN counts as infinite.
    """
    indices, states = found.sweep_index != expected.sweep_index, found.status != expected.status
    same = ~indices & ~states
    scales = {name: np.maximum(1.0, np.abs(getattr(expected, name))) for name in SCALARS} | {"phi_deg": 360.0}
    worst = [np.abs(getattr(found, name) - getattr(expected, name)) / scale for name, scale in scales.items()]
    for name in ("forces", "resultant"):
        a, b = (getattr(result, name).reshape(len(same), -1) for result in (found, expected))
        largest = np.abs(expected.forces).reshape(len(same), -1).max(axis=1)
        worst.append(np.abs(a - b).max(axis=1) / np.where(largest > 0, largest, 1.0))
    largest_of_all = np.max(np.nan_to_num(np.array(worst)[:, same], nan=np.inf), initial=0.0)
    return int(indices.sum()), int(states.sum()), float(largest_of_all)


def examine(tally: Tally, program: Program, library: Library, stress: Floats, expected: Result) -> None:
    """Measure ``stress`` several times, compare the last results, and add everything to ``tally``.

    All frames are compared; times count of those that need the sweep, as the others end early.  Raises ``ValueError``
    when the folded program in ``double`` differs from the float model.
    """
    chosen = slice(None, None, LITERAL_SHARE if program.source == "literal" else 1)
    expected = Result(**{n: v[chosen] for n, v in vars(expected).items() if v is not None})
    passes = [library(stress[chosen]) for _ in range(PASSES)]
    swept = expected.status & (Status.NO_CONTACT | Status.COMPRESSION_ONLY) == 0
    tally.times.append(np.array([times[swept] for _, times in passes]) / 1e3)
    tally.compared += len(swept)
    indices, states, worst = compare(passes[-1][0], expected)
    tally.indices += indices
    tally.states += states
    tally.worst = max(tally.worst, worst)
    if program.source == "tfra" and program.real == "double" and (indices or states or worst > EXACT):
        raise ValueError(f"{indices} sweep indices and {states} states differ from the float model, results by {worst}")


def measure(frames: int, batch: int = BATCH) -> dict[str, Any]:
    """Record of ``frames`` frames, half of them contacts and half noise, in batches."""
    design = TfraDesign(SENSOR)
    model, contacts, noise = Tfra.of(design), np.random.default_rng(1), np.random.default_rng(2)
    tallies, shares = {name: Tally() for name in PROGRAMS}, []
    with tempfile.TemporaryDirectory() as directory:
        libraries = {}
        for number, (name, program) in enumerate(PROGRAMS.items()):
            place = Path(directory, str(number))
            place.mkdir()
            libraries[name] = Library(program, SENSOR, design.search.steps, place, model.contact_threshold)
        for done in range(0, frames, batch):
            count = min(batch, frames - done)
            parts = contact_codes(design, count // 2, contacts), wild_codes(design, count - count // 2, noise)
            stress = np.asarray(np.concatenate(parts) * design.adc.lsb, dtype=np.float64)
            model(stress[:WARM])
            start = time.perf_counter()
            expected = model(stress)
            shares.append((time.perf_counter() - start) / count)
            for name, library in libraries.items():
                library(stress[:WARM])
                examine(tallies[name], PROGRAMS[name], library, stress, expected)
        clock = libraries["C, folded, `double`"].overhead(100_000)
    rows = {name: asdict(PROGRAMS[name]) | tally.row() for name, tally in tallies.items()}
    clock_us = {"median": float(np.median(clock)) / 1e3, "p999": float(np.percentile(clock, 99.9)) / 1e3}
    record = {"frames": frames, "passes": PASSES, "cpu": cpu(), "compiler": compiler(), "load": os.getloadavg()[0]}
    return record | {"clock_us": clock_us, "model_us": 1e6 * float(np.median(shares)), "rows": rows}


def cpu() -> str:
    """The processor's name by the kernel."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))


def fpga_rows() -> list[tuple[str, float, float]]:
    """The presets as place and route left them: name, us from the last taxel to the last word, us between frames."""
    path = ROOT / "bench" / "results" / "presets.json"
    presets = json.loads(path.read_text()) if path.exists() else {}
    rows = []
    for _, found in sorted(presets.items()):
        times, mhz = found["timing"], found["clock"]["median_mhz"]
        text = f"core `{found['name']}` on {found['target']}, {mhz:.1f} MHz"
        rows.append((text, times["frame_latency_us"], times["interval_us"]))
    return rows


def table(record: dict[str, Any]) -> str:
    """Markdown of a record, of the cores, and of what was published."""
    head = ["one 10×10 frame", "µs, median", "99.9 %", "longest", f"longest, best of {PASSES}", "other winner"]
    head += [f"{us / 1e3:g} ms is × median" for us, _ in PUBLISHED.values()]
    lines = [f"| {' | '.join(head)} |", "|---|" + "---:|" * (len(head) - 1)]
    for name, row in record["rows"].items():
        times = [f"{row[key + '_us']:,.1f}" for key in ("median", "p999", "max", "steady")]
        lines.append(_line(name, row["median_us"], [*times, f"{row['other_index']} of {row['compared']:,}"]))
    share = f"float model in NumPy, its share of {min(BATCH, record['frames']):,} at once"
    lines.append(_line(share, record["model_us"], [f"{record['model_us']:,.1f}", *"––––"]))
    for name, latency, interval in fpga_rows():
        lines.append(_line(f"{name}, one every {interval:,.1f} µs", latency, [f"{latency:,.1f}"] * 4 + ["–"]))
    for name, (us, doi) in PUBLISHED.items():
        lines.append(_line(f"{name} ([doi](https://doi.org/{doi}))", us, [f"{us:,.0f}", *"––––"]))
    clock = f"{1e3 * record['clock_us']['median']:.0f} ns"
    machine = f"{record['cpu']}, {record['compiler']}, load {record['load']:.1f}"
    return "\n".join([*lines, "", f"{machine}; reading the clock takes {clock}, included."])


def _line(name: str, us: float, cells: list[str]) -> str:
    ratios = [f"{published / us:,.0f}" if us < published else "" for published, _ in PUBLISHED.values()]
    return f"| {' | '.join([name, *cells, *ratios])} |"


def main() -> None:
    """Measure and publish, or publish again."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=100_000)
    parser.add_argument("--table", action="store_true", help="only make the table again")
    arguments = parser.parse_args()
    if arguments.table:
        insert("c_speed", table(json.loads((ROOT / "bench" / "results" / "c_speed.json").read_text())), PAGE)
        return
    record = measure(arguments.frames)
    publish("c_speed", record, table(record), PAGE)


if __name__ == "__main__":
    main()
