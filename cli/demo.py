"""``python -m tfra.cli.demo``: the paper's two tables, computed by float TFRA and by the simulated core.

Each of two example sensors measures a contact in 24 directions.  Every result word of the core is compared with the
bit-accurate model, and the errors of Eqs. 33-35 with the largest ones of the paper
(doi:10.1016/j.mechatronics.2023.103070).  Exit code 1 if a word differs, an error exceeds the paper's, or the
initiation interval is not the design's.
"""

import argparse
import math
import sys
import textwrap
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from tfra.codegen.config.read import load
from tfra.contacts import Truth
from tfra.hdl.cores import microarchitecture
from tfra.model.converter import quantise
from tfra.model.fixed.words import decode
from tfra.model.tfra import Result, Tfra
from tfra.model.truth import sentence
from tfra.paper.published import PAPER, PRINTED, Contacts, errors, largest, number, percents, plain
from tfra.paper.setups import EXAMPLES
from tfra.runtime.errors import InputError
from tfra.runtime.processes import Stopped, stoppable
from tfra.sim.run import ProtocolError, Run, SimulationError, simulate

WIDTH = 80
"""Columns of the longest line."""

FULL = slice(8, 20)
"""The averaged intervals: twelve with the pipeline full, for which the design states the interval.  The first frames
enter an empty core, and no others follow the last ones."""


@dataclass(frozen=True)
class Sensor:
    """One sensor's frames through every engine."""

    name: str
    truth: Contacts
    exact: Result
    """Float TFRA on the exact stress."""
    same: Result
    """Float TFRA on the converter's codes."""
    core: Result
    run: Run
    differing: int
    interval: int
    """Cycles between frames, as the design states them."""

    @property
    def measured_interval(self) -> int | None:
        """Cycles between frames with the pipeline full; None if there were too few."""
        settled = self.run.interval[FULL]
        return math.ceil(settled.mean()) if len(settled) == FULL.stop - FULL.start else None

    @property
    def failures(self) -> list[str]:
        """What is wrong: empty if all words were compared and equal and no error exceeds the paper's."""
        found, worst = [], largest(errors(self.truth, self.core))
        if self.differing or not self.run.compared == self.run.words.size > 0:
            found.append(f"{self.differing} of {self.run.words.size} words differ, {self.run.compared} were compared")
        if any(worst[key] > PRINTED[self.name][key] for key in PAPER):
            found.append("an error is larger than the paper's largest")
        if self.measured_interval not in (None, self.interval):
            found.append(f"frames come every {self.measured_interval} cycles, not {self.interval}")
        return [f"{self.name}: {failure}" for failure in found]


def measure(path: Path, simulator: str | None = None) -> Sensor:
    """Run the contacts of the CONFIG file at ``path`` through float TFRA, the bit-accurate model and the core."""
    project = load(path)
    design, truth = project.design, Truth(project.contacts)
    stress = project.layer.frames(design.sensor, project.contacts)
    codes = quantise(design, stress)
    expected = design.model(codes).words
    run = simulate(design, codes, simulator, expected=expected)
    tfra = Tfra.of(design)
    return Sensor(
        path.stem,
        Contacts(truth.resultant, truth.mu, truth.phi_deg),
        tfra(stress),
        tfra(codes * design.adc.lsb),
        decode(design, run.words),
        run,
        int((run.words != expected).sum()),
        microarchitecture(design).initiation_interval,
    )


