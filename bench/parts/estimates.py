"""Fit the prices of ``tfra.synth.estimate`` to syntheses, and write its data files.

``python -m bench.parts.estimates`` synthesises every design of a grid for each data file, and the twelve of
:mod:`bench.parts.drawn`, of which docs/synth.md has a table.  Those that are not fitted are compared with the fit.
``--measure`` names the grids to synthesise; the stored designs of all others are counted anew.

A lookup table of a serial core is a logic cell of iCE40, as nextpnr packs them: there are a quarter more of them than
lookup tables, since flip-flops behind block memories, multipliers and carries take cells of their own.
"""

import argparse
import json
import re
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import nnls

from bench.parts.drawn import RESOURCES, drawn, random_weights, text
from bench.publish import ROOT, publish, stored
from tfra.codegen.config.read import load
from tfra.codegen.verilog.files import modules
from tfra.families import Family, Target, find
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.cell_count import CellCount, cell_counts
from tfra.synth.estimate import KINDS, Prices, features, price
from tfra.synth.flow import NETLIST, synthesise
from tfra.synth.tools import run, versions

DRAWN = "drawn"
"""The twelve: among the grids of the command line, and their marks in docs/synth.md."""


@dataclass(frozen=True)
class Grid:
    """Designs of one kind on a part, and the resources whose estimates are uncertain."""

    target: Target
    fitted: tuple[Design, ...]
    unseen: tuple[Design, ...]
    uncertain: tuple[str, ...]


def parallel(rows: int, columns: int, mac: int, **others: Any) -> Design:
    """A parallel core on a grid of 4 mm x 2 mm."""
    return _design(f"a{rows}x{columns}_l{mac}", rows, columns, architecture=Architecture(mac), **others)


def serial(rows: int, columns: int, target: str = "ice40", **others: Any) -> Design:
    """A serial core on such a grid."""
    return _design(f"s{rows}x{columns}", rows, columns, architecture=SERIAL, target=target, **others)


def learned(rows: int, columns: int, core: Architecture, units: tuple[int, int], **others: Any) -> Design:
    """A core of a network with so many orbits of units, whose weights have no meaning."""
    sensor, choices = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3), {"taxel_forces": True, "threshold": 0.25, **others}
    weights = random_weights(np.random.default_rng(0), sensor.taxels, *units)
    name = f"n{rows}x{columns}_l{core.mac_lanes}" if core.mac_lanes else f"ns{rows}x{columns}"
    return LearnedDesign(sensor, name=name, architecture=core, weights=weights, **choices)


def _design(name: str, rows: int, columns: int, **others: Any) -> Design:
    return TfraDesign(SensorArray(rows, columns, 4e-3, 2e-3, 3e-3), name=name, **others)


def preset(name: str) -> Design:
    """A preset in `examples/`, as it is packaged."""
    return load(ROOT / "examples" / f"{name}.toml").design


def random_size(seed: int) -> Design:
    """A parallel core whose size is a matter of chance, for the cells of an ECP5."""
    rng = np.random.default_rng(seed)
    rows, columns, lanes, bits, steps = (int(n) for n in rng.integers((3, 3, 1, 8, 10), (13, 13, 5, 17, 201)))
    return parallel(rows, columns, 4 * lanes, adc=Adc(bits), search=Search(steps), target="ecp5")


