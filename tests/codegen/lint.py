"""What linters say of generated Verilog."""

import subprocess
from collections.abc import Iterable
from pathlib import Path

from tfra.sim.tools import choose, environment


def verilator(verilog: Path, tools: Path, cells: Iterable[Path] = ()) -> str:
    """Warnings of Verilator's lint, also of the models of ``cells``; ``tools`` is a folder to use."""
    choose("verilator")
    models = [argument for cell in cells for argument in ("-v", str(cell))]
    command = ["verilator", "--lint-only", "-Wall", *models, str(verilog)]
    return _said(command, environment("verilator", tools))


def icarus(*verilog: Path) -> str:
    """Warnings of Icarus, all of them."""
    choose("icarus")
    return _said(["iverilog", "-g2012", "-Wall", "-o", "/dev/null", *map(str, verilog)])


def _said(command: list[str], variables: dict[str, str] | None = None) -> str:
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=False)
    assert bool(done.returncode) <= bool(done.stderr), command
    return done.stderr
