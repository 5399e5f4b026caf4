"""The name of a core: a Verilog identifier that is neither a keyword nor the name of a port."""

import re

from tfra.codegen.config.keywords import KEYWORDS, PACKAGED, SIMULATORS

PORTS = frozenset(
    {
        *("clk", "rst", "taxel_data", "taxel_valid", "taxel_ready", "load_data", "load_valid", "load_ready"),
        *("result_data", "result_last", "result_valid", "result_ready"),
    }
)
"""Ports of the top module; Verilator confuses them with a module of the same name."""

_INNER = "__core"
"""What follows a core's name in those of its modules; without it, cores of different names share no module."""

_LONGEST_STEM = 60


def name_from(stem: str) -> str:
    """Make the ``stem`` of a CONFIG file a name; raises ``ValueError`` (``name: ...``) for a word that is taken."""
    name = re.sub(r"[^A-Za-z0-9_]", "_", stem)[:_LONGEST_STEM]
    name = name if name[:1].isalpha() else f"s_{name}"
    if word := _taken(name):
        raise ValueError(f'name: is missing, and the file\'s own, "{name}", is {word}: set another one')
    return name


def checked(name: str) -> str:
    """Return ``name``; raises ``ValueError`` (``name: ...``) for a word that is taken."""
    if word := _taken(name):
        raise ValueError(f'name: "{name}" is {word}')
    return name


def check_packaged(name: str) -> None:
    """Raise ``ValueError`` (``name: ...``) for a word that one of a package's languages keeps for itself.

    VHDL knows no case, and has no names with two underscores in a row or one at the end.
    """
    for language, words in PACKAGED.items():
        if (name.lower() if language == "VHDL" else name) in words:
            raise ValueError(f'name: "{name}" is a keyword of {language}, which a package is used in')
    if "__" in name or name.endswith("_"):
        raise ValueError(f'name: "{name}" is no name in VHDL, which has no "__" and no "_" at the end')


def _taken(name: str) -> str:
    if name in KEYWORDS:
        return "a keyword of Verilog"
    if name in SIMULATORS:
        return "a keyword of Verilog simulators"
    if _INNER in name:
        return "like a module inside of a core"
    return "a port of the core" if name in PORTS else ""
