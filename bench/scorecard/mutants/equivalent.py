"""A proof that a mutant sends what the original sends: whatever register it changes is without effect.

Both are cofactors of one and-inverter graph, in which an input selects the mutant.  All registers begin equal; which of
them stay equal while only they are known to be (van Eijk) is found by counterexamples, a word at a time.  The mutant is
equivalent if the outputs are equal then, too, and payloads while they are valid.
"""

import re
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from pathlib import Path
from random import Random
from time import monotonic

from bench.scorecard.aig import FALSE, TRUE, Graph, Pair

SECONDS = 3
"""For a proof."""
CYCLES = 60
"""Of a run in 64 ways that shows which registers leave 0."""
SCRIPT = """\
memory_map
opt_clean
techmap
opt_clean
dffunmap
setundef -zero
setundef -zero -init
aigmap
write_aiger -ascii -zinit -map symbols mutants.aag
"""
"""Yosys' commands that make ``mutants.aag`` and ``symbols`` of a flat netlist."""


@dataclass(frozen=True)
class Netlist:
    """An and-inverter graph.  A literal is twice a variable, plus one if inverted; variable 0 is false.

    ``inputs`` and ``outputs`` have names ``port[bit]``.  The variables of ``latches``, given by their next literals,
    come after those of the inputs, then those of ``gates``, given by their operands; ``words`` name the registers.
    """

    inputs: list[str]
    latches: list[int]
    words: list[str]
    outputs: dict[str, int]
    gates: list[Pair]


def read(folder: Path) -> Netlist:
    """The netlist that ``SCRIPT`` left in ``folder``."""
    head, *lines = (folder / "mutants.aag").read_text().splitlines()
    _, inputs, latches, outputs, gates = map(int, head.split()[1:6])
    names: dict[str, dict[int, str]] = {"input": {}, "output": {}, "latch": {}}
    for line in (folder / "symbols").read_text().splitlines():
        kind, number, bit, name = line.split()[:4]
        kind = kind.removeprefix("inv")
        if kind in names:
            names[kind][int(number)] = name if kind == "latch" else f"{name}[{bit}]"
    rows = [tuple(map(int, line.split())) for line in lines[: inputs + latches + outputs + gates]]
    ends = rows[inputs + latches : inputs + latches + outputs]
    return Netlist(
        [names["input"].get(number, "") for number in range(inputs)],
        [row[1] for row in rows[inputs : inputs + latches]],
        [names["latch"].get(number, f"{number}") for number in range(latches)],
        {names["output"][number]: end for number, (end,) in enumerate(ends)},
        [(row[1], row[2]) for row in rows[inputs + latches + outputs :]],
    )


class Prover:
    """Proofs for mutants of one netlist, which its inputs ``mutant`` select."""

    def __init__(self, netlist: Netlist) -> None:
        self._netlist, self._graph = netlist, Graph()
        inputs, latches = len(netlist.inputs), len(netlist.latches)
        self._first = 1 + inputs + latches
        self._state = range(1 + inputs, self._first)
        self._bits: dict[str, list[int]] = {}
        for place, word in zip(self._state, netlist.words, strict=True):
            self._bits.setdefault(word, []).append(place)
        self._select = {
            place: int(bit[1])
            for place, name in enumerate(netlist.inputs, 1)
            if (bit := re.fullmatch(r"mutant\[(\d+)\]", name))
        }
        self._sources = [FALSE, *(self._graph.input() for _ in range(inputs + latches))]
        for place in self._select:
            self._sources[place] = FALSE
        self._made = self._stuck()
        self._readers: list[list[int]] = [[] for _ in self._made]
        for gate, sides in enumerate(netlist.gates, self._first):
            for side in sides:
                self._readers[side >> 1].append(gate)
        ends, valid = netlist.outputs, re.compile(r"_(t?)[a-z]+\[\d+\]$")
        self._ports = [(end, ends.get(valid.sub(r"_\1valid[0]", name), TRUE)) for name, end in ends.items()]

    def _stuck(self) -> list[int]:
        """Literals of all variables of the original, where registers that are always 0 are false.

        Those that stay 0 in a short run are assumed to, until none is left whose next value may be another one then.
        """
        netlist, random = self._netlist, Random(1)
        still = {"rst[0]", *(netlist.inputs[place - 1] for place in self._select)}
        assumed, values = [0] * len(self._state), [0] * len(self._state)
        for _ in range(CYCLES):
            made = [0, *(0 if name in still else random.getrandbits(64) for name in netlist.inputs), *values]
            for a, b in netlist.gates:
                made.append((made[a >> 1] ^ -(a & 1)) & (made[b >> 1] ^ -(b & 1)))
            values = [made[after >> 1] ^ -(after & 1) for after in netlist.latches]
            assumed = [old | new for old, new in zip(assumed, values, strict=True)]
        stuck = [place for place, value in zip(self._state, assumed, strict=True) if not value]
        while True:
            made = list(self._sources)
            for place in stuck:
                made[place] = FALSE
            for a, b in netlist.gates:
                made.append(self._graph.both(_of(made, a), _of(made, b)))
            left = [place for place in stuck if _of(made, netlist.latches[place - self._state.start]) == FALSE]
            if left == stuck:
                return made
            stuck = left

    def _changed(self, sources: dict[int, int]) -> list[int]:
        """Literals of all variables where those of ``sources`` are these."""
        made, waiting = list(self._made), list[int]()
        for place, literal in sources.items():
            made[place] = literal
            waiting += self._readers[place]
        heapify(waiting)
        last = 0
        while waiting:
            place = heappop(waiting)
            if place == last:
                continue
            last = place
            a, b = self._netlist.gates[place - self._first]
            made[place] = self._graph.both(_of(made, a), _of(made, b))
            if made[place] != self._made[place]:
                for reader in self._readers[place]:
                    heappush(waiting, reader)
        return made

    def _differ(self, made: list[int], equal: list[int]) -> Iterator[tuple[int, Pair]]:
        """What may differ: latches ``equal`` by their variables, outputs as 0, and literals of both."""
        for data, valid in self._ports:
            pair = [self._graph.both(_of(one, data), _of(one, valid)) for one in (self._made, made)]
            if pair[0] != pair[1]:
                yield 0, (pair[0], pair[1])
        for place in equal:
            after = self._netlist.latches[place - self._state.start]
            if _of(made, after) != _of(self._made, after):
                yield place, (_of(self._made, after), _of(made, after))

    def equivalent(self, number: int) -> bool:
        """Whether the mutant is proven to be equivalent; those without a proof in ``SECONDS`` may be."""
        sources, end = {place: number >> bit & 1 for place, bit in self._select.items()}, monotonic() + SECONDS
        with suppress(subprocess.TimeoutExpired):
            while True:
                equal = [place for place in self._state if place not in sources]
                pairs = list(self._differ(self._changed(sources), equal))
                found = {pairs[place][0] for place in self._graph.different([pair for _, pair in pairs], end)}
                if not found or 0 in found:
                    return not found
                words = {self._netlist.words[place - self._state.start] for place in found}
                sources |= {place: self._graph.input() for word in words for place in self._bits[word]}
        return False


def _of(made: Sequence[int], literal: int) -> int:
    return made[literal >> 1] ^ (literal & 1)
