"""Baselines of resources and frequency: ``python -m bench.parts.baselines [NAME ...]`` measures and writes them.

A baseline is a file in ``bench/baselines``, an object: a key made of the tools' versions, then ``resources`` and
``mhz``.  New versions of tools are added to it.
"""

import json
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from amaranth import Const, Value

from bench.publish import ROOT
from tfra.codegen.verilog.emit import to_rtlil
from tfra.codegen.verilog.files import modules
from tfra.families import find
from tfra.hdl.parallel.cordic import Cordic
from tfra.model.choices import Architecture
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.flow import route, synthesise
from tfra.synth.report import clock_facts, median_route, resource_facts
from tfra.synth.tools import versions

FOLDER = ROOT / "bench" / "baselines"

GROWTH = 0.05
"""A resource may grow by this share before it counts as a regression."""
SLOWDOWN = 0.15
"""The frequency may fall by this share, since seeds differ by several per cent."""

REMEASURE = "make baselines"


def core(rows: int, columns: int, mac: int) -> Design:
    """A core on a grid of 4 mm x 2 mm."""
    return TfraDesign(SensorArray(rows, columns, 4e-3, 2e-3, 3e-3), name="core", architecture=Architecture(mac))


def cordic() -> dict[str, str]:
    """One block, whose output never waits: a constant is no port."""
    block = Cordic(SMALL)
    members = (Value.cast(value) for _, _, value in block.signature.flatten(block))
    return {"cordic.il": to_rtlil(block, "cordic", [value for value in members if not isinstance(value, Const)])}


@dataclass(frozen=True)
class Subject:
    """What is measured: modules, on a target, with seeds 1 to ``seeds``; none: yosys alone."""

    modules: Callable[[], Mapping[str, str]]
    target: str
    seeds: int


SMALL, LARGE = core(4, 4, 4), core(10, 10, 16)

SUBJECTS = {
    "cordic": Subject(cordic, "ecp5-25", 1),
    "small_cells": Subject(lambda: modules(SMALL, package=False, pins=True), "ecp5-25", 0),
    "small": Subject(lambda: modules(SMALL, package=False, pins=True), "ecp5-45", 3),
    "large_cells": Subject(lambda: modules(LARGE, package=False, pins=True), "ecp5-85", 0),
}
"""By name; the first is small enough for a test, the second takes a minute, the others are for ``make baselines``."""


def measure(subject: Subject) -> dict[str, Any]:
    """The parts of a report that :func:`compare` looks at."""
    target = find(subject.target)
    with tempfile.TemporaryDirectory() as folder:
        synthesis = synthesise(subject.modules(), target, Path(folder))
        routes = [route(target, Path(folder), seed, target.clock_mhz) for seed in range(1, subject.seeds + 1)]
    used = median_route(routes).resources if routes else synthesis.resources
    return {
        "resources": resource_facts(target, used),
        "clock": clock_facts(routes) if routes else None,
        "tools": versions(target.family),
    }


def key(tools: Mapping[str, str]) -> str:
    """The baseline's name of these versions."""
    return ", ".join(f"{name} {number}" for name, number in sorted(tools.items()))


def entry(found: Mapping[str, Any]) -> dict[str, Any]:
    """The part of a report that a baseline keeps."""
    clock = found["clock"]
    return {
        "resources": {name: row["used"] for name, row in found["resources"].items()},
        "mhz": clock["median_mhz"] if clock else None,
    }


def compare(found: Mapping[str, Any], baselines: Mapping[str, Any]) -> list[str]:
    """Sentences on regressions from the baseline of the same tools; empty if there is none.

    Raises ``ValueError``, with the command that measures anew, for versions without a baseline.
    """
    version = key(found["tools"])
    if version not in baselines:
        raise ValueError(f"there is no baseline of {version}: {REMEASURE}")
    old, new = baselines[version], entry(found)
    worse = [
        f"{name}: {used:,}, the baseline has {before:,}"
        for name, used in new["resources"].items()
        if used > (before := old["resources"][name]) * (1 + GROWTH)
    ]
    if new["mhz"] is not None and new["mhz"] < old["mhz"] * (1 - SLOWDOWN):
        worse.append(f"Fmax: {new['mhz']} MHz, the baseline has {old['mhz']} MHz")
    return worse


def main(names: list[str]) -> None:
    """Measure the subjects ``names``, or all, and store what they took."""
    FOLDER.mkdir(exist_ok=True)
    for name in names or SUBJECTS:
        found = measure(SUBJECTS[name])
        path = FOLDER / f"{name}.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        path.write_text(json.dumps({**known, key(found["tools"]): entry(found)}, indent=1) + "\n")
        print(name, entry(found), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
