"""What every writer of a package's files reads."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from string import Template
from typing import Any

from tfra.codegen.registers.files import VENDOR
from tfra.codegen.registers.source import registers_of
from tfra.codegen.verilog.files import fingerprint
from tfra.codegen.verilog.wrapper import module_name
from tfra.families import Target
from tfra.hdl.bus.map import RegisterMap
from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.primitives import cell_models
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin, core_of

_MEASURED = files("tfra.codegen.package").joinpath("measured.json")
"""Reports of ``tfra synth``, shortened: written by ``bench.parts.presets``."""


def placed() -> list[dict[str, Any]]:
    """What the tools have made of the presets on their parts, as ``tfra synth`` reported it."""
    rows: list[dict[str, Any]] = json.loads(_MEASURED.read_text("utf-8"))
    return rows


@dataclass(frozen=True)
class Part:
    """The device that a package describes its core for: a target, and what the core takes of it.

    ``resources``: by name, how many the core takes, and how many the part has; ``basis``: what these numbers are.
    """

    target: Target
    resources: Mapping[str, tuple[int, int]]
    basis: str

    @property
    def fits(self) -> bool:
        """Whether the part has room for it."""
        return all(used <= there for used, there in self.resources.values())


@dataclass(frozen=True)
class Contents:
    """A design or a skin, the ``facts`` of its sidecar, its part, and the ``texts`` of files that are there already."""

    array: Design | Skin
    facts: Mapping[str, Any]
    texts: Mapping[str, str]
    part: Part

    @property
    def design(self) -> Design:
        """That of the only core, or of a skin's window."""
        return core_of(self.array)

    @property
    def name(self) -> str:
        """The core's name; that of the wrapper is ``wrapper``."""
        return self.array.name

    @property
    def wrapper(self) -> str:
        """The module with buses around the core, in a file of the same name."""
        return module_name(self.array)

    @cached_property
    def core(self) -> Microarchitecture:
        """The only core, or that of a skin's window, for its cycles and its coefficients."""
        return microarchitecture(self.design)

    @cached_property
    def registers(self) -> RegisterMap:
        """The register map with the values of this design."""
        return registers_of(self.array)

    @property
    def rtl(self) -> list[str]:
        """Files of the modules to synthesise."""
        return [f"{self.name}.v", f"{self.wrapper}.v"]

    @property
    def images(self) -> list[str]:
        """Files that the core reads its memories' contents from."""
        return [image["file"] for image in self.facts["images"]]

    @property
    def cells(self) -> dict[str, str]:
        """Models of the device's cells for simulators, by their names in the package."""
        found = {*self.core.cell_models, *cell_models(self.design.target, "multiplier", "rom")}
        return {f"testbench/{file.name}": file.read_text() for file in sorted(found)}

    @cached_property
    def measurements(self) -> dict[str, Mapping[str, Any]]:
        """By target, what the tools have made of just this Verilog: of core and wrapper, else of the core."""
        core = [self.texts[name] for name in [self.rtl[0], *self.images] if name in self.texts]
        behind, rows = [*core, self.texts.get(self.rtl[1], "")], placed()
        prints = [fingerprint(each) for each in (core, behind)]
        return {row["target"]: row for each in prints for row in rows if row["netlist"] == each}

    @property
    def measured(self) -> Mapping[str, Any] | None:
        """That of place and route on this part; None if it was not run."""
        return self.measurements.get(self.part.target.name)

    @property
    def clock_mhz(self) -> float:
        """The clock of times: as measured, else the target's default."""
        return float(self.measured["clock"]["median_mhz"]) if self.measured else self.part.target.clock_mhz

    def microseconds(self, cycles: int) -> float:
        """Time of ``cycles``."""
        return cycles / self.clock_mhz

    def fill(self, file: str, **values: object) -> str:
        """The ``file`` of ``templates`` with ``values`` and those of all templates for its placeholders."""
        target, version = self.part.target, self.facts["generator"].rpartition(" ")[2]
        common = {
            "name": self.name,
            "wrapper": self.wrapper,
            "vendor": VENDOR,
            "generator": self.facts["generator"],
            "version": version,
            "release": ".".join(version.split(".")[:2]),
            "computes": self.facts["computes"],
            "images": " ".join(self.images),
            "part": target.name,
            "mhz": f"{self.clock_mhz:.1f}",
            "period": f"{1000 / self.clock_mhz:.3f}",
        }
        return Template(template(file)).substitute(common | values)


def template(name: str) -> str:
    """The text of a file in this folder's ``templates``."""
    return files("tfra.codegen.package").joinpath("templates", name).read_text("utf-8")
