"""``python -m tfra.sim.launch``: cocotb's runner in a separate process with its own environment.

The runner changes ``os.environ``, reads pytest's variables and ends in ``SystemExit``; none of that may happen in the
program that starts a simulation.  Arguments: ``build|test SIMULATOR TOP``, then the sources to build; ``build+waves``
and ``test+waves`` for a simulation that writes ``waves.vcd``.  All happens in the directory that it is started in.
"""

import re
import sys
from pathlib import Path

from cocotb_tools.runner import VerilatorControlFile, get_runner

TIMESCALE = ("1ns", "1ns")

WAVES = "waves.vcd"
"""The file that a simulation with waves writes."""

BUILD_ARGUMENTS: dict[str, list[str]] = {"icarus": [], "verilator": ["-Wno-fatal", "-Wno-lint"]}


def main(arguments: list[str]) -> int:
    """Build or run, and return the exit code: 1, or 128 and the signal that ended a program."""
    action, simulator, top, *sources = arguments
    action, _, waves = action.partition("+")
    runner, here = get_runner(simulator), Path.cwd()
    own = bool(waves) and simulator == "verilator"  # with Icarus, cocotb's runner would write FST
    try:
        if action == "build":
            more = ["-s", "tfra_waves"] if waves and not own else []
            runner.build(
                sources=[VerilatorControlFile(file) if file.endswith(".vlt") else file for file in sources],
                hdl_toplevel=top,
                build_dir=here,
                build_args=[*BUILD_ARGUMENTS[simulator], *more],
                waves=own,
                timescale=TIMESCALE,
                always=True,
            )
        else:
            runner.test(
                test_module="tfra.sim.testbench",
                hdl_toplevel=top,
                hdl_toplevel_lang="verilog",
                build_dir=here,
                test_dir=here,
                test_args=["--trace-file", WAVES] if own else [],
                waves=own,
            )
    except RuntimeError as error:  # what cocotb's runner says of a program that failed
        print(error, file=sys.stderr)
        signal = re.search(r"return code: -(\d+)", str(error))
        return 128 + int(signal[1]) if signal else 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