GRIDS = {
    "parallel": Grid(
        find("ecp5-85"),
        (
            parallel(4, 4, 4),
            parallel(2, 2, 4),
            parallel(3, 5, 4, adc=Adc(10)),
            parallel(3, 3, 4, formats=replace(FORMATS["wide"], name="custom")),
            parallel(4, 6, 8, search=Search(100, 3.0)),
            parallel(5, 5, 12),
            preset("balanced"),
            learned(4, 4, Architecture(16, 4), (16, 8)),
            learned(8, 8, Architecture(32, 2), (48, 24), target="ecp5"),
            learned(5, 7, Architecture(12, 1), (24, 12), formats=Formats("custom", 14, 14, 7, 4), taxel_forces=False),
            learned(6, 10, Architecture(24, 4), (32, 16), formats=Formats("custom", 24, 24, 10, 6)),
            replace(
                learned(9, 6, Architecture(8, 1), (20, 10), formats=Formats("custom", 12, 20, 9, 5), target="ecp5"),
                adc=Adc(10),
            ),
        ),
        (
            *(parallel(6, 4, 24, search=Search(30)), parallel(7, 9, 32), parallel(10, 10, 16)),
            *(preset("fast"), random_size(1), random_size(2)),
            parallel(9, 9, 16, formats=replace(FORMATS["standard"], name="custom", coefficient=12)),
        ),
        ("LUT", "FF"),
    ),
    "serial": Grid(
        find("ice40up5k"),
        (
            serial(4, 4, search=Search(20)),
            serial(2, 2, adc=Adc(10)),
            serial(6, 8, formats=FORMATS["wide"]),
            serial(8, 8, adc=Adc(12), formats=Formats("custom", 14, 14, 5, 3)),
            serial(3, 5, adc=Adc(8), formats=Formats("custom", 10, 10, 2, 2)),
        ),
        (
            serial(10, 10),
            serial(5, 7, search=Search(16, 2.5)),
            serial(9, 7, adc=Adc(16), formats=Formats("custom", 16, 20, 10, 4)),
            serial(4, 7, adc=Adc(10), formats=Formats("custom", 12, 16, 6, 3)),
            serial(8, 12, adc=Adc(12)),
            serial(7, 7, search=Search(200), formats=Formats("custom", 20, 20, 11, 6)),
        ),
        ("LUT", "FF", "BRAM"),
    ),
    "serial_ecp5": Grid(
        find("ecp5-85"),
        (
            serial(10, 10, "portable"),
            serial(6, 8, "ecp5", formats=FORMATS["wide"]),
            serial(3, 5, "portable", adc=Adc(8), formats=Formats("custom", 10, 10, 2, 2)),
            learned(8, 8, SERIAL, (32, 16), target="ecp5"),
            learned(5, 6, SERIAL, (16, 8), formats=Formats("custom", 24, 16, 6, 5)),
        ),
        (
            serial(8, 8, "ecp5", adc=Adc(12), formats=Formats("custom", 14, 14, 5, 3)),
            learned(9, 7, SERIAL, (24, 12), formats=Formats("custom", 14, 20, 8, 4), target="ecp5"),
        ),
        ("LUT", "FF", "BRAM"),
    ),
}
"""By the data file: the kind of core, and the family of a second fit."""


