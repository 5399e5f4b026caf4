"""Modules of a flat-text netlist: RTLIL as yosys writes it, after processes have become cells."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

Bit = int | str
"""A bit of a module's wires by number, or a constant: ``"0"``, ``"1"``, ``"x"`` or ``"z"``."""

Word = list[Bit]
"""Bits of a connection, lowest first."""

_TERM = re.compile(r"([\\$]\S+)(?: \[(\d+)(?::(\d+))?\])?|(\d+'[01xz]*|-?\d+)")
_WIRE = re.compile(r"  wire (?:width (\d+) )?(?:offset (\d+) )?(?:(input|output) (\d+) )?(signed )?(\S+)")
_KEPT = ("init", "keep", "blackbox")
"""Attributes that mean something in Verilog."""


@dataclass(frozen=True)
class Wire:
    """A wire: bit ``k`` of it is the bit ``first + k`` of its module and is called ``offset + k``."""

    name: str
    width: int
    first: int
    offset: int = 0
    direction: str = ""
    place: int = 0
    """Of a port among the ports."""
    signed: bool = False
    init: str = ""
    """Initial value as binary digits, highest first."""
    keep: bool = False

    @property
    def bits(self) -> range:
        """Its bits, lowest first."""
        return range(self.first, self.first + self.width)


@dataclass(frozen=True)
class Cell:
    """An operation, or an instance of another module; names and parameters as in RTLIL."""

    kind: str
    name: str
    parameters: dict[str, str]
    pins: dict[str, Word]

    def flag(self, name: str) -> bool:
        """Whether a parameter of the cell is there and not zero."""
        return self.parameters.get(name, "0") != "0"


@dataclass
class Module:
    """A module; ``aliases`` are the pairs of words of which the first is driven by the second."""

    name: str
    wires: dict[str, Wire] = field(default_factory=dict)
    cells: list[Cell] = field(default_factory=list)
    aliases: list[tuple[Word, Word]] = field(default_factory=list)
    blackbox: bool = False
    size: int = 0
    """Number of bits of all wires."""

    def add(self, wire: Wire) -> Wire:
        """Add a wire behind the others and return it with its first bit."""
        wire = replace(wire, first=self.size)
        self.wires[wire.name] = wire
        self.size += wire.width
        return wire

    @property
    def ports(self) -> list[Wire]:
        """Wires that are ports, in order."""
        return sorted((wire for wire in self.wires.values() if wire.direction), key=lambda wire: wire.place)

    @property
    def owners(self) -> list[Wire]:
        """The wire of every bit."""
        return [wire for wire in self.wires.values() for _ in wire.bits]


def parse(text: str) -> dict[str, Module]:
    """Modules of ``text`` by name; raises ``ValueError`` for a line that no netlist has."""
    modules: dict[str, Module] = {}
    attributes: dict[str, str] = {}
    lines = iter(text.splitlines())
    for line in lines:
        key, _, rest = line.partition(" ")
        if key == "attribute":
            attributes |= _attribute(rest)
        elif key == "module":
            module = modules[rest] = Module(rest, blackbox="blackbox" in attributes)
            attributes = {}
            _fill(module, lines)
        elif line and key not in ("#", "autoidx"):
            raise ValueError(f"netlist: {line!r} is not understood")
    return modules


def _attribute(text: str) -> dict[str, str]:
    name, _, value = text.partition(" ")
    return {name[1:]: value} if name[1:] in _KEPT else {}


def _fill(module: Module, lines: Iterator[str]) -> None:
    """Read the lines of ``module`` up to its end."""
    attributes: dict[str, str] = {}
    for line in lines:
        key, _, rest = line.strip().partition(" ")
        if key == "end":
            return
        if key == "attribute":
            attributes |= _attribute(rest)
            continue
        if key == "wire":
            _add_wire(module, line, attributes)
        elif key == "cell":
            module.cells.append(_cell(module, rest, lines))
        elif key == "connect":
            left, right = _words(module, rest)
            module.aliases.append((left, right))
        elif key != "parameter":
            raise ValueError(f"netlist: {line!r} is not understood")
        attributes = {}


