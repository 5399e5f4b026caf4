"""Points at which two netlists are compared: what registers take next, what foreign cells and outputs get.

The argument is an induction over cycles.  Bits that bear a name in common, and are registers or constants, hold the
same in the first cycle, by their initial values; while they do, and foreign cells of the same name answer the same,
they take the same next, foreign cells get the same, and so do the outputs.  Every one of these is a point to prove.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from bench.scorecard.aig import FALSE, TRUE, Graph

Bit = int | str
Cell = dict[str, Any]
UNDEFINED = "x"
INVERTED = str.maketrans("01", "10")
_REGISTER = "$_DFF_P_"
_CONSTANTS: dict[Bit, int] = {"0": FALSE, "1": TRUE}


class Side:
    """A module of yosys' JSON, of ands, inverters, registers of one clock without enable and reset, foreign cells."""

    def __init__(self, module: dict[str, Any]) -> None:
        self.ports: dict[str, Any] = module["ports"]
        self.gates = dict[Bit, list[Bit]]()
        self.registers = dict[Bit, Bit]()
        self.foreign = dict[str, Cell]()
        for name, cell in module["cells"].items():
            pins = cell["connections"]
            if cell["type"] in ("$_AND_", "$_NOT_"):
                self.gates[pins["Y"][0]] = [pins[pin][0] for pin in "AB" if pin in pins]
            elif cell["type"] == _REGISTER:
                self.registers[pins["Q"][0]] = pins["D"][0]
            elif cell["type"] != "$scopeinfo":
                self.foreign[name] = cell
        self.nets: dict[str, list[Bit]] = {name: net["bits"] for name, net in module["netnames"].items()}
        self.initial = {
            bit: value
            for net in module["netnames"].values()
            for bit, value in zip(net["bits"], net["attributes"].get("init", "")[::-1], strict=False)
            if value in "01"
        }
        self.literals = dict(_CONSTANTS)

    def driven(self, bit: Bit) -> bool:
        """Whether anything decides ``bit``."""
        return bit in self.gates or bit in self.literals

    def begin(self, bit: Bit) -> str:
        """The initial value of a register or a constant."""
        return self.initial.get(bit, UNDEFINED) if isinstance(bit, int) else bit

    def held(self) -> Callable[[Bit], tuple[Bit, bool]]:
        """A function from a bit to the register or constant that it is, and whether inverted; "x" for all else."""
        graph = Graph()
        literals = _CONSTANTS | {bit: graph.input() for bit in self.registers}
        known: dict[int, Bit] = {literals[bit]: bit for bit in self.registers}

        def hold(bit: Bit) -> tuple[Bit, bool]:
            if isinstance(bit, str):
                return bit, False
            literal = self.literal(bit, graph, literals)
            return known.get(literal & ~1, UNDEFINED if literal > TRUE else "0"), bool(literal & 1)

        return hold

    def literal(self, bit: Bit, graph: Graph, literals: dict[Bit, int]) -> int:
        """The literal of ``bit`` by those in ``literals``, which gets more; what nothing drives is an input."""
        waiting = [bit]
        while waiting:
            here = waiting[-1]
            operands = self.gates.get(here, [])
            missing = [operand for operand in operands if operand not in literals]
            if here in literals:
                waiting.pop()
            elif missing:
                waiting += missing
            elif operands:
                first, *second = (literals[operand] for operand in operands)
                literals[here] = graph.both(first, *second) if second else first ^ 1
            else:
                literals[here] = literals[UNDEFINED] if UNDEFINED in literals else graph.input()
        return literals[bit]


Node = tuple[int, Bit]
"""Gold (0) or gate (1), and a register or a constant there."""
Link = tuple[Node, bool, str]
"""What holds the same, or the inverse of it, by this name."""


