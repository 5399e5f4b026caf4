"""Ram against a dictionary: words a cycle later, or in the same cycle; words that are written while they are read."""

import random
from typing import Any

import pytest
from amaranth import Module, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.ram import Ram
from tfra.sim.harness import play

DEPTH = 4


class Memories(wiring.Component):
    """The same words read in all ways."""

    def __init__(self) -> None:
        super().__init__({
            "enable": In(1),
            "at": In(range(DEPTH)),
            "word": In(8),
            "read": In(range(DEPTH)),
            "plain": Out(8),
            "transparent": Out(8),
            "at_once": Out(8),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name in ("plain", "transparent", "at_once"):
            ram = Ram(m, f"{name}_ram", unsigned(8), DEPTH)
            ram.write(self.enable, self.at, self.word)
            if name == "at_once":
                word = ram.look_up(self.read)
            else:
                word = ram.read(self.read, transparent=name == "transparent")
            m.d.comb += getattr(self, name).eq(word)
        return m


@pytest.mark.parametrize("seed", [1, 2])
def test_words_are_those_that_were_written(seed):
    rng, stored = random.Random(seed), dict.fromkeys(range(DEPTH), 0)
    cycles, before, expected = [], [], []
    for _ in range(60):
        row = {"enable": rng.randrange(2), "at": rng.randrange(DEPTH), "word": rng.randrange(256)}
        cycles.append(row | {"read": rng.randrange(DEPTH)})
        before.append(dict(stored))
        if row["enable"]:
            stored[row["at"]] = row["word"]
        expected.append(dict(stored))
    seen = play(Memories(), cycles, ["plain", "transparent", "at_once"])
    reads = [row["read"] for row in cycles]
    assert [row["at_once"] for row in seen] == [words[at] for words, at in zip(before, reads, strict=True)]
    assert [row["plain"] for row in seen[1:]] == [words[at] for words, at in zip(before, reads, strict=True)][:-1]
    later = [words[at] for words, at in zip(expected, reads, strict=True)]
    assert [row["transparent"] for row in seen[1:]] == later[:-1]
