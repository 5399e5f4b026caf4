"""What linters say of Verilog: "" if nothing."""

import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from tfra.sim.tools import choose, environment

SLANG_OFF = {
    "width-trunc": "operands are extended to the length of the longest, and the result is cut, as Verilog does it",
    "shift-count-overflow": "the last rotations of a CORDIC shift a word by all of its bits, which leaves its sign",
    "unconnected-output-port": "outputs of a device's cell that are not needed are open",
}
"""Warnings of slang's ``-Wextra`` that are off, and why."""

_SLANG = """
import sys
from pyslang.driver import Driver
driver = Driver()
driver.addStandardArgs()
whole = driver.parseCommandLine(" ".join(["slang", *sys.argv[1:]])) and driver.processOptions()
sys.exit(not (whole and driver.parseAllSources() and driver.runFullCompilation(quiet=True)))
"""


def verilator(verilog: Path, tools: Path, cells: Iterable[Path] = ()) -> str:
    """Warnings of Verilator's lint, also of the models of ``cells`` and of other modules; ``tools`` is to be used."""
    choose("verilator")
    models = [argument for cell in cells for argument in ("-v", str(cell))]
    command = ["verilator", "--lint-only", "-Wall", *models, str(verilog)]
    return _said(command, environment("verilator", tools))


def icarus(*verilog: Path) -> str:
    """Warnings of Icarus, all of them."""
    choose("icarus")
    return _said(["iverilog", "-g2012", "-Wall", "-o", "/dev/null", *map(str, verilog)])


def slang(*verilog: Path) -> str:
    """Warnings of slang, but those of ``SLANG_OFF``."""
    off = [f"-Wno-{name}" for name in SLANG_OFF]
    return _said([sys.executable, "-c", _SLANG, "-Wextra", *off, *map(str, verilog)])


def _said(command: list[str], variables: dict[str, str] | None = None) -> str:
    """What a linter writes on stderr, or where it fails without a word there, on stdout."""
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=False)
    return done.stderr or (done.stdout or f"exit code {done.returncode}" if done.returncode else "")
