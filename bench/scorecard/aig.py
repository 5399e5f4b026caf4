"""An and-inverter graph: literals are numbers, an odd one is the inverse of the even one below it; 0 is false."""

import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from time import monotonic

from tfra.codegen.verilog.emit import run_yosys

FALSE, TRUE = 0, 1

_CARRIER = "module carrier(input [1:0] a, b, output [1:0] y); assign y = a + b; endmodule\n"
"""yosys' ABC reads a netlist before its script, which puts the graph in its place."""

_SCRIPT = "&read points.aig\n&fraig -C {conflicts}\n&write proven.aig\n"

CONFLICTS = 20_000
"""Of the solver, after which it gives a pair of nodes up."""

Pair = tuple[int, int]


class Graph:
    """Two-input ands with shared structure; inputs are nodes without operands."""

    def __init__(self) -> None:
        self._operands: list[Pair | None] = [None]
        self._made: dict[Pair, int] = {}

    def input(self) -> int:
        """The literal of a new input."""
        self._operands.append(None)
        return 2 * len(self._operands) - 2

    def both(self, a: int, b: int) -> int:
        """The literal of "a and b"."""
        low, high = min(a, b), max(a, b)
        if low == FALSE or low == high ^ 1:
            return FALSE
        if low in (TRUE, high):
            return high
        if (low, high) not in self._made:
            self._made[low, high] = 2 * len(self._operands)
            self._operands.append((low, high))
        return self._made[low, high]

    def differ(self, a: int, b: int) -> int:
        """The literal of "a is not b"."""
        return self.both(self.both(a, b) ^ 1, self.both(a ^ 1, b ^ 1) ^ 1)

    def false(self, literals: Sequence[int], folder: Path) -> list[bool]:
        """Which of ``literals`` are proven to be false for all inputs, by ABC's sweeping in ``folder``.

        Raises :class:`ToolError` when yosys fails.
        """
        left = [literal for literal in literals if literal > TRUE]
        proven = set[int]()
        if left:
            (folder / "points.aig").write_bytes(self._aiger(left))
            (folder / "carrier.v").write_text(_CARRIER)
            (folder / "prove.abc").write_text(_SCRIPT.format(conflicts=CONFLICTS))
            run_yosys("read_verilog carrier.v; techmap; simplemap; abc -g AND -script prove.abc", folder)
            head, *rest = (folder / "proven.aig").read_bytes().split(b"\n", len(left) + 1)
            assert int(head.split()[4]) == len(left)
            proven = {literal for literal, said in zip(left, rest, strict=False) if said == b"0"}
        return [literal == FALSE or literal in proven for literal in literals]

    def different(self, pairs: Sequence[Pair], end: float) -> list[int]:
        """Places of those of ``pairs`` whose literals differ at once in some case; none if no pair ever differs.

        Raises ``TimeoutExpired`` at the time ``end``.
        """
        if not pairs:
            return []
        clauses = ["-1 0"]
        some = range(len(self._operands) + 1, len(self._operands) + 1 + len(pairs))
        for number, pair in zip(some, pairs, strict=True):
            x, y = map(_number, pair)
            clauses += [f"-{number} {x} {y} 0", f"-{number} {-x} {-y} 0"]
        clauses.append(" ".join(map(str, [*some, 0])))
        for node in self._cones(literal for pair in pairs for literal in pair)[1]:
            made, a, b = map(_number, (node, *self._sides(node)))
            clauses += [f"-{made} {a} 0", f"-{made} {b} 0", f"{made} {-a} {-b} 0"]
        with tempfile.NamedTemporaryFile("w", suffix=".cnf") as file:
            file.write(f"p cnf {some.stop - 1} {len(clauses)}\n" + "\n".join(clauses) + "\n")
            file.flush()
            command = [str(Path(sys.executable).with_name("yices-sat")), "-m", file.name]
            left = max(0, end - monotonic())
            done = subprocess.run(command, capture_output=True, text=True, timeout=left, check=True)
        true = {int(word) for word in done.stdout.split()[1:]}  # nothing after "unsat"
        values = [[(number > 0) == (abs(number) in true) for number in map(_number, pair)] for pair in pairs]
        return [place for place, (one, other) in enumerate(values) if true and one != other]

    def _sides(self, node: int) -> Pair | tuple[()]:
        """Operands of an and; none of an input."""
        return self._operands[node >> 1] or ()

    def _aiger(self, outputs: Iterable[int]) -> bytes:
        """The cones of ``outputs`` in AIGER's binary format."""
        outputs = list(outputs)
        inputs, ands = self._cones(outputs)
        numbers = {0: 0} | {node: 2 * place for place, node in enumerate([*inputs, *ands], 1)}

        def number(literal: int) -> int:
            return numbers[literal & ~1] | literal & 1

        head = f"aig {len(numbers) - 1} {len(inputs)} 0 {len(outputs)} {len(ands)}\n"
        text = bytearray((head + "".join(f"{number(output)}\n" for output in outputs)).encode())
        for node in ands:
            low, high = sorted(number(operand) for operand in self._sides(node))
            for difference in (numbers[node] - high, high - low):
                while difference > 127:
                    text.append(difference & 127 | 128)
                    difference >>= 7
                text.append(difference)
        return bytes(text)

    def _cones(self, outputs: Iterable[int]) -> tuple[list[int], list[int]]:
        """Inputs and ands that ``outputs`` depend on, operands first."""
        inputs, ands, seen = list[int](), list[int](), {0}
        waiting = [(output & ~1, False) for output in outputs]
        while waiting:
            node, done = waiting.pop()
            if done:
                ands.append(node)
            elif node not in seen:
                seen.add(node)
                if sides := self._sides(node):
                    waiting.append((node, True))
                    waiting += [(operand & ~1, False) for operand in sides]
                else:
                    inputs.append(node)
        return inputs, ands


def _number(literal: int) -> int:
    """A literal in DIMACS, where variables are counted from 1."""
    return (-1 if literal & 1 else 1) * ((literal >> 1) + 1)