def measure(subject: Design, target: Target) -> dict[str, Any]:
    """Features and resources of one design."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = dict(synthesise(modules(subject, package=False, pins=True), target, folder).resources)
        if (tool := target.family.place_and_route) and target.family.lut == "logic cell":
            run(tool.program, [*target.device, "--json", NETLIST, "--pack-only"], folder, "pack.log")
            (cells,) = re.findall(rf"{''.join(tool.bels['LUT'])}: +(\d+)/", (folder / "pack.log").read_text())
            found["LUT"] = int(cells)
    return {"name": subject.name, "features": asked(subject, target.family), "measured": found}


def asked(subject: Design, family: Family) -> dict[str, float]:
    """Features of one design on ``family``, all blocks together."""
    total = CellCount()
    for block in cell_counts(subject).values():
        total += block
    return features(total, family, subject.architecture.kind)


def fit(rows: list[dict[str, Any]], family: str) -> Prices:
    """Prices that minimise the squares of relative errors, none of them negative."""
    lut = np.array([[row["features"][kind] for kind in KINDS] for row in rows])
    wanted = np.array([row["measured"]["LUT"] for row in rows], dtype=float)
    certain = np.array([row["features"]["table"] for row in rows])
    rates, _ = nnls(lut / wanted[:, None], (wanted - certain) / wanted)
    ff = float(np.mean([row["measured"]["FF"] / row["features"]["ff"] for row in rows]))
    lut_prices = dict(zip(KINDS, rates.round(4).tolist(), strict=True))
    return Prices(family, lut_prices, round(ff, 4), {}, {})


def errors(rows: list[dict[str, Any]], rates: Prices) -> dict[str, Any]:
    """Relative errors of every resource, one for each row."""
    return {
        name: np.array([price(r["features"], rates)[name] / used - 1 for r in rows if (used := r["measured"][name])])
        for name in ("LUT", "FF", "DSP", "BRAM")
    }


def measured(grid: Grid) -> dict[str, Any]:
    """The family, the versions of its tools, and the measurements of all designs; printed as they come."""
    record: dict[str, Any] = {"family": grid.target.family.name, "tools": versions(grid.target.family)}
    for key in ("fitted", "unseen"):
        record[key] = []
        for subject in getattr(grid, key):
            record[key].append(measure(subject, grid.target))
            print(record[key][-1], flush=True)
    return record


def recount(rows: list[dict[str, Any]], subjects: dict[str, tuple[Design, Target]]) -> list[dict[str, Any]]:
    """The stored measurements ``rows``, whose designs are counted again."""
    for row in rows:
        subject, target = subjects[row["name"]]
        row["features"] = asked(subject, target.family)
    return rows


def grid_of(subject: Design, target: Target) -> str:
    """The data file by which a design is estimated."""
    own = f"{subject.architecture.kind}_{target.family.name}"
    return own if own in GRIDS else subject.architecture.kind


def judged(measure_them: bool) -> list[dict[str, Any]]:
    """The rows of the drawn designs, in their order, each with its text and its data file."""
    subjects = {subject.name: (subject, target) for subject, target in drawn()}
    if measure_them:
        rows = [measure(subject, target) for subject, target in subjects.values()]
    else:
        rows = recount(stored(DRAWN)["rows"], subjects)
    for row in rows:
        subject, target = subjects[row["name"]]
        row |= {"text": text(subject, target), "by": grid_of(subject, target), "family": target.family.name}
    return rows


def table(rows: list[dict[str, Any]], rates: dict[str, Prices]) -> str:
    """Markdown: what each drawn design takes, and how far its estimate is from it."""
    lines = [f"| design | {' | '.join(RESOURCES)} |", "|---|" + "---:|" * len(RESOURCES)]
    for row in rows:
        found, cells = price(row["features"], rates[row["by"]]), []
        for name in RESOURCES:
            used = row["measured"][name]
            off = f"{100 * (found[name] / used - 1):+.1f} %" if used else ""
            cells.append(f"{used:,}, {'exact' if found[name] == used else off.replace('-', '−')}")
        lines.append(f"| {row['text']} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Measure or count, fit, write the data files with the largest errors of the uncertain resources, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    everything = [*GRIDS, DRAWN]
    parser.add_argument("--measure", nargs="*", choices=everything, default=everything, help="default: all")
    chosen = parser.parse_args().measure
    rows, fits = judged(DRAWN in chosen), {}
    for key, grid in GRIDS.items():
        path = ROOT / "synth" / f"estimate_{key}.json"
        if key in chosen:
            record = measured(grid)
        else:
            record = json.loads(path.read_text())
            for part in ("fitted", "unseen"):
                subjects = {subject.name: (subject, grid.target) for subject in getattr(grid, part)}
                record[part] = recount(record[part], subjects)
        rates = fits[key] = fit(record["fitted"], record["family"])
        parts = {name: record[name] for name in ("fitted", "unseen")} | {DRAWN: [r for r in rows if r["by"] == key]}
        worst = errors([row for each in parts.values() for row in each], rates)
        error = {name: round(float(max(abs(worst[name]))), 3) for name in grid.uncertain}
        short = {name: round(max(0.0, float(max(1 / (1 + worst[name]) - 1))), 3) for name in grid.uncertain}
        fitted = {"lut": rates.lut, "ff": rates.ff, "error": error, "short": short}
        path.write_text(json.dumps(record | fitted, indent=1) + "\n")
        print(key, rates, error, short)
        for part, each in parts.items():
            for name, found in errors(each, rates).items():
                print(f"{part} {name}: " + ", ".join(f"{e:+.1%}" for e in found))
    publish(DRAWN, {"rows": rows}, table(rows, fits), "docs/synth.md")


if __name__ == "__main__":
    main()