class Points:
    """All points of ``gold`` and ``gate``: ``differ`` has the literal of "they differ" by name.

    ``names`` are those of nets that both had before they were made of gates.
    """

    def __init__(self, gold: Side, gate: Side, names: Iterable[str]) -> None:
        self.graph = Graph()
        self._names = sorted(names)
        self._sides = gold, gate
        self.differ = dict[str, int]()
        self.abstract = dict[str, int]()
        """How many foreign cells of a type are the same on both sides."""
        self.alone = list[str]()
        """Foreign cells that only one side has, or whose parameters differ."""
        self.unlinked = 0
        """Registers of ``gold`` that share no name with anything that ``gate`` keeps."""
        self._inputs()
        shared = self._foreign()
        self._registers()
        for name in shared:
            self._compare(name, gold.foreign[name], gate.foreign[name])
        for name, port in gold.ports.items():
            if port["direction"] == "output":
                self._points(f"output {name}", port["bits"], gate.ports[name]["bits"])

    def _inputs(self) -> None:
        gold, gate = self._sides
        for name, port in gold.ports.items():
            if port["direction"] == "input":
                for one, other in zip(port["bits"], gate.ports[name]["bits"], strict=True):
                    gold.literals[one] = gate.literals[other] = self.graph.input()

    def _foreign(self) -> list[str]:
        """Names of the cells that both sides have, which answer the same."""
        gold, gate = self._sides
        shared = list[str]()
        for name in sorted(gold.foreign.keys() | gate.foreign.keys()):
            one, other = gold.foreign.get(name), gate.foreign.get(name)
            if not one or not other or _nature(one) != _nature(other):
                self.alone.append(name)
                for side in self._sides:  # which may answer anything
                    if cell := side.foreign.get(name):
                        for pin in _pins(cell, "output"):
                            side.literals |= {bit: self.graph.input() for bit in cell["connections"][pin]}
                continue
            shared.append(name)
            self.abstract[one["type"]] = self.abstract.get(one["type"], 0) + 1
            for pin in _pins(one, "output"):
                for here, there in zip(one["connections"][pin], other["connections"].get(pin, []), strict=False):
                    gold.literals[here] = gate.literals[there] = self.graph.input()
        return shared

    def _compare(self, name: str, one: Cell, other: Cell) -> None:
        for pin in sorted({*_pins(one, "input"), *_pins(other, "input")}):
            bits = one["connections"].get(pin, []), other["connections"].get(pin, [])
            longest = max(map(len, bits))
            self._points(f"{name} {pin}", *(row + ["0"] * (longest - len(row)) for row in bits))

    def _points(self, name: str, gold: list[Bit], gate: list[Bit]) -> None:
        """A point for each bit that ``gold`` defines."""
        for place, (one, other) in enumerate(zip(gold, gate, strict=True)):
            if not self._sides[0].driven(one):
                continue
            self.differ[f"{name}[{place}]"] = self._differ((0, one), (1, other), False)

    def _links(self) -> dict[Node, list[Link]]:
        """Registers and constants that bear the same name on both sides; one of the two is a register."""
        gold, gate = self._sides
        links = defaultdict[Node, list[Link]](list)
        holds = [side.held() for side in self._sides]
        for name in self._names:
            for place, bits in enumerate(zip(gold.nets.get(name, []), gate.nets.get(name, []), strict=False)):
                (one, turned), (other, turned_too) = (hold(bit) for hold, bit in zip(holds, bits, strict=True))
                if UNDEFINED not in (one, other) and not (isinstance(one, str) and isinstance(other, str)):
                    links[0, one].append(((1, other), turned != turned_too, f"{name}[{place}]"))
                    links[1, other].append(((0, one), turned != turned_too, f"{name}[{place}]"))
        return links

    def _registers(self) -> None:
        """One input for all that share a name, and their next and initial values as points."""
        links = self._links()
        self.unlinked = len([bit for bit in self._sides[0].registers if (0, bit) not in links])
        groups, seen = list[list[Link]](), set[Node]()
        for first in sorted(links, key=lambda node: (isinstance(node[1], int), *map(str, node))):  # constants first
            if first not in seen:
                groups.append(_group(first, links, seen))
        for group in groups:
            (_, origin), *_ = group[0]
            literal = _CONSTANTS[origin] if isinstance(origin, str) else self.graph.input()
            for (place, bit), inverted, _ in group:
                if isinstance(bit, int):
                    self._sides[place].literals[bit] = literal ^ inverted
        for side in self._sides:
            for bit in side.registers.keys() - side.literals.keys():
                side.literals[bit] = self.graph.input()
        gold, gate = self._sides[0].literals, self._sides[1].literals
        self._choices = ((gold | {UNDEFINED: FALSE}, gate), (gold | {UNDEFINED: TRUE}, gate))
        for group in groups:
            self._follow(group)

    def _follow(self, group: list[Link]) -> None:
        """The points of all but the first: the next value beside that of the first, and the initial value."""
        begins = [
            self._sides[place].begin(bit).translate(INVERTED if turned else {}) for (place, bit), turned, _ in group
        ]
        defined = next((begin for begin in begins if begin != UNDEFINED), UNDEFINED)
        nexts = [(place, self._sides[place].registers.get(bit, bit)) for (place, bit), _, _ in group]
        for place, ((side, bit), inverted, name) in enumerate(group):
            wrong = begins[place] not in ((defined, UNDEFINED) if side == 0 else (defined,))
            if place:
                differ = self._differ(nexts[0], nexts[place], inverted)
                self.differ[f"{name} beside {side}.{bit}"] = TRUE if wrong else differ

    def _differ(self, one: Node, other: Node, inverted: bool) -> int:
        """The literal of "they differ", for all undefined bits of gold 0, and also for all of them 1."""
        found = TRUE
        for literals in self._choices:
            values = (self._literal(node, literals) for node in (one, other))
            found = self.graph.both(found, self.graph.differ(*values) ^ inverted)
        return found

    def _literal(self, node: Node, literals: tuple[dict[Bit, int], ...]) -> int:
        place, bit = node
        return self._sides[place].literal(bit, self.graph, literals[place])


def _group(first: Node, links: Mapping[Node, list[Link]], seen: set[Node]) -> list[Link]:
    """``first`` and all that hold the same by their names; constants lead no further.  Adds them to ``seen``."""
    group: list[Link] = [(first, False, "")]
    seen.add(first)
    constants = {(first, False)}
    for here, turned, _ in group:
        for node, inverted, name in links[here] if isinstance(here[1], int) or here == first else ():
            found = node, turned != inverted
            if isinstance(node[1], int) and node not in seen:
                seen.add(node)
            elif isinstance(node[1], str) and found not in constants:
                constants.add(found)
            else:
                continue
            group.append((*found, name))
    return group


def _nature(cell: Cell) -> tuple[str, Any]:
    """Type and parameters, without those that change nothing: of ports without a clock, and of the ECP5's global reset,
    which no core has."""
    unused = ("RD_CLK_POLARITY",) if cell["type"] == "$mem_v2" else ("GSR",)
    return cell["type"], {name: value for name, value in cell["parameters"].items() if name not in unused}


def _pins(cell: Cell, direction: str) -> list[str]:
    return [pin for pin, flow in cell["port_directions"].items() if flow == direction and pin in cell["connections"]]
