"""``python -m tfra.sim.launch``: cocotb's runner in a process of its own, with an environment made for it.

The runner changes ``os.environ``, reads pytest's variables and ends in ``SystemExit``; none of that may happen to
the program that wants a simulation.  Arguments: ``build|test SIMULATOR TOP BUILD_DIR``, then the sources to build or
the directory to run in.
"""

from __future__ import annotations

import sys
from pathlib import Path

from cocotb_tools.runner import VerilatorControlFile, get_runner

TIMESCALE = ("1ns", "1ns")

BUILD_ARGUMENTS: dict[str, list[str]] = {"icarus": [], "verilator": ["-Wno-fatal", "-Wno-lint"]}


def main(arguments: list[str]) -> int:
    """Build or run; a failure is an exception or a ``SystemExit`` of cocotb's."""
    action, simulator, top, build_dir, *rest = arguments
    runner = get_runner(simulator)
    if action == "build":
        runner.build(
            sources=[VerilatorControlFile(file) if file.suffix == ".vlt" else file for file in map(Path, rest)],
            hdl_toplevel=top,
            build_dir=build_dir,
            build_args=BUILD_ARGUMENTS[simulator],
            timescale=TIMESCALE,
            always=True,
        )
    else:
        runner.test(
            test_module="tfra.sim.testbench",
            hdl_toplevel=top,
            hdl_toplevel_lang="verilog",
            build_dir=build_dir,
            test_dir=rest[0],
        )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
