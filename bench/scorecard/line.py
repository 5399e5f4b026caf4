"""Lines of the scorecard: what is measured, how it is judged, and the sources that it depends on."""

import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from typing import Any

from bench.publish import ROOT
from tfra.runtime.digest import digest
from tfra.sim.tools import versions

GATEWARE = ("codegen", "families", "hdl", "model", "runtime", "examples")
"""Folders that decide a core and its model."""


@dataclass(frozen=True)
class Measured:
    """A ``figure`` in words, whether it reaches the target, and the facts behind it, plain JSON."""

    figure: str
    passed: bool
    facts: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Line:
    """A line; ``measure`` takes whether it has to be quick, and is None where nothing measures the line yet.

    ``limits`` says in a sentence what the figure does not tell.  ``sources`` are files and folders below the root: a
    result is kept until one of them, this module or the version of a tool changes.  Links are left out.
    """

    number: int
    title: str
    target: str
    limits: str = ""
    sources: tuple[str, ...] = ()
    measure: Callable[[bool], Measured] | None = None

    def key(self, quick: bool) -> str:
        """The hash of all that decides the result; a quick one has another."""
        places = [ROOT / place for place in (*self.sources, "bench/scorecard/line.py")]
        files = sorted(file for place in places for file in (place.rglob("*") if place.is_dir() else [place]))
        hashes = (
            f"{file.relative_to(ROOT)} {sha256(file.read_bytes()).hexdigest()}"
            for file in files
            if file.is_file() and not file.is_symlink() and not {"__pycache__", "results"} & {*file.parts}
        )
        return digest(self.title, self.target, str(quick), sys.version, versions(), *hashes)

    def facts(self) -> dict[str, Any]:
        """What is stored of the line itself."""
        kept = asdict(self)
        return {name: kept[name] for name in ("number", "title", "target", "limits")}


def command(number: int, quick: bool = False) -> str:
    """The command that measures a line."""
    return f"python -m bench.scorecard.run --only {number}" + " --quick" * quick


def progress(text: str) -> None:
    """Tell what happens now."""
    print(f"  {text}", flush=True)