def _add_wire(module: Module, line: str, attributes: dict[str, str]) -> None:
    found = _WIRE.fullmatch(line)
    if not found:
        raise ValueError(f"netlist: {line!r} is not understood")
    width, offset, direction, place, is_signed, name = found.groups()
    init = _binary(attributes["init"]) if "init" in attributes else ""
    module.add(
        Wire(
            name, int(width or 1), 0, int(offset or 0), direction or "", int(place or 0), bool(is_signed), init,
            "keep" in attributes,
        )
    )  # fmt: skip


def _cell(module: Module, head: str, lines: Iterator[str]) -> Cell:
    kind, _, name = head.partition(" ")
    cell = Cell(kind, name, {}, {})
    for line in lines:
        key, _, rest = line.strip().partition(" ")
        if key == "end":
            break
        pin, _, value = rest.partition(" ")
        if key == "parameter":
            cell.parameters[pin] = value
        else:
            (cell.pins[pin],) = _words(module, value)
    return cell


def _words(module: Module, text: str) -> list[Word]:
    """The words of a line, each a term or terms in braces."""
    words: list[Word] = []
    inside = False
    position = 0
    while position < len(text):
        character = text[position]
        if character in " {}":
            if character == "{":
                words.append([])
            inside = character == "{" or (inside and character != "}")
            position += 1
            continue
        found = _TERM.match(text, position)
        if not found:
            raise ValueError(f"netlist: {text!r} is not understood")
        bits = _term(module, found)
        if inside:
            words[-1][:0] = bits
        else:
            words.append(bits)
        position = found.end()
    return words


def _binary(constant: str) -> str:
    """Digits of a constant, highest first; one without a length has 32 bits."""
    return constant.partition("'")[2] if "'" in constant else f"{int(constant) & 0xFFFFFFFF:032b}"


def _term(module: Module, found: re.Match[str]) -> Word:
    name, high, low, constant = found.groups()
    if name is None:
        return list(reversed(_binary(constant)))
    bits = module.wires[name].bits
    if high is None:
        return list(bits)
    return list(bits[int(low or high) : int(high) + 1])


def written(modules: dict[str, Module]) -> str:
    """RTLIL of ``modules``."""
    return "".join(line + "\n" for module in modules.values() for line in _module(module))


def _module(module: Module) -> Iterator[str]:
    if module.blackbox:
        yield "attribute \\blackbox 1"
    yield f"module {module.name}"
    text = _printer(module.owners)
    for wire in module.wires.values():
        if wire.init:
            yield f"  attribute \\init {wire.width}'{wire.init}"
        if wire.keep:
            yield "  attribute \\keep 1"
        port = f"{wire.direction} {wire.place} " if wire.direction else ""
        sign = "signed " if wire.signed else ""
        yield f"  wire width {wire.width} offset {wire.offset} {port}{sign}{wire.name}"
    for cell in module.cells:
        yield f"  cell {cell.kind} {cell.name}"
        yield from (f"    parameter {name} {value}" for name, value in cell.parameters.items())
        yield from (f"    connect {pin} {text(word)}" for pin, word in cell.pins.items())
        yield "  end"
    yield from (f"  connect {text(left)} {text(right)}" for left, right in module.aliases)
    yield "end"


def _printer(owners: list[Wire]) -> Callable[[Word], str]:
    def term(run: Word) -> str:
        if isinstance(run[0], str):
            return f"{len(run)}'{''.join(map(str, reversed(run)))}"
        wire = owners[run[0]]
        if len(run) == wire.width:
            return wire.name
        low = run[0] - wire.first
        return f"{wire.name} [{low + len(run) - 1}:{low}]"

    def follows(before: Bit, bit: Bit) -> bool:
        if isinstance(before, str) or isinstance(bit, str):
            return isinstance(before, str) and isinstance(bit, str)
        return bit == before + 1 and owners[bit] is owners[before]

    def text(word: Word) -> str:
        runs: list[Word] = []
        for bit in word:
            if runs and follows(runs[-1][-1], bit):
                runs[-1].append(bit)
            else:
                runs.append([bit])
        return term(runs[0]) if len(runs) == 1 else "{ " + " ".join(term(run) for run in reversed(runs)) + " }"

    return text
