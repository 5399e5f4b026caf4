"""The model of DP16KD remembers what is written, in words of any length, and knows nothing of collisions."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from amaranth import Cat, ClockSignal, Const, Instance, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tests.hdl.primitives.harness import in_icarus
from tests.marks import long

CYCLES = 400
FEW = 8  # addresses in use


class Memory(wiring.Component):
    """A DP16KD that is written and read by port A and read by port B; ``place`` counts words."""

    def __init__(self, bits: int, mode: str) -> None:
        self._bits, self._mode = bits, mode
        super().__init__(
            {
                **{name: In(3) for name in ("place_a", "place_b")},
                "write": In(1),
                "data": In(bits),
                **{name: Out(bits) for name in ("word_a", "word_b")},
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        ports: dict[str, Any] = {}
        below = self._bits.bit_length() - 1
        low = Const(3, 2) if self._bits == 18 else Const(0, 0)  # byte enables
        for name, place, word in (("A", self.place_a, self.word_a), ("B", self.place_b, self.word_b)):
            address = Signal(14, name=f"address_{name}")
            m.d.comb += address.eq(Cat(Cat(low, Const(0, 4))[:below], place))
            ports |= {f"p_DATA_WIDTH_{name}": self._bits, f"p_WRITEMODE_{name}": self._mode}
            ports |= {f"i_AD{name}{n}": address[n] for n in range(14)}
            ports |= {f"i_DI{name}{n}": self.data[n] for n in range(self._bits)}
            ports |= {f"o_DO{name}{n}": word[n] for n in range(self._bits)}
            ports |= {f"i_CS{name}{n}": Const(0) for n in range(3)}
            ports |= {f"i_CLK{name}": ClockSignal(), f"i_CE{name}": Const(1), f"i_OCE{name}": Const(1)}
            ports |= {f"i_RST{name}": Const(0), f"i_WE{name}": self.write if name == "A" else Const(0)}
        m.submodules.cell = Instance("DP16KD", **ports)
        return m


@pytest.mark.parametrize("mode", ["NORMAL", "WRITETHROUGH", "READBEFOREWRITE"])
@pytest.mark.parametrize("bits", [1, 9, *long(2, 4, 18)])
def test_words_return(bits: int, mode: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(bits)
    draw = {"place_a": FEW, "place_b": FEW, "write": 2, "data": 1 << bits}
    inputs = {name: [int(x) for x in rng.integers(0, top, CYCLES)] for name, top in draw.items()}
    seen = in_icarus(Memory(bits, mode), inputs, {"word_a": bits, "word_b": bits}, "ecp5", tmp_path)
    memory, word_a, collisions = [0] * FEW, 0, 0
    for cycle in range(CYCLES - 1):
        a, b, write, data = (inputs[name][cycle] for name in draw)
        word_b = memory[b]
        if not write or mode == "READBEFOREWRITE":
            word_a = memory[a]
        elif mode == "WRITETHROUGH":
            word_a = data
        if write:
            memory[a] = data
        assert int(seen[cycle + 1][0], 16) == word_a, cycle
        if write and a == b:
            assert set(seen[cycle + 1][1].lower()) == {"x"}, cycle
            collisions += 1
        elif bits >= 9 or not write or a * bits // 8 != b * bits // 8:  # narrow words collide by their byte
            assert int(seen[cycle + 1][1], 16) == word_b, cycle
    assert collisions > 10
