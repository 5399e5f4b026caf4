"""Frames that wait between two points of the vector updates."""

from __future__ import annotations

from typing import Any

from amaranth import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import occupancy, wrapping_counter
from tfra.hdl.parallel.tfra.combine.store import FRAMES, place


class FramesWaiting(wiring.Component):
    """A queue of frames without a memory: frames leave in the order of their places, which is that of arrival.

    No full flag: at most ``FRAMES`` frames hold a token.
    """

    def __init__(self) -> None:
        super().__init__({
            "enter": In(1),  # a frame comes
            "leave": In(1),  # the oldest frame goes
            "oldest": Out(place),  # of the frame that goes next
            "some": Out(1),  # a frame waits
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taken = occupancy(m, FRAMES, self.enter, self.leave)
        oldest, _ = wrapping_counter(m, self.leave, FRAMES, "oldest")
        m.d.comb += self.oldest.eq(oldest)
        m.d.comb += self.some.eq(taken[0])
        return m
