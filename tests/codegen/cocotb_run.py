"""A cocotb test module on Verilog in a folder: compiled and run in a process of its own.

``python -m tests.codegen.cocotb_run MODULE SIMULATOR TOP SOURCES`` does it in the working directory.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from cocotb_tools.runner import VerilatorControlFile, get_runner

from tfra.sim.launch import BUILD_ARGUMENTS, TIMESCALE
from tfra.sim.tools import choose, environment, public_signals

ROOT = Path(__file__).parents[2]


def outcome(module: str, simulator: str, folder: Path, top: str, *sources: str) -> Any:
    """What the tests of ``module`` write to ``outcome.json`` of the ``folder`` with the ``sources``."""
    variables = {**environment(choose(simulator), folder), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "tests.codegen.cocotb_run", module, simulator, top, *sources]
    done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, check=False)
    assert (folder / "outcome.json").exists(), (done.stdout + done.stderr)[-4000:]
    return json.loads((folder / "outcome.json").read_text())


def main(module: str, simulator: str, top: str, *names: str) -> None:
    """Compile and run; raises ``SystemExit`` or ``RuntimeError`` for what fails."""
    folder = Path.cwd()
    sources: list[Any] = [folder / name for name in names]
    if simulator == "verilator":
        (folder / "public.vlt").write_text(public_signals(top, ()))
        sources.append(VerilatorControlFile(folder / "public.vlt"))
    runner, places = get_runner(simulator), {"build_dir": folder, "hdl_toplevel": top}
    options: dict[str, Any] = {"build_args": BUILD_ARGUMENTS[simulator], "timescale": TIMESCALE}
    runner.build(sources=sources, defines={"SYNTHESIS": 1}, always=True, **options, **places)
    runner.test(test_module=module, hdl_toplevel_lang="verilog", test_dir=folder, **places)


if __name__ == "__main__":
    main(*sys.argv[1:])
