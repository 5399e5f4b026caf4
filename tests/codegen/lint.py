"""What linters say of generated Verilog."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from pathlib import Path

from tfra.sim.tools import choose, environment


def verilator(verilog: Path, tools: Path, libraries: Iterable[Path] = ()) -> str:
    """Output of Verilator's lint with every warning but those about ``libraries``; ``tools`` is a folder to use."""
    choose("verilator")
    files = [argument for library in libraries for argument in ("-v", str(library))]
    command = ["verilator", "--lint-only", "-Wall", *files, str(verilog)]
    return _said(command, environment("verilator", tools))


def icarus(*verilog: Path) -> str:
    """Output of Icarus with every warning."""
    choose("icarus")
    return _said(["iverilog", "-g2012", "-Wall", "-o", "/dev/null", *map(str, verilog)])


def _said(command: list[str], variables: dict[str, str] | None = None) -> str:
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=False)
    assert bool(done.returncode) <= bool(done.stderr), command
    return done.stderr
