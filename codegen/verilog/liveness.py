"""Which bits of a netlist have an influence on the core's outputs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from tfra.codegen.verilog.netlist import Bit, Cell, Module

BITWISE = frozenset({"$and", "$or", "$xor", "$xnor", "$not", "$mux", "$dff", "$pos"})
"""Bit i of the result depends on bit i of the data alone."""

CARRY = frozenset({"$add", "$sub", "$mul", "$neg", "$shl", "$sshl"})
"""Bit i of the result depends on bits 0 to i of the data."""

OTHERS = frozenset(
    {
        *("$eq", "$ne", "$lt", "$le", "$gt", "$ge", "$logic_not", "$logic_and", "$logic_or"),
        *("$reduce_and", "$reduce_or", "$reduce_xor", "$reduce_bool", "$shr", "$sshr", "$shift", "$shiftx", "$mem_v2"),
    }
)
"""Any bit of the result depends on all of the data."""

RESULTS = {"$dff": "\\Q", "$mem_v2": "\\RD_DATA"}
"""Where a result is, if not at the pin Y."""

_DATA = {"$dff": ("\\D",), "$shl": ("\\A",), "$sshl": ("\\A",)}

Driver = tuple[Cell, str, int] | Bit
"""What drives a bit: the place of a cell's pin, or the bit of an alias."""


def data_pins(cell: Cell) -> tuple[str, ...]:
    """Pins of a bitwise or carrying operation whose bits have the places of the result's."""
    return _DATA.get(cell.kind, tuple(pin for pin in ("\\A", "\\B") if pin in cell.pins))


def result_pin(cell: Cell) -> str:
    """The pin of an operation with its result."""
    return RESULTS.get(cell.kind, "\\Y")


def reached(cell: Cell, pin: str, place: int) -> int:
    """The place of an operand's bit that is bit ``place`` of the operand as the operation extends it; -1: a constant
    zero."""
    width = len(cell.pins[pin])
    if place < width:
        return place
    return width - 1 if cell.flag(f"{pin}_SIGNED") else -1


class Liveness:
    """Live bits of every module below ``top``: ``live[module][bit]`` is 1."""

    def __init__(self, modules: dict[str, Module], top: str) -> None:
        self._modules = modules
        self.live = {name: bytearray(module.size) for name, module in modules.items()}
        self._drivers = {name: _drivers(module, modules) for name, module in modules.items()}
        self._parents: dict[str, list[tuple[str, Cell]]] = {name: [] for name in modules}
        for name, module in modules.items():
            for cell in module.cells:
                if cell.kind in modules:
                    self._parents[cell.kind].append((name, cell))
        self._ports = {name: _ports(module) for name, module in modules.items()}
        self._carried: dict[int, int] = {}
        self._seen: set[int] = set()
        self._due: list[tuple[str, int]] = []
        self._start(top)
        while self._due:
            self._follow(*self._due.pop())

    def _start(self, top: str) -> None:
        for wire in self._modules[top].ports:
            self._need(top, wire.bits)
        for name, module in self._modules.items():
            for wire in module.wires.values():
                if wire.keep:
                    self._need(name, wire.bits)
            for cell in module.cells:
                if cell.kind in self._modules and self._modules[cell.kind].blackbox:
                    for pin, word in cell.pins.items():
                        if self._modules[cell.kind].wires[pin].direction == "input":
                            self._need(name, word)

    def _need(self, name: str, bits: Iterable[Bit]) -> None:
        live = self.live[name]
        for bit in bits:
            if not isinstance(bit, str) and not live[bit]:
                live[bit] = 1
                self._due.append((name, bit))

    def _follow(self, name: str, bit: int) -> None:
        """Mark what drives a live bit."""
        if bit in self._ports[name]:
            pin, place = self._ports[name][bit]
            for parent, cell in self._parents[name]:
                if pin in cell.pins:
                    self._need(parent, [cell.pins[pin][place]])
        driver = self._drivers[name].get(bit)
        if driver is None:
            return
        if not isinstance(driver, tuple):
            self._need(name, [driver])
            return
        cell, pin, place = driver
        if cell.kind in self._modules:
            wire = self._modules[cell.kind].wires[pin]
            self._need(cell.kind, [wire.first + place])
        else:
            self._need(name, self._operands(cell, place))

    def _operands(self, cell: Cell, place: int) -> Iterator[Bit]:
        """Bits that bit ``place`` of a result depends on, but for those that have been marked for another one."""
        data = data_pins(cell) if cell.kind not in OTHERS else ()
        if id(cell) not in self._seen:
            self._seen.add(id(cell))
            for pin, word in cell.pins.items():
                if pin not in data and pin != result_pin(cell):
                    yield from word
        first = place
        if cell.kind in CARRY:
            first = self._carried.get(id(cell), 0)
            self._carried[id(cell)] = max(first, place + 1)
        for pin in data:
            for k in range(first, place + 1):
                found = reached(cell, pin, k)
                if found >= 0:
                    yield cell.pins[pin][found]


def _ports(module: Module) -> dict[int, tuple[str, int]]:
    """Bits of the inputs, with the pin and the place in it."""
    inputs = (wire for wire in module.ports if wire.direction == "input")
    return {bit: (wire.name, k) for wire in inputs for k, bit in enumerate(wire.bits)}


def _drivers(module: Module, modules: dict[str, Module]) -> dict[int, Driver]:
    drivers: dict[int, Driver] = {}
    for cell in module.cells:
        for pin in outputs(cell, modules):
            drivers |= {bit: (cell, pin, k) for k, bit in enumerate(cell.pins[pin]) if isinstance(bit, int)}
    for left, right in module.aliases:
        drivers |= {to: bit for to, bit in zip(left, right, strict=True) if isinstance(to, int)}
    return drivers


def outputs(cell: Cell, modules: dict[str, Module]) -> list[str]:
    """Pins that a cell drives; raises ``ValueError`` for an operation that is not known."""
    if cell.kind in modules:
        wires = modules[cell.kind].wires
        return [pin for pin in cell.pins if wires[pin].direction == "output"]
    if cell.kind not in BITWISE | CARRY | OTHERS:
        raise ValueError(f"netlist: the operation {cell.kind} is not known")
    return [result_pin(cell)]

