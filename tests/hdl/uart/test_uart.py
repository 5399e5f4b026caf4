"""Receiver and transmitter on a line: bytes, their timing, broken stop bits, breaks."""

import random
from typing import Any

import pytest
from amaranth import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import connect, flipped

from tfra.hdl.uart.uart import Rx, Tx
from tfra.sim.harness import flowing, play, random_stalls, run

DIVISOR = 12


class Loop(wiring.Component):
    """A transmitter whose line ends in a receiver."""

    def __init__(self, divisor: int) -> None:
        self.tx, self.rx = Tx(divisor), Rx(divisor)
        super().__init__({"i": self.tx.signature.members["i"], "o": self.rx.signature.members["o"]})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.tx, m.submodules.rx = self.tx, self.rx
        connect(m, flipped(self.i), self.tx.i)
        connect(m, self.rx.o, flipped(self.o))
        m.d.comb += self.rx.line.eq(self.tx.line)
        return m


def bits(byte: int, stop: int = 1) -> list[int]:
    """A start bit, the byte's bits, and its stop bit."""
    return [0, *(byte >> place & 1 for place in range(8)), stop]


def seen(line: list[int]) -> tuple[list[int], int, int]:
    """Bytes that a receiver finds on a line, faults, and cycles of a break; a value of ``line`` for each cycle."""
    record = play(Rx(DIVISOR), [{"line": value} for value in line], ("o.valid", "o.payload", "fault", "broken"))
    found = [row["o.payload"] for row in record if row["o.valid"]]
    return found, sum(row["fault"] for row in record), sum(row["broken"] for row in record)


def drawn(levels: list[int], period: float = DIVISOR) -> list[int]:
    """A line of cycles from a line of bits, at rest before and after it."""
    length = round(period * len(levels))
    return [1] * 30 + [levels[min(int(n / period), len(levels) - 1)] for n in range(length)] + [1] * 30


@pytest.mark.parametrize("divisor", [8, 12, 25])
@pytest.mark.parametrize("stalls", [flowing, random_stalls])
def test_every_byte_comes_back(divisor: int, stalls: Any) -> None:
    sent, loop = random.Random(1).sample(range(256), 30), Loop(divisor)
    record = run(loop, {"i": sent}, {"o": len(sent)}, stall_in=stalls)
    assert record.values["o"] == sent
    apart = {late - early for early, late in zip(record.cycles["i"], record.cycles["i"][1:], strict=False)}
    assert min(apart) == loop.tx.interval
    assert stalls is random_stalls or max(apart) == loop.tx.interval


@pytest.mark.parametrize("period", [DIVISOR * 0.96, DIVISOR, DIVISOR * 1.04])
def test_clocks_may_differ(period: float) -> None:
    """By four per cent: half a bit in nine and a half, up to the middle of the stop bit, less what sampling takes."""
    sent = [0, 0xFF, 0x55, 0xA5, 0xC0]
    assert seen(drawn([bit for byte in sent for bit in bits(byte)], period)) == (sent, 0, 0)


def test_a_low_stop_bit_loses_the_byte_alone() -> None:
    line = [*bits(0x41, stop=0), 1, *bits(0x42)]
    assert seen(drawn(line)) == ([0x42], 1, 0)


def test_a_break_lasts_until_the_line_is_high() -> None:
    found, faults, cycles = seen(drawn([*[0] * 20, 1, *bits(0x42)]))
    assert (found, faults) == ([0x42], 1)
    assert 10 * DIVISOR < cycles < 11 * DIVISOR


def test_a_spike_is_no_start_bit() -> None:
    line = drawn([1])
    line[10:14] = [0] * 4
    assert seen([*line, *drawn(bits(0x37))]) == ([0x37], 0, 0)
