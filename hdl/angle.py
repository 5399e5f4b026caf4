"""The angle of a frame's tangential force, and the moduli of its gain, from one CORDIC."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.cordic import Cordic, cordic_latency, cordic_modulus, cordic_vector
from tfra.hdl.streams import Buffer
from tfra.model.design import Design
from tfra.model.fixed.widths import DIVISION_GUARD


class Angle(wiring.Component):
    """phi = atan2(sin, cos) of every frame, in the place that nobody else takes in the CORDIC.

    ::

        vector ───────────────▶ Cordic ─┬─▶ turned
        direction ─▶ buffer ──────┘     └─▶ phi

    ``vector`` always goes first and takes ``latency`` cycles to ``turned``, whatever the directions do: a direction
    whose place it takes begins again.  Who sends ``vector`` takes ``turned`` at once, and sends no other one before.
    A direction enters when the phi before has left.

    Members:
        vector: stream in, x and y; always ready.
        turned: stream out, the modulus; ``ready`` is not looked at.
        direction: stream in, ``cos`` and ``sin`` are looked at.
        phi: stream out, one transfer a direction.

    Resources: a Cordic.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "vector": In(stream.Signature(cordic_vector(design))),
                "turned": Out(stream.Signature(cordic_modulus(design))),
                "direction": In(stream.Signature(payloads.direction(design))),
                "phi": Out(stream.Signature(unsigned(design.formats.operand))),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the transfer of ``vector`` to that of ``turned``."""
        return cordic_latency(self._design)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.cordic = cordic = Cordic(self._design)
        m.submodules.waiting = waiting = Buffer(payloads.direction(self._design))
        wiring.connect(m, wiring.flipped(self.direction), waiting.i)
        phi, busy = Signal(self.phi.payload.shape(), reset_less=True), Signal()  # busy: a direction or phi is there
        m.d.comb += [
            self.vector.ready.eq(1),
            cordic.urgent.eq(self.vector.valid),
            cordic.vector.valid.eq(self.vector.valid | (waiting.o.valid & ~busy)),
            waiting.o.ready.eq(cordic.turned.valid & ~cordic.turned.p.urgent),
            self.turned.valid.eq(cordic.turned.valid & cordic.turned.p.urgent),
            self.turned.payload.eq(cordic.turned.p.modulus),
            self.phi.payload.eq(phi),
        ]
        for into, word in (("x", "cos"), ("y", "sin")):
            direction = waiting.o.p[word] << DIVISION_GUARD
            m.d.comb += cordic.vector.p[into].eq(Mux(self.vector.valid, self.vector.p[into], direction))
        with m.If(cordic.vector.valid & cordic.vector.ready & ~self.vector.valid):
            m.d.sync += busy.eq(1)
        with m.Elif(cordic.lost | (self.phi.valid & self.phi.ready)):
            m.d.sync += busy.eq(0)
        with m.If(waiting.o.ready):
            m.d.sync += [phi.eq(cordic.turned.p.angle), self.phi.valid.eq(1)]
        with m.Elif(self.phi.ready):
            m.d.sync += self.phi.valid.eq(0)
        return m
