"""Fit the prices of ``tfra.synth.estimate`` to syntheses, and write its data files.

``python -m bench.parts.estimates [--kind serial] [--refit]`` synthesises every design of a grid, by default of both
kinds of cores; those that are not fitted are compared with the fit, and so are the twelve of :mod:`bench.parts.drawn`,
of which docs/synth.md has a table.  With ``--refit`` the stored designs are counted anew, but not synthesised.

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

from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.codegen.verilog.files import modules
from tfra.families import Family, Target, find
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.cell_count import CellCount, cell_counts
from tfra.synth.estimate import KINDS, Prices, features, price
from tfra.synth.flow import NETLIST, synthesise
from tfra.synth.tools import run, versions


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


def serial(rows: int, columns: int, **others: Any) -> Design:
    """A serial core on such a grid."""
    return _design(f"s{rows}x{columns}", rows, columns, architecture=SERIAL, target="ice40", **others)


def _design(name: str, rows: int, columns: int, **others: Any) -> Design:
    return TfraDesign(SensorArray(rows, columns, 4e-3, 2e-3, 3e-3), name=name, **others)


def preset(name: str) -> Design:
    """A preset in `examples/`, as it is packaged."""
    return load(ROOT / "examples" / f"{name}.toml").design


def drawn(seed: int) -> Design:
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
        ),
        (
            *(parallel(6, 4, 24, search=Search(30)), parallel(7, 9, 32), parallel(10, 10, 16)),
            *(preset("fast"), drawn(1), drawn(2)),
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
}
"""By the kind of core."""


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
    return Prices(family, TfraDesign.estimator, lut_prices, round(ff, 4), {}, {})


def errors(rows: list[dict[str, Any]], rates: Prices) -> dict[str, Any]:
    """Relative errors of every resource, one for each row."""
    return {
        name: np.array([price(r["features"], rates)[name] / used - 1 for r in rows if (used := r["measured"][name])])
        for name in ("LUT", "FF", "DSP", "BRAM")
    }


def measured(grid: Grid) -> dict[str, Any]:
    """The family, the versions of its tools, and the measurements of all designs; printed as they come."""
    family = grid.target.family
    record: dict[str, Any] = {"family": family.name, "estimator": TfraDesign.estimator, "tools": versions(family)}
    for key in ("fitted", "unseen"):
        record[key] = []
        for subject in getattr(grid, key):
            record[key].append(measure(subject, grid.target))
            print(record[key][-1], flush=True)
    return record


def recount(record: dict[str, Any], grid: Grid) -> dict[str, Any]:
    """The stored measurements, whose designs are counted again."""
    by_name = {subject.name: subject for subject in (*grid.fitted, *grid.unseen)}
    for row in (*record["fitted"], *record["unseen"]):
        row["features"] = asked(by_name[row["name"]], grid.target.family)
    return record


def main() -> None:
    """Measure or count, fit, write the data file with the largest errors of the uncertain resources, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", choices=list(GRIDS), help="default: both")
    parser.add_argument("--refit", action="store_true", help="fit the stored measurements again")
    options = parser.parse_args()
    for kind in [options.kind] if options.kind else GRIDS:
        path, grid = ROOT / "synth" / f"estimate_{kind}.json", GRIDS[kind]
        record = recount(json.loads(path.read_text()), grid) if options.refit else measured(grid)
        rates = fit(record["fitted"], record["family"])
        worst = errors([*record["fitted"], *record["unseen"]], rates)
        error = {name: round(float(max(abs(worst[name]))), 3) for name in grid.uncertain}
        short = {name: round(max(0.0, float(max(1 / (1 + worst[name]) - 1))), 3) for name in grid.uncertain}
        fitted = {"lut": rates.lut, "ff": rates.ff, "error": error, "short": short}
        path.write_text(json.dumps(record | fitted, indent=1) + "\n")
        print(rates, error, short)
        for key in ("fitted", "unseen"):
            for name, found in errors(record[key], rates).items():
                print(f"{key} {name}: " + ", ".join(f"{e:+.1%}" for e in found))


if __name__ == "__main__":
    main()
