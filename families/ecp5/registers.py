"""Registers around hard blocks move into them, as vendors' tools do and yosys does not: netlist in, netlist out.

A block memory of the ECP5 without its output register takes 5.6 ns to answer at speed grade 6, and a multiplier 4.5 ns:
much of a cycle.  Both have registers of their own, which cost nothing.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any

Cell = dict[str, Any]
Bit = int | str

_PLAIN = {"CLKMUX": "CLK", "LSRMUX": "LSR", "REGSET": "RESET", "GSR": "DISABLED"}
"""Parameters of a flip-flop that a block can have inside."""


def absorb(netlist: dict[str, Any], top: str) -> int:
    """Move flip-flops into DP16KD and MULT18X18D cells of module ``top`` of yosys' JSON; return how many.

    They move when all bits of a word, or of both factors, pass them, with one clock and one enable and no reset.
    """
    return _Packer(netlist["modules"][top]).run()


class _Packer:
    """The cells of a module, who drives a bit and who reads it."""

    def __init__(self, module: dict[str, Any]) -> None:
        self._cells: dict[str, Cell] = module["cells"]
        self._readers: defaultdict[Bit, list[tuple[str, str]]] = defaultdict(list)
        self._driver: dict[Bit, str] = {}
        for name, cell in self._cells.items():
            for port, bits in cell["connections"].items():
                for bit in bits:
                    if cell["port_directions"][port] == "input":
                        self._readers[bit].append((name, port))
                    else:
                        self._driver[bit] = name
        for port in module["ports"].values():
            for bit in port["bits"]:
                self._readers[bit].append(("", ""))

    def run(self) -> int:
        moved = 0
        for cell in list(self._cells.values()):
            if cell["type"] == "DP16KD":
                moved += self._memory(cell)
            elif cell["type"] == "MULT18X18D":
                moved += self._output(cell) + self._inputs(cell)
        return moved

    def _memory(self, cell: Cell) -> int:
        """The output register of the port that reads; a memory of 36 bits reads by port B, through both outputs."""
        wide = _number(cell["parameters"].get("DATA_WIDTH_B", 0)) == 36
        moved = 0
        for sides in ["AB"] if wide else ["A", "B"]:
            behind = self._behind(cell, [f"DO{side}{k}" for side in sides for k in range(18)])
            if behind and cell["parameters"].get(f"REGMODE_{sides[-1]}", "NOREG") == "NOREG":
                enable = _enable(self._cells[next(iter(behind.values()))])
                for side in sides:
                    cell["parameters"][f"REGMODE_{side}"] = "OUTREG"
                    cell["connections"][f"OCE{side}"] = [enable]
                moved += self._remove(cell, behind)
        return moved

    def _output(self, cell: Cell) -> int:
        behind = self._behind(cell, [f"P{k}" for k in range(36)]) if not _registered(cell, "OUTPUT") else {}
        first = next((self._cells[name] for name in behind.values()), None)
        return self._remove(cell, behind) if first and self._clock(cell, "OUTPUT", first) else 0

    def _inputs(self, cell: Cell) -> int:
        """Flip-flops before both factors; other readers keep them."""
        if _registered(cell, "INPUTA") or _registered(cell, "INPUTB"):
            return 0
        ports = [f"{name}{k}" for name in "AB" for k in range(18)]
        bits = {bit for port in ports for bit in cell["connections"][port]} - {"0"}  # registers begin with zeros
        found = {bit: self._cells[driver] for bit in bits if (driver := self._driver.get(bit, ""))}
        if len(found) != len(bits) or not _alike(list(found.values())):
            return 0
        enable = next(iter(found.values()))
        if not all(self._clock(cell, f"INPUT{name}", enable) for name in "AB"):
            return 0
        for port in ports:
            (bit,) = cell["connections"][port]
            if bit in found:
                cell["connections"][port] = found[bit]["connections"]["DI"]
                self._readers[bit] = [reader for reader in self._readers[bit] if self._cells.get(reader[0]) is not cell]
        unread = [self._driver[bit] for bit in bits if not self._readers[bit]]
        for name in unread:
            del self._cells[name]
        return len(unread)

    def _clock(self, cell: Cell, register: str, flipflop: Cell) -> bool:
        """Put ``register`` on CLK0 with the enable of ``flipflop``, if the cell's other registers have the same."""
        ports, enable = cell["connections"], _enable(flipflop)
        used = any(_registered(cell, name) for name in ("INPUTA", "INPUTB", "PIPELINE", "OUTPUT"))
        if used and (ports["CLK0"] != flipflop["connections"]["CLK"] or ports["CE0"] != [enable]):
            return False
        ports |= {"CLK0": flipflop["connections"]["CLK"], "CE0": [enable], "RST0": ["0"]}
        cell["port_directions"] |= dict.fromkeys(("CLK0", "CE0", "RST0"), "input")
        cell["parameters"][f"REG_{register}_CLK"] = "CLK0"
        return True

    def _behind(self, cell: Cell, outputs: Iterable[str]) -> dict[str, str]:
        """Names of the flip-flops behind ``outputs`` that are read, if they are alike and nothing else reads them."""
        found: dict[str, str] = {}
        for port in outputs:
            for bit in cell["connections"].get(port, []):
                for name, pin in self._readers[bit]:
                    if port in found or pin != "DI" or self._cells[name]["type"] != "TRELLIS_FF":
                        return {}
                    found[port] = name
        return found if found and _alike([self._cells[name] for name in found.values()]) else {}

    def _remove(self, cell: Cell, behind: Mapping[str, str]) -> int:
        """Let outputs drive what the flip-flops ``behind`` them drove."""
        for port, name in behind.items():
            cell["connections"][port] = self._cells.pop(name)["connections"]["Q"]
        return len(behind)


def _registered(cell: Cell, name: str) -> bool:
    return str(cell["parameters"].get(f"REG_{name}_CLK", "NONE")) != "NONE"


def _alike(found: list[Cell]) -> bool:
    """Flip-flops with one clock and one enable, not inverted, and without a reset."""
    first = found[0]
    return all(
        cell["type"] == "TRELLIS_FF"
        and cell["connections"].get("LSR", ["0"]) == ["0"]
        and all(cell["parameters"].get(key, value) == value for key, value in _PLAIN.items())
        and _enable(cell) == _enable(first) != "x"
        and cell["connections"]["CLK"] == first["connections"]["CLK"]
        for cell in found
    )


def _enable(flipflop: Cell) -> Bit:
    """The bit that enables ``flipflop``, or "1"; or "x", which no block can have, for an inverted one."""
    mode = str(flipflop["parameters"].get("CEMUX", "CE")).strip()
    bit: Bit = flipflop["connections"]["CE"][0] if mode == "CE" else "1"
    return bit if mode in ("CE", "1") else "x"


def _number(value: Any) -> int:
    """A parameter of yosys' JSON: a number, or its bits as text."""
    return int(value, 2) if isinstance(value, str) and set(value) <= set("01") else int(value)
