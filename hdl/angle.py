"""The angle of a frame's tangential force, and the moduli of its gain, from one CORDIC."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.cordic import Cordic, cordic_latency, cordic_modulus, cordic_vector
from tfra.hdl.pipeline import delayed
from tfra.hdl.streams import Buffer
from tfra.model.design import Design
from tfra.model.fixed.widths import DIVISION_GUARD


class Angle(wiring.Component):
    """phi = atan2(sin, cos) of every frame, in cycles in which nobody else has a vector for the CORDIC.

    ::

        vector ───────────────▶ Cordic ─┬─▶ turned
        direction ─▶ buffer ──────┘     └─▶ phi

    ``vector`` always goes first and takes ``latency`` cycles to ``turned``, whatever the directions do; the sink of
    ``turned`` takes it at once.  The CORDIC never waits: a direction enters it when the phi before has left.

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
        busy, phi = Signal(), Signal(self.phi.payload.shape(), reset_less=True)
        enter = self._direction(m, cordic, busy)
        m.d.comb += [
            self.vector.ready.eq(1),
            cordic.i.valid.eq(self.vector.valid | enter),
            cordic.o.ready.eq(1),
            self.turned.valid.eq(delayed(m, self.vector.valid, self.latency, "asked", control=True)),
            self.turned.payload.eq(cordic.o.p.modulus),
            self.phi.payload.eq(phi),
        ]
        with m.If(enter):
            m.d.sync += busy.eq(1)
        with m.Elif(cordic.o.valid & ~self.turned.valid):
            m.d.sync += [phi.eq(cordic.o.p.angle), self.phi.valid.eq(1)]
        with m.Elif(self.phi.valid & self.phi.ready):
            m.d.sync += [busy.eq(0), self.phi.valid.eq(0)]
        return m

    def _direction(self, m: Module, cordic: Cordic, busy: Signal) -> Any:
        """The vector for the CORDIC; high when it is a direction, which leaves its buffer."""
        m.submodules.waiting = waiting = Buffer(payloads.direction(self._design))
        wiring.connect(m, wiring.flipped(self.direction), waiting.i)
        enter = Signal()
        m.d.comb += [
            enter.eq(waiting.o.valid & ~busy & ~self.vector.valid),
            waiting.o.ready.eq(enter),
        ]
        for into, word in (("x", "cos"), ("y", "sin")):
            direction = waiting.o.p[word] << DIVISION_GUARD
            m.d.comb += cordic.i.p[into].eq(Mux(self.vector.valid, self.vector.p[into], direction))
        return enter
