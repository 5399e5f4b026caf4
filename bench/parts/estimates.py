"""Fit the prices of ``tfra.synth.estimate`` to syntheses: ``python -m bench.parts.estimates`` writes its data file.

Every design of the grid is synthesised for ECP5; those of ``UNSEEN`` are not fitted but compared with the fit.
"""

import json
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import nnls

from bench.publish import ROOT
from tfra.families import Family, find
from tfra.model.choices import FORMATS, Adc, Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.cell_count import CellCount, cell_counts
from tfra.synth.estimate import KINDS, Prices, features, price
from tfra.synth.flow import synthesise
from tfra.synth.run import netlist
from tfra.synth.tools import versions

DATA = ROOT / "synth" / "estimate_parallel.json"
TARGET = find("ecp5-85")


def design(rows: int, columns: int, mac: int, **others: Any) -> Design:
    """A core on a grid of 4 mm x 2 mm."""
    sensor = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)
    return TfraDesign(sensor, name=f"a{rows}x{columns}_l{mac}", architecture=Architecture(mac), **others)


FITTED = (
    design(4, 4, 4),
    design(2, 2, 4),
    design(3, 5, 4, adc=Adc(10)),
    design(3, 3, 4, formats=replace(FORMATS["wide"], name="custom")),
    design(4, 6, 8, search=Search(100, 3.0)),
    design(5, 5, 12),
)
UNSEEN = (
    design(6, 4, 24, search=Search(30)),
    design(7, 9, 32),
    design(10, 10, 16),
)


def measure(subject: Design) -> dict[str, Any]:
    """Features and resources of one design."""
    with tempfile.TemporaryDirectory() as folder:
        found = synthesise(netlist(subject, TARGET), subject.name, TARGET, Path(folder))
    return {"name": subject.name, "features": asked(subject), "measured": dict(found.resources)}


def asked(subject: Design, family: Family = TARGET.family) -> dict[str, float]:
    """Features of one design on ``family``, all blocks together."""
    total = CellCount()
    for block in cell_counts(subject).values():
        total += block
    return features(total, family, subject.architecture.kind)


def recount(path: Path, designs: Sequence[Design], family: Family) -> dict[str, Any]:
    """The stored measurements of ``designs``, which are counted again, not synthesised."""
    record: dict[str, Any] = json.loads(path.read_text())
    by_name = {subject.name: subject for subject in designs}
    for row in (*record["fitted"], *record["unseen"]):
        row["features"] = asked(by_name[row["name"]], family)
    return record


def fit(rows: list[dict[str, Any]], family: str) -> Prices:
    """Prices that minimise the squares of relative errors, none of them negative."""
    lut = np.array([[row["features"][kind] for kind in KINDS] for row in rows])
    wanted = np.array([row["measured"]["LUT"] for row in rows], dtype=float)
    certain = np.array([row["features"]["table"] for row in rows])
    rates, _ = nnls(lut / wanted[:, None], (wanted - certain) / wanted)
    ff = float(np.mean([row["measured"]["FF"] / row["features"]["ff"] for row in rows]))
    lut_prices = dict(zip(KINDS, rates.round(4).tolist(), strict=True))
    return Prices(family, TfraDesign.estimator, lut_prices, round(ff, 4), {})


def errors(rows: list[dict[str, Any]], rates: Prices) -> dict[str, Any]:
    """Relative errors of every resource, one for each row."""
    return {
        name: np.array([price(r["features"], rates)[name] / used - 1 for r in rows if (used := r["measured"][name])])
        for name in ("LUT", "FF", "DSP", "BRAM")
    }


def main(arguments: list[str]) -> None:
    """Measure, fit, write and print; with ``--refit`` the designs are counted anew, but not synthesised."""
    designs = {"fitted": FITTED, "unseen": UNSEEN}
    conclude(measured(arguments, DATA, designs, TARGET.family, measure), DATA, ("LUT", "FF"))


def measured(
    arguments: list[str],
    path: Path,
    designs: Mapping[str, Sequence[Design]],
    family: Family,
    measure: Callable[[Design], dict[str, Any]],
) -> dict[str, Any]:
    """The family, the versions of its tools, and what :func:`measure` returns for all ``designs``; printed as it comes.

    With ``--refit`` these are the measurements in the file ``path``, and only the designs' features are new.
    """
    if arguments == ["--refit"]:
        return recount(path, [subject for part in designs.values() for subject in part], family)
    record: dict[str, Any] = {"family": family.name, "estimator": TfraDesign.estimator, "tools": versions(family)}
    for key, subjects in designs.items():
        record[key] = []
        for subject in subjects:
            record[key].append(measure(subject))
            print(record[key][-1], flush=True)
    return record


def conclude(record: dict[str, Any], path: Path, uncertain: tuple[str, ...]) -> None:
    """Fit, write the data file ``path`` with the largest errors of the ``uncertain`` resources, and print."""
    rates = fit(record["fitted"], record["family"])
    worst = errors([*record["fitted"], *record["unseen"]], rates)
    error = {name: round(float(max(abs(worst[name]))), 3) for name in uncertain}
    path.write_text(json.dumps(record | {"lut": rates.lut, "ff": rates.ff, "error": error}, indent=1) + "\n")
    print(rates, error)
    for key in ("fitted", "unseen"):
        for name, found in errors(record[key], rates).items():
            print(f"{key} {name}: " + ", ".join(f"{e:+.1%}" for e in found))


if __name__ == "__main__":
    main(sys.argv[1:])
