"""``python -m tfra.sim.demo``: the paper's two tables, by float TFRA and by the simulated core.

Both example sensors see 24 directions of a contact.  Every result word of the core is compared with the bit-accurate
model, and the errors of Eqs. 33-35 with the largest ones of the paper (doi:10.1016/j.mechatronics.2023.103070).
Exit code 1 when a word differs or an error exceeds the paper's.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from tfra.codegen.processes import Stopped, stoppable
from tfra.model.errors import InputError
from tfra.model.fixed.pipeline import FixedTfra
from tfra.model.fixed.words import decode, quantise
from tfra.model.metrics import error_force, error_mu, error_phi
from tfra.model.sensor import Floats
from tfra.model.tfra import Result, Tfra
from tfra.sim.run import ProtocolError, Run, SimulationError, simulate

WIDTH = 150
"""Columns that the tables take."""

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


@dataclass(frozen=True)
class Errors:
    """Largest errors over all directions, in percent."""

    force: float
    mu: float
    phi: float

    def within(self, other: Errors) -> bool:
        """True if none is larger than the other's."""
        return self.force <= other.force and self.mu <= other.mu and self.phi <= other.phi


PAPER = {"hertz_40x20": Errors(10.93, 9.41, 1.64), "rectangle_40x40": Errors(5.44, 4.46, 3.16)}
"""Largest errors of the paper's Tables 1 and 2, by example."""


@dataclass(frozen=True)
class Sensor:
    """One sensor's frames through every engine."""

    name: str
    forces: Floats
    """True resultants, ``(n, 3)`` N."""
    mu: Floats
    phi_deg: Floats
    exact: Result
    """Float TFRA on the exact stress."""
    same: Result
    """Float TFRA on the converter's codes."""
    core: Result
    run: Run
    differing: int

    def errors(self, result: Result) -> Errors:
        """Return the largest errors of ``result``."""
        return Errors(
            float(error_force(self.forces, result.resultant).max()),
            float(error_mu(self.mu, result.mu).max()),
            float(error_phi(self.phi_deg, result.phi_deg).max()),
        )


def measure(path: Path, simulator: str | None = None) -> Sensor:
    """Run the contacts of the CONFIG file at ``path`` through float TFRA, the bit-accurate model and the core."""
    from tfra.codegen.config import load

    project = load(path)
    design, contacts, layer = project.design, project.contacts, project.layer
    stress = layer.frames(design.sensor, contacts)
    codes = quantise(design, stress)
    expected = FixedTfra(design)(codes).words
    run = simulate(design, codes, simulator, expected=expected)
    tfra = Tfra.of(design)
    return Sensor(
        path.stem,
        np.array([contact.force for contact in contacts]),
        np.array([contact.mu for contact in contacts]),
        np.degrees([contact.phi for contact in contacts]),
        tfra(stress),
        tfra(codes * design.adc.lsb),
        decode(design, run.words),
        run,
        int((run.words != expected).sum()),
    )


def directions(sensor: Sensor) -> Table:
    """Return the table of the paper: every direction's reference, float TFRA, core, and the core's errors."""
    title = f"{sensor.name}: reference, float TFRA, core; errors of the core"
    table = Table(title=title, title_justify="left", box=SIMPLE)
    headings = ("phi_ref", "F_x / N", "F_y / N", "F_z / N", "mu", "phi / °", "e(F_x,F_y,F_z) / %", "e(mu)", "e(phi)")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    force = error_force(sensor.forces, sensor.core.resultant)
    mu, phi = error_mu(sensor.mu, sensor.core.mu), error_phi(sensor.phi_deg, sensor.core.phi_deg)
    rows = zip(sensor.phi_deg, sensor.forces, sensor.mu, strict=True)
    for n, (angle, reference, friction) in enumerate(rows):
        results = (sensor.exact, sensor.core)
        cells = [
            " ".join(
                f"{round(value, 2) + 0.0:6.2f}" for value in (reference[axis], *(r.resultant[n, axis] for r in results))
            )
            for axis in range(3)
        ]
        cells.append(" ".join(f"{value:.3f}" for value in (friction, *(r.mu[n] for r in results))))
        cells.append(" ".join(f"{round(r.phi_deg[n], 2) % 360:6.2f}" for r in results))
        cells.append(" ".join(f"{value:5.2f}" for value in force[n]))
        table.add_row(f"{angle:.0f}°", *cells, f"{mu[n]:.2f}", f"{phi[n]:.2f}")
    return table


def maxima(sensors: Sequence[Sensor]) -> Table:
    """Return the largest errors beside the paper's."""
    table = Table("largest errors", "forces / %", "mu / %", "phi / %", title="Against the paper", title_justify="left")
    for sensor in sensors:
        paper = PAPER[sensor.name]
        rows = {
            "paper": paper,
            "float TFRA, exact stress": sensor.errors(sensor.exact),
            "float TFRA, converter codes": sensor.errors(sensor.same),
            "core": sensor.errors(sensor.core),
        }
        for name, e in rows.items():
            cells = [_marked(getattr(e, key), getattr(paper, key)) for key in ("force", "mu", "phi")]
            table.add_row(f"{sensor.name}: {name}", *cells, end_section=name == "core")
    return table


def _marked(value: float, limit: float) -> str:
    return f"[red]{value:.2f} > {limit:.2f}[/red]" if value > limit else f"{value:.2f}"


def passed(sensor: Sensor) -> bool:
    """True if every word was compared and equal, and no error exceeds the paper's."""
    complete = sensor.run.compared == sensor.run.words.size > 0
    return complete and not sensor.differing and sensor.errors(sensor.core).within(PAPER[sensor.name])


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demonstration and return its exit code."""
    try:
        with stoppable():
            return _show(arguments)
    except Stopped as stopped:
        return stopped.exit_code


def _show(arguments: Sequence[str] | None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tfra.sim.demo", description=__doc__)
    parser.add_argument("--simulator", help="verilator, icarus or amaranth; default: the fastest installed")
    parser.add_argument("--examples", type=Path, default=EXAMPLES, help="directory of the example CONFIG files")
    options = parser.parse_args(arguments)
    start, console, errors = time.monotonic(), Console(), Console(stderr=True)
    console.width = max(console.width, WIDTH)  # wrapped tables say nothing
    sensors = []
    try:
        for name in PAPER:
            with errors.status(f"{name}: building and simulating the core"):
                sensors.append(measure(options.examples / f"{name}.toml", options.simulator))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except (ProtocolError, SimulationError) as error:
        print(error, file=sys.stderr)
        return 1
    for sensor in sensors:
        console.print(directions(sensor))
    console.print(maxima(sensors))
    for sensor in sensors:
        run = sensor.run
        complete = run.compared == run.words.size
        equal = "yes" if complete and not sensor.differing else f"NO, {sensor.differing} words differ"
        console.print(
            f"{sensor.name}: {run.compared} words compared on {run.simulator}; "
            f"every RTL bit equals the model: {equal}; "
            f"a frame every {np.ceil(run.interval.mean()):.0f} cycles in the mean",
            highlight=False,
        )
    good = all(passed(sensor) for sensor in sensors)
    verdict = "PASSED: every bit equal, no error beyond the paper's"
    if not good:
        verdict = "FAILED: a bit differs or an error exceeds the paper's"
    console.print(f"{verdict} ({time.monotonic() - start:.1f} s)", highlight=False)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
