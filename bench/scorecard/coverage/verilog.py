"""Points of Verilator's coverage of lines and branches: which were reached, and which can't be."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

_ENTRY = re.compile(r"^C '(.*)' (\d+)$", re.M)
_MODULE = re.compile(r"^module (\w+)\b.*?^endmodule", re.M | re.S)
_ASSIGN = re.compile(r"^  assign (\w+) = (.*);$", re.M)
_CHOICE = re.compile(r" = (.*?) \? ")
_LITERAL = re.compile(r"\d+'s?[hbd][0-9a-fA-Fxz_]+")
_NAME = re.compile(r"\b[A-Za-z_]\w*")
_DEPTH = 3
"""Temporary wires inside of temporary wires that are looked through in the text of a condition."""


@dataclass(frozen=True, order=True)
class Point:
    """A line or a branch of all cores: the ``block`` it is in, its ``kind`` and the condition that decides it.

    Places of a block with the same condition, numbers aside, are one point: cores differ in widths and lengths.
    """

    block: str
    kind: str
    condition: str


def block_of(module: str, cores: Iterable[str]) -> str:
    """A module's name without that of its core and without the numbers that tell instances apart."""
    longest = max((core for core in cores if module == core or module.startswith(f"{core}__")), key=len, default="")
    return re.sub(r"_?\d+(?=__|$)", "", module.removeprefix(longest).removeprefix("__")) or "top"


class Source:
    """A Verilog ``text``: what its choices depend on."""

    def __init__(self, text: str) -> None:
        self._lines = text.splitlines()
        self._wires = {found[1]: dict(_ASSIGN.findall(found[0])) for found in _MODULE.finditer(text)}

    def condition(self, module: str, line: int) -> str:
        """The condition of the choice in a line, its temporary wires replaced by what they are; "" without one.

        It is "constant" where it has no signal.
        """
        found = _CHOICE.search(self._lines[line - 1])
        if not found:
            return ""
        wires = self._wires[module]

        @cache
        def fixed(expression: str) -> bool:
            names = _NAME.findall(_LITERAL.sub("", expression))
            return all(name in wires and fixed(wires[name]) for name in names)

        def told(expression: str, depth: int) -> str:
            def inside(name: re.Match[str]) -> str:
                own = name[0]
                return f"({told(wires[own], depth - 1)})" if own[0] == "_" and own in wires and depth else own

            return _NAME.sub(inside, _LITERAL.sub("#", expression))

        return "constant" if fixed(found[1]) else re.sub(r"\d+", "N", told(found[1], _DEPTH))


def points(data: str, cores: Iterable[str], texts: Mapping[str, str]) -> dict[Point, int]:
    """How often each point of a ``coverage.dat`` was reached; choices that are constant are left out.

    ``texts`` are the Verilog files by name, ``cores`` the names that begin those of their modules.
    """
    sources = {name: Source(text) for name, text in texts.items()}
    found: dict[Point, int] = {}
    for entry, count in _ENTRY.findall(data):
        facts = dict(field.split("\x02", 1) for field in entry.split("\x01") if field)
        file, module = Path(facts["f"]).name, facts["page"].partition("/")[2]
        if file not in sources:  # a model of a device's cell
            continue
        condition = sources[file].condition(module, int(facts["l"])) if facts["o"].startswith("cond") else ""
        if condition != "constant":
            place = condition or f"line {facts['l']} of {module}"
            point = Point(block_of(module, cores), facts["o"], place)
            found[point] = found.get(point, 0) + int(count)
    return found
