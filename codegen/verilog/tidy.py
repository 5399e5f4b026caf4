"""A netlist without what has no influence: its Verilog is free of unused signals and of words of unequal length.

Every register, operation and port loses the bits that are not live, and operands have the length of their result.  The
bits of a sum that are rounded off, and those of a memory that nobody reads, remain as wires called ``unused``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby

from tfra.codegen.verilog.liveness import BITWISE, CARRY, Liveness, data_pins, outputs, reached, result_pin
from tfra.codegen.verilog.netlist import Bit, Cell, Module, Wire, Word

_COMPARISONS = frozenset({"$eq", "$ne", "$lt", "$le", "$gt", "$ge"})
_RIGHT = frozenset({"$shr", "$sshr"})
_NEVER_BELOW_ZERO = {"$lt": "0", "$ge": "1"}
"""Results of comparisons of an unsigned word with zero."""


def tidied(modules: dict[str, Module], top: str) -> dict[str, Module]:
    """The modules below ``top`` with live bits only, except for its ports; those of foreign cells are left out."""
    for module in modules.values():
        _replace_constants(module)
    live = Liveness(modules, top).live
    for name, module in modules.items():
        if name != top:
            _mark_copies(module, live[name])
    layouts = {name: _Layout(module, live[name], whole=module.blackbox) for name, module in modules.items()}
    return {name: _Trimmed(module, modules, layouts).made for name, module in modules.items() if not module.blackbox}


def _replace_constants(module: Module) -> None:
    """Make comparisons of unsigned words with zero what they are: constants."""
    left = []
    for cell in module.cells:
        constant = _NEVER_BELOW_ZERO.get(cell.kind)
        if constant and not cell.flag("\\A_SIGNED") and set(cell.pins["\\B"]) <= {"0"}:
            result = cell.pins["\\Y"]
            module.aliases.append((result, [constant, *"0" * (len(result) - 1)]))
        else:
            left.append(cell)
    module.cells = left


def _mark_copies(module: Module, live: bytearray) -> None:
    """Mark live bits that repeat a bit of the same wire by 2: they become a wire, or simulators see a loop."""
    owners = module.owners
    for left, right in module.aliases:
        for to, bit in zip(left, right, strict=True):
            if not isinstance(to, str) and not isinstance(bit, str) and live[to] and owners[to] is owners[bit]:
                live[to] = 2


class _Layout:
    """Where the live bits of a module are: ``pieces`` of its wires, and ``bits``, their numbers; -1: nowhere."""

    def __init__(self, module: Module, live: bytearray, *, whole: bool) -> None:
        self.made = Module(module.name)
        self.bits = [-1] * module.size
        self.pieces: dict[str, list[tuple[Wire, int]]] = {}
        for wire in module.wires.values():
            runs = [(0, wire.width)] if whole else list(_runs(live[wire.first : wire.first + wire.width]))
            self.pieces[wire.name] = [(self._add(wire, low, high, len(runs) > 1), low) for low, high in runs]

    def _add(self, wire: Wire, low: int, high: int, several: bool) -> Wire:
        """Add bits ``low`` to ``high - 1`` of ``wire``."""
        entire = high - low == wire.width
        piece = replace(
            wire,
            name=f"{wire.name}.{low}" if several else wire.name,
            width=high - low,
            offset=wire.offset + low,
            signed=wire.signed and entire,
            init=wire.init[wire.width - high : wire.width - low],
            keep=False,
        )
        piece = self.made.add(piece)
        self.bits[wire.first + low : wire.first + high] = piece.bits
        return piece


def _runs(live: bytearray) -> Iterator[tuple[int, int]]:
    """First and last place, the latter not included, of each run of live bits that are marked alike."""
    low = 0
    for mark, run in groupby(live):
        high = low + sum(1 for _ in run)
        if mark:
            yield low, high
        low = high


class _Trimmed:
    """A module made anew from live bits."""

    def __init__(self, module: Module, modules: dict[str, Module], layouts: dict[str, _Layout]) -> None:
        self._modules, self._layouts, self._layout = modules, layouts, layouts[module.name]
        self.made = self._layout.made
        self._owners = self.made.owners
        self._unused = 0
        for cell in module.cells:
            self.made.cells += self._cell(cell)
        for left, right in module.aliases:
            for places in self._groups(left):
                self.made.aliases.append((self._at(left, places), self._at(right, places)))

    def _cell(self, cell: Cell) -> Iterable[Cell]:
        if cell.kind in self._modules:
            return [self._instance(cell)]
        if not any(self._is_live(bit) for pin in outputs(cell, self._modules) for bit in cell.pins[pin]):
            return []
        if cell.kind in BITWISE:
            return self._bitwise(cell)
        return [_with_widths(self._carrying(cell) if cell.kind in CARRY else self._other(cell))]

    def _bitwise(self, cell: Cell) -> Iterator[Cell]:
        """One cell for each piece of the result."""
        result, data = result_pin(cell), data_pins(cell)
        for number, places in enumerate(self._groups(cell.pins[result])):
            pins = {pin: self._words(word) for pin, word in cell.pins.items() if pin not in data and pin != result}
            pins |= {pin: self._operand(cell, pin, places) for pin in data}
            pins[result] = self._at(cell.pins[result], places)
            yield _with_widths(_unsigned(replace(cell, name=f"{cell.name}.{number}", pins=pins)))

    def _carrying(self, cell: Cell) -> Cell:
        """No bit above the highest live one; a product's factors keep their length, as multipliers want them short."""
        result = cell.pins["\\Y"]
        places = range(1 + max(k for k, bit in enumerate(result) if self._is_live(bit)))
        pins = {pin: self._words(word) for pin, word in cell.pins.items() if pin not in data_pins(cell)}
        pins["\\Y"] = self._driven(result[: len(places)])
        if cell.kind == "$mul":
            pins |= {pin: self._words(cell.pins[pin][: len(places)]) for pin in data_pins(cell)}
            return replace(cell, pins=pins)
        pins |= {pin: self._operand(cell, pin, places) for pin in data_pins(cell)}
        return _unsigned(replace(cell, pins=pins))

    def _other(self, cell: Cell) -> Cell:
        """Operands of a comparison, and the word that is shifted and the result, have the length of the longer one."""
        result = result_pin(cell)
        pins = {pin: self._words(word) for pin, word in cell.pins.items() if pin != result}
        pins[result] = self._driven(cell.pins[result])
        if cell.kind in _COMPARISONS:
            places = range(max(len(cell.pins["\\A"]), len(cell.pins["\\B"])))
            pins |= {pin: self._operand(cell, pin, places) for pin in ("\\A", "\\B")}
        if cell.kind == "$shift" and not cell.flag("\\B_SIGNED"):
            cell = replace(cell, kind="$shr")
        if cell.kind in _RIGHT:
            length = max(len(pins["\\A"]), len(pins["\\Y"]))
            pins["\\A"] = self._operand(cell, "\\A", range(length))
            pins["\\Y"] += self._sink(length - len(pins["\\Y"]))
        return replace(cell, pins=pins)

    def _instance(self, cell: Cell) -> Cell:
        """Ports of other modules are in their pieces; what is not connected is 0 or goes nowhere."""
        child, layout = self._modules[cell.kind], self._layouts[cell.kind]
        pins: dict[str, Word] = {}
        for port in child.ports:
            for piece, low in layout.pieces[port.name]:
                word = cell.pins.get(port.name, [])[low : low + piece.width]
                if port.direction == "input":
                    pins[piece.name] = self._words(word) or ["0"] * piece.width
                else:
                    pins[piece.name] = self._driven(word) or self._sink(piece.width)
        return replace(cell, pins=pins)

    def _is_live(self, bit: Bit) -> bool:
        return not isinstance(bit, str) and self._layout.bits[bit] >= 0

    def _words(self, word: Iterable[Bit]) -> Word:
        """New bits for live ones."""
        return [bit if isinstance(bit, str) else self._layout.bits[bit] for bit in word]

    def _at(self, word: Word, places: Iterable[int]) -> Word:
        return self._words([word[k] for k in places])

    def _operand(self, cell: Cell, pin: str, places: Iterable[int]) -> Word:
        """Bits of an operand at the result's ``places``, extended by its sign or by zeros."""
        word = [*cell.pins[pin], "0"]
        return self._words([word[reached(cell, pin, k)] for k in places])

    def _driven(self, word: Word) -> Word:
        """A result, whose dead bits go nowhere."""
        sink = iter(self._sink(sum(not self._is_live(bit) for bit in word)))
        return [new if self._is_live(bit) else next(sink) for bit, new in zip(word, self._words(word), strict=True)]

    def _sink(self, width: int) -> Word:
        if not width:
            return []
        self._unused += 1
        return list(self.made.add(Wire(f"\\unused_{self._unused}", width, 0)).bits)

    def _groups(self, result: Word) -> Iterator[list[int]]:
        """Live places of a result, those of one wire together."""
        group: list[int] = []
        for place, bit in enumerate(result):
            if isinstance(bit, str) or not self._is_live(bit):
                continue
            if group and self._owner(bit) is not self._owner(result[group[-1]]):
                yield group
                group = []
            group.append(place)
        if group:
            yield group

    def _owner(self, bit: Bit) -> Wire:
        assert not isinstance(bit, str)
        return self._owners[self._layout.bits[bit]]


def _unsigned(cell: Cell) -> Cell:
    """A cell whose operands need no extension any more."""
    flags = {name: "0" for name in ("\\A_SIGNED", "\\B_SIGNED") if name in cell.parameters}
    return replace(cell, parameters=cell.parameters | flags)


def _with_widths(cell: Cell) -> Cell:
    """A cell whose parameters tell the length of its words."""
    widths = {f"{pin}_WIDTH": str(len(word)) for pin, word in cell.pins.items()}
    if "\\WIDTH" in cell.parameters and cell.kind != "$mem_v2":
        widths["\\WIDTH"] = str(len(cell.pins[result_pin(cell)]))
    return replace(cell, parameters={name: widths.get(name, value) for name, value in cell.parameters.items()})
