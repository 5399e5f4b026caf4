"""Line 12: what linters say of the generated Verilog, and of the sources."""

import subprocess
import sys
import tempfile
from pathlib import Path

from bench.publish import ROOT
from bench.scorecard import linters
from bench.scorecard.line import GATEWARE, Line, Measured, progress
from tfra.codegen.config.read import load
from tfra.codegen.verilog.emit import run_yosys
from tfra.codegen.verilog.files import modules
from tfra.codegen.verilog.wrapper import module_name
from tfra.hdl.cores import microarchitecture
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin, core_of
from tfra.runtime.processes import ToolError

EXAMPLES = ("small", "fast", "balanced", "learned_small", "learned_fast", "learned_resultant", "fingers_32x32")
QUICK = ("small", "learned_small")
PYTHON = {"ruff": ("ruff", "check", "."), "mypy": ("mypy", "--strict", "-p", "tfra", "-p", "bench")}
OTHERS = (
    *("bench", "tests", "docs/tools", "cli", "study", "synth", "sim", "train", "view", "calibrate", "paper"),
    *("recordings", "report", "pyproject.toml"),
)
"""Places of Python that decide no core."""


def verilog(array: Design | Skin, folder: Path) -> dict[str, str]:
    """What each linter says of the core, its wrapper and the pins around them, written into the empty ``folder``."""
    cells = microarchitecture(core_of(array)).cell_models
    pins = "".join(cell.read_text() for cell in cells).replace("$fatal(1, ", "$display(")  # which yosys knows
    (folder / "cells.v").write_text(pins)
    files = []
    for name, text in modules(array, package=True, pins=True).items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
        files += [folder / name] * name.endswith(".v")
    top = f"{module_name(array)}_pins"
    *inner, outer = files
    script = "read_verilog -lib cells.v; " + "".join(f"read_verilog {file.relative_to(folder)}; " for file in files)
    return {
        "verilator": linters.verilator(outer, folder, [*inner, *cells]),
        "icarus": linters.icarus(*files, *cells),
        "slang": linters.slang(*files, *cells),
        "yosys": _yosys(script + f"hierarchy -check -top {top}; proc; check -assert", folder),
    }


def _yosys(script: str, folder: Path) -> str:
    """The complaint of yosys, whose warnings are errors only where asked for, or what it prints."""
    try:
        return run_yosys(script, folder)
    except ToolError as error:
        return str(error)


def python() -> dict[str, str]:
    """What each linter says of the sources in Python."""
    said = {}
    for name, command in PYTHON.items():
        progress(name)
        done = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False)
        said[name] = done.stdout + done.stderr if done.returncode else ""
    return said


def measure(quick: bool) -> Measured:
    """All linters on all examples, or on a few of them, and on the sources."""
    said = python()
    for name in QUICK if quick else EXAMPLES:
        progress(f"Verilog of {name}")
        with tempfile.TemporaryDirectory() as folder:
            found = verilog(load(ROOT / "examples" / f"{name}.toml").array, Path(folder))
        said |= {f"{name}: {linter}": text for linter, text in found.items()}
    loud = {name: text.splitlines()[:5] for name, text in said.items() if text}
    figure = f"{len(loud)} of {len(said)} runs of linters have a warning"
    return Measured(figure, not loud, {"warnings": loud, "off": {"slang": linters.SLANG_OFF}})


LINE = Line(
    12,
    "linters: Verilator -Wall, Icarus -Wall, slang -Wextra, yosys check; ruff, mypy --strict",
    "0 warnings",
    "rules that the head of the Verilog turns off, each with its reason, are not counted, nor are slang's "
    + ", ".join(f"`{name}` ({reason})" for name, reason in linters.SLANG_OFF.items())
    + ".",
    (*GATEWARE, *OTHERS),
    measure,
)
