"""The core of the learned estimator: every block, wired in dataflow order.

::

    taxel ─▶ normaliser ─▶ fold ─▶ matvec ⟲ activation
                                     ├▶ total ─▶ resultant ─▶ angle ─▶ friction ─▶ words ─▶ result
                                     └▶ field ◀────────────────────────┘             ▲
                                          └▶ share ─▶ forces ────────────────────────┘
"""

from __future__ import annotations

from typing import Any

from amaranth import Const, Module, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.lib.streams import Fork, PerFrameFifo
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.learned.blocks import AtTaxels, Blocks
from tfra.hdl.parallel.learned.payloads import contact, header, share
from tfra.hdl.parallel.learned.plan import FRAMES, UNITS
from tfra.hdl.parallel.learned.probes import probes
from tfra.hdl.parallel.probes import add_probe
from tfra.model.fixed.learned.design import LearnedDesign

HELD = FRAMES + 2
"""Most frames whose facts the core holds: those in flight, and one at either end of b's bank."""


class LearnedCore(wiring.Component):
    """Resultant of a stream of tactile frames, and triaxial forces at the taxels if the design gives them.

    Members:
        load: if ``design.images`` is "load", coefficients after a reset, lane by lane as
            :func:`tfra.hdl.parallel.matvec.images.lane_images` has them; taxels wait for the last one.
        taxel: converter codes, row-major, ``m`` transfers a frame.
        result: words of ``design.layout``, ``last`` on a frame's final word.

    Frames follow each other without a gap or a reset; both ports may stall at any time.
    """

    def __init__(self, design: LearnedDesign) -> None:
        self.design = design
        load = {"load": In(stream.Signature(signed(design.coefficient_word)))} if design.images == "load" else {}
        super().__init__(
            {
                **load,
                "taxel": In(stream.Signature(ports.taxel(design))),
                "result": Out(stream.Signature(ports.result(design))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        blocks = Blocks.of(self.design)
        for name, block in blocks:
            m.submodules[name] = block
        self._wire_input(m, blocks)
        self._wire_products(m, blocks)
        self._wire_scalars(m, blocks)
        if blocks.at_taxels:
            self._wire_forces(m, blocks, blocks.at_taxels)
        connect(m, blocks.words.result, flipped(self.result))
        by_name = dict(blocks)
        for probe in probes(self.design):
            add_probe(m, probe, by_name[probe.stage])
        return m

    def _wire_input(self, m: Module, blocks: Blocks) -> None:
        """Taxels to the normaliser, the normalised frame to the first product, its facts to their users."""
        go: Value = Const(1)
        if self.design.images == "load":
            connect(m, flipped(self.load), blocks.matvec.load)
            go = ~blocks.matvec.loading
        m.d.comb += [
            blocks.normaliser.taxel.payload.eq(self.taxel.payload),
            blocks.normaliser.taxel.valid.eq(self.taxel.valid & go),
            self.taxel.ready.eq(blocks.normaliser.taxel.ready & go),
        ]
        connect(m, blocks.normaliser.quads, blocks.fold.i)
        connect(m, blocks.fold.o, blocks.matvec.b)
        shape = payloads.frame_facts(self.design)
        m.submodules.frame_fork = fork = Fork(shape, 2)
        connect(m, blocks.normaliser.frame, fork.i)
        users = {"total": ("contact",), "words": ("exponent", "contact", "saturated")}
        for (user, fields), o in zip(users.items(), fork.o, strict=True):
            m.submodules[f"frame_{user}_facts"] = queue = PerFrameFifo(shape, fields, HELD)
            connect(m, o, queue.i)
            connect(m, queue.o, getattr(blocks, user).frame)

    def _wire_products(self, m: Module, blocks: Blocks) -> None:
        """Results to their users, units back to the products, and tokens to the products."""
        matvec, units = blocks.matvec, blocks.activation.units
        for user in (blocks.activation, blocks.total):
            m.d.comb += [user.result.valid.eq(matvec.result.valid), user.result.payload.eq(matvec.result.payload)]
        for number, name in enumerate(self.design.kinds):
            if name in UNITS:
                source = getattr(matvec, UNITS[name])
                m.d.comb += [source.valid.eq(units.valid & units.p.kind[number]), source.payload.eq(units.p.words)]
        connect(m, blocks.words.frame_token, matvec.frame_token)
        connect(m, blocks.friction.scalars_token, matvec.scalars_token)

    def _wire_scalars(self, m: Module, blocks: Blocks) -> None:
        """Outputs to the header of a frame, which is complete when its friction is."""
        force, friction = blocks.resultant.force, blocks.friction
        # What the header takes when friction is found is complete by then.
        found = blocks.resultant.latency + friction.latency
        assert found >= blocks.resultant.judged_latency + self.design.cycles_per_quad
        assert friction.latency >= blocks.angle.angle_latency
        connect(m, blocks.total.total, blocks.resultant.total)
        for user in (blocks.angle, friction):
            m.d.comb += [user.force.valid.eq(force.valid), user.force.payload.eq(force.payload)]
        connect(m, blocks.angle.modulus, friction.modulus)
        m.submodules.header_facts = queue = PerFrameFifo(header(self.design), (), HELD)
        m.d.comb += [
            queue.i.valid.eq(friction.friction.valid),
            queue.i.p.judged.eq(blocks.resultant.judged),
            queue.i.p.angle.eq(blocks.angle.angle.payload),
            queue.i.p.friction.eq(friction.friction.payload),
        ]
        connect(m, queue.o, blocks.words.header)

    def _wire_forces(self, m: Module, blocks: Blocks, at_taxels: AtTaxels) -> None:
        """The field from its products and the friction, and its share of the resultant."""
        matvec, friction = blocks.matvec, blocks.friction.friction
        field, part, forces = at_taxels.field, at_taxels.share, at_taxels.forces
        m.d.comb += [field.result.valid.eq(matvec.result.valid), field.result.payload.eq(matvec.result.payload)]
        for user, fields in ((field, ("mu_x", "mu_y")), (part, ("total",))):
            name = "field" if user is field else "share"
            m.submodules[f"contact_{name}_facts"] = queue = PerFrameFifo(contact(self.design), fields, HELD)
            m.d.comb += [
                queue.i.valid.eq(friction.valid),
                queue.i.p.total.eq(blocks.resultant.force.payload),
                queue.i.p.mu_x.eq(friction.p.mu_x),
                queue.i.p.mu_y.eq(friction.p.mu_y),
            ]
            connect(m, queue.o, user.contact)
        connect(m, part.share_token, field.share_token)
        for sink in (part, forces):
            m.d.comb += [sink.p.valid.eq(field.p.valid), sink.p.payload.eq(field.p.payload)]
        m.submodules.share_facts = shares = PerFrameFifo(share(self.design), (), 3 * HELD)
        m.d.comb += [shares.i.valid.eq(part.share.valid), shares.i.payload.eq(part.share.payload)]
        connect(m, shares.o, forces.share)
        connect(m, forces.taxel, blocks.words.taxel)