def directions(sensor: Sensor) -> list[str]:
    """The table of the paper: reference, float TFRA and core for every direction, with errors."""
    row = "{:>5} {:<9} {:>6} {:>6} {:>6} {:>6} {:>7} {:>6} {:>6} {:>6} {:>6}".format
    truth = sensor.truth
    lines = [
        f"{sensor.name}: 24 directions of one contact" if len(truth.mu) == 24 else sensor.name,
        "F in N, phi in degrees; errors against the reference: phi in degrees, mu, the",
        "length of the error of F in N and in percent of the reference's |F|.",
        "float: double precision on the exact stress; core: the simulated Verilog.",
        "",
        row("phi", "", "F_x", "F_y", "F_z", "mu", "phi", "err:", "mu", "F/N", "F/%"),
    ]
    found = {name: (result, errors(truth, result)) for name, result in (("float", sensor.exact), ("core", sensor.core))}
    for n, angle in enumerate(truth.phi_deg):
        lines.append(row(f"{angle:.0f}", "reference", *_frame(truth, n), *[""] * 4).rstrip())
        for name, (result, every) in found.items():
            off = plain({key: float(values[n]) for key, values in every.items() if values.ndim == 1})
            lines.append(row("", name, *_frame(result, n), *off))
    return lines


def _frame(of: Contacts | Result, n: int) -> list[str]:
    return [*(number(f, 2) for f in of.resultant[n]), number(of.mu[n], 3), f"{round(of.phi_deg[n], 2) % 360:.2f}"]


def maxima(sensors: Sequence[Sensor]) -> list[str]:
    """The largest errors, in plain units and as the paper measures them, beside the paper's."""
    row = "{:<26} {:>7} {:>5} {:>6} {:>6} {:>8} {:>7} {:>8}".format
    lines = [
        "Largest errors over all directions. The paper's own: e(F), worst component in",
        "percent of the |F| found (Eq. 35); e(mu), percent of mu = 1 (Eq. 33); e(phi),",
        "percent of a full turn (Eq. 34).",
        "",
        row("", "phi/deg", "mu", "F/N", "F/%", "e(F)/%", "e(mu)/%", "e(phi)/%"),
    ]
    for sensor in sensors:
        paper = PRINTED[sensor.name]
        stated = paper | {"phi_deg": 3.6 * paper["phi"], "mu_abs": paper["mu"] / 100}
        results = {"float, exact stress": sensor.exact, "float, converter's codes": sensor.same, "core": sensor.core}
        worst = {name: largest(errors(sensor.truth, result)) for name, result in results.items()}
        lines.append(sensor.name)
        for name, each in ({"paper, Tables 1 and 2": stated} | worst).items():
            lines.append(row(f"  {name}", *plain(each), *percents(each)))
    return lines


def speed(sensor: Sensor) -> str:
    """The number of words compared and the measured initiation interval."""
    run, measured = sensor.run, sensor.measured_interval
    often = "too few frames to measure the interval" if measured is None else f"a frame every {measured:,} cycles"
    return (
        f"{sensor.name}: {run.compared:,} of {run.words.size:,} words compared on {run.simulator}, {sensor.differing} "
        f"differ; {often} with the pipeline full (design: {sensor.interval:,})."
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demonstration and return its exit code."""
    try:
        with stoppable():
            return _demonstrate(arguments)
    except Stopped as stopped:
        return stopped.exit_code


def _demonstrate(arguments: Sequence[str] | None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tfra.cli.demo", description=__doc__)
    parser.add_argument("--simulator", help="verilator, icarus or amaranth; default: the fastest installed")
    parser.add_argument("--examples", type=Path, default=EXAMPLES, help="directory of the example CONFIG files")
    options = parser.parse_args(arguments)
    start, status = time.monotonic(), Console(stderr=True)
    sensors = []
    try:
        for name in PRINTED:
            with status.status(f"{name}: building and simulating the core"):
                sensors.append(measure(options.examples / f"{name}.toml", options.simulator))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except (ProtocolError, SimulationError) as error:
        print(error, file=sys.stderr)
        return 1
    for lines in (*map(directions, sensors), maxima(sensors)):
        print(*lines, "", sep="\n")
    failures = [failure for sensor in sensors for failure in sensor.failures]
    verdict = "PASSED: every bit of the core equals the model; no error is larger than the paper's largest"
    if failures:
        verdict = f"FAILED: {'; '.join(failures)}"
    for text in (*map(speed, sensors), f"{verdict} ({time.monotonic() - start:.0f} s).", sentence()):
        print(textwrap.fill(text, WIDTH, subsequent_indent="  "))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
