"""``tfra synth``: writes a directory of the report, the logs and, if the tools can make one, the bitstream."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tfra import families, synth
from tfra.codegen.verilog.files import fingerprint, modules
from tfra.families import Target
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin, core_of
from tfra.runtime.digest import digest, sources
from tfra.runtime.outputs import output_directory
from tfra.runtime.store import cached_step
from tfra.synth.estimate import Estimate, estimate, misfits
from tfra.synth.flow import NETLIST, CriticalPath, Route, Synthesis, options, pack, route, synthesise
from tfra.synth.page import page, render
from tfra.synth.report import median_route, report
from tfra.synth.tools import programs, require, versions

SIDECAR = "report.json"

FIXED_S = 10.0
"""Seconds that a tool needs for the smallest core."""
YOSYS_S, SEED_S, BITSTREAM_S = 2e-3, 15e-3, 5e-5
"""Seconds for each lookup table, as PyPI's tools took on one machine: their shares are the steps' in the progress."""


@dataclass
class Run:
    """One core, or skin, on one part, behind its buses with ``package``, with the tools' results so far.

    ``advance`` is called with the seconds expected of what has ended and of all steps, and with the step's name.
    """

    array: Design | Skin
    target: Target
    seeds: int
    clock_mhz: float
    advance: Callable[[int, int, str], None]
    package: bool = False
    estimated: Estimate | None = None
    synthesis: Synthesis | None = None
    routes: list[Route] = field(default_factory=list)
    expected: int = 0
    netlist: str = ""

    def write(self, directory: Path, inputs: Sequence[Path] = ()) -> dict[str, Any]:
        """Synthesise, place and route with seeds 1 to ``seeds``, and return the report.

        Writes ``index.html``, ``report.json``, ``report.txt``, a log of every tool and the bitstream of the median
        seed into ``directory``, all or nothing; ``inputs`` are files that the design comes from.  The results of
        finished tools are kept: after an interruption, the same call continues there.  Raises ``InputError`` for a
        missing tool or a directory that can't be written, ``ValueError`` for a design that does not fit or is made of
        another family's cells, :class:`ToolError`.
        """
        if (made_of := core_of(self.array).target) not in ("portable", self.target.family.name):
            raise ValueError(f"target.name: {self.target.name} has no cells of {made_of}")
        require(programs(self.target.family))
        with output_directory(directory, "synth", inputs) as fresh:
            self._implement(fresh)
            found = self.report()
            (fresh / "report.txt").write_text(render(found))
            (fresh / "index.html").write_text(page(found), encoding="utf-8")
            (fresh / SIDECAR).write_text(json.dumps(found, indent=1) + "\n")
        return found

    def report(self) -> dict[str, Any]:
        """The report so far; raises ``ValueError`` before yosys has finished."""
        if self.synthesis is None or self.estimated is None:
            raise ValueError("yosys has not finished")
        return report(
            self.array,
            self.target,
            self.synthesis,
            self.routes,
            self.estimated,
            self.wanted,
            package=self.package,
            netlist=self.netlist,
            asked_mhz=self.clock_mhz,
        )

    @property
    def wanted(self) -> int:
        """Seeds to be placed and routed: none where only yosys runs."""
        return self.seeds if self.target.family.place_and_route else 0

    def _implement(self, fresh: Path) -> None:
        """Run the tools in the directory ``fresh``."""
        self.estimated = estimate(self.array, self.target.family, package=self.package)
        total = self.estimated.total
        if lacks := misfits(total, self.target, core_of(self.array).architecture.kind):
            raise ValueError(lacks[0])
        yosys, seed_s, bitstream = (round(FIXED_S + each * total["LUT"]) for each in (YOSYS_S, SEED_S, BITSTREAM_S))
        self.expected = yosys + (self.wanted * seed_s + bitstream if self.wanted else 0)
        key = self._synthesise(fresh, yosys)
        for seed in range(1, self.wanted + 1):
            self.routes.append(self._route(fresh, key, seed, seed_s))
        if self.routes:
            self.advance(0, self.expected, "bitstream")
            pack(self.target, fresh, median_route(self.routes).seed, self.array.name)
        for leftover in [fresh / NETLIST, *fresh.glob("*.layout")]:
            leftover.unlink()

    def _synthesise(self, fresh: Path, seconds: int) -> str:
        """Run yosys; returns the key of its netlist."""
        family, pins = self.target.family, bool(self.wanted)
        texts = modules(self.array, package=self.package, pins=pins)
        self.netlist = fingerprint(text for name, text in texts.items() if not name.endswith("_pins.v"))
        programs = map(repr, (versions(family), options(family)))
        key = digest(*texts.values(), repr(self.target), *programs, *sources(families, synth))

        def step() -> dict[str, Any]:
            return asdict(synthesise(texts, self.target, fresh))

        self.synthesis = Synthesis(**self._cached("yosys", "yosys", seconds, key, fresh, step))
        return key

    def _route(self, fresh: Path, key: str, seed: int, seconds: int) -> Route:
        def step() -> dict[str, Any]:
            return asdict(route(self.target, fresh, seed, self.clock_mhz))

        key = digest(key, str(seed), repr(self.clock_mhz))
        found = self._cached("route", f"place and route, seed {seed}", seconds, key, fresh, step)
        return Route(**{**found, "path": CriticalPath(**found["path"])})

    def _cached(
        self, name: str, title: str, seconds: int, key: str, fresh: Path, step: Callable[[], dict[str, Any]]
    ) -> dict[str, Any]:
        """The result of ``step``, new or from the cache; then it counts for nothing in the progress."""
        self.advance(0, self.expected, title)
        result, cached = cached_step(f"{name}-{self.array.name}", key, fresh, step)
        self.expected -= seconds * cached
        self.advance(seconds * (not cached), self.expected, title)
        return result
