"""Result words of the frames, in the order of the layout."""

from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.interface import ports
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.streams import TOKEN, SkidBuffer, Tokens
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.learned.payloads import force, header
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.tfra import Status


class Words(wiring.Component):
    """Header, forces at the taxels if there are any, and status of every frame.

    A frame starts when its header is valid; the facts are taken with the status.  Forces follow as they arrive, one
    word a cycle.
    """

    latency = SkidBuffer.latency
    """Cycles from the one in which a header is valid, or a force, to the transfer of its first word."""

    def __init__(self, design: LearnedDesign) -> None:
        self._design = design
        members: dict[str, Any] = {
            "frame": In(stream.Signature(payloads.frame_facts(design))),  # fact of the frame, there before the header
            "header": In(stream.Signature(header(design))),  # fact of the frame
            "result": Out(stream.Signature(ports.result(design))),  # ``last`` with the status
            "frame_token": Out(stream.Signature(TOKEN)),  # one for each frame that may be in flight
        }
        taxel = {"taxel": In(stream.Signature(force(design)))} if design.taxel_forces else {}
        super().__init__(members | taxel)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.skid = skid = SkidBuffer(ports.result(self._design))
        m.submodules.frame_tokens = tokens = Tokens(FRAMES)
        wiring.connect(m, skid.o, wiring.flipped(self.result))
        wiring.connect(m, tokens.o, wiring.flipped(self.frame_token))
        counter = Signal(COUNTER_BITS)
        words = self._header(counter)
        step = Signal(counter_shape(len(words)))  # the last one is that of the status
        taxels = Signal()
        limited = Signal()
        move = Signal()
        closing = step == len(words)
        status = Cat(self._status(limited))
        m.d.comb += [
            skid.i.valid.eq(self.header.valid),
            skid.i.p.data.eq(Array([*words, status])[step]),
            skid.i.p.last.eq(closing & ~taxels),
            move.eq(skid.i.valid & skid.i.ready),
            self.header.ready.eq(move & skid.i.p.last),
            self.frame.ready.eq(move & skid.i.p.last),
            tokens.give.eq(register(m, move & skid.i.p.last, "closed", control=True)),
        ]
        if self._design.taxel_forces:
            self._insert_taxels(m, skid, taxels, limited, move & (step == len(words) - 1))
        with m.If(move & ~taxels):
            m.d.sync += step.eq(Mux(closing, 0, step + 1))
        with m.If(move & skid.i.p.last):
            m.d.sync += counter.eq(counter + 1)
        return m

    def _header(self, counter: Value) -> list[Value]:
        """Words of the fields in front of the forces."""
        facts, judged = self.header.p, self.header.p.judged
        fields = {
            "frame": [counter],
            "exponent": [self.frame.p.exponent],
            "phi": [facts.angle.phi],
            "mu": [facts.friction.mu],
            "mu_x": [facts.friction.mu_x],
            "mu_y": [facts.friction.mu_y],
            "resultant": [judged.words[axis] for axis in range(3)],
            "uncertainty": [judged.uncertainty],
        }
        names = [field.name for field in self._design.layout if field.name not in ("forces", "status")]
        return [word for name in names for word in fields[name]]

    def _status(self, limited: Value) -> list[Value]:
        """The bits of the status from the lowest; ``limited``: a force was."""
        frame, facts = self.frame.p, self.header.p
        flags = {
            Status.NO_CONTACT: ~frame.contact,
            Status.NO_DIRECTION: frame.contact & facts.angle.still,
            Status.IMPLAUSIBLE: frame.contact & facts.judged.implausible,
            Status.INPUT_SATURATED: frame.saturated,
            Status.OUTPUT_SATURATED: facts.judged.limited | facts.friction.overflow | limited,
        }
        return [flags.get(status, Const(0, 1)) for status in Status]

    def _insert_taxels(self, m: Module, skid: SkidBuffer, taxels: Signal, limited: Signal, ends_header: Value) -> None:
        """Forces between the header's last word and the status."""
        transfer = self.taxel.valid & self.taxel.ready
        m.d.comb += self.taxel.ready.eq(taxels & skid.i.ready)
        with m.If(taxels):
            m.d.comb += skid.i.valid.eq(self.taxel.valid)
            m.d.comb += skid.i.p.data.eq(self.taxel.p.word)
        with m.If(ends_header):
            m.d.sync += taxels.eq(1)
            m.d.sync += limited.eq(0)
        with m.Elif(transfer):
            m.d.sync += taxels.eq(~self.taxel.p.last)
            m.d.sync += limited.eq(limited | self.taxel.p.limited)
