"""The core of the learned estimator: every block, wired in dataflow order.

::

    taxel ─▶ normaliser ─▶ fold ─▶ matvec ⟲ activation
                                     ├▶ total ─▶ resultant ─▶ angle ─▶ friction ─▶ words ─▶ result
                                     └▶ field ◀────────────────────────┘             ▲
                                          └▶ share ─▶ forces ────────────────────────┘
"""

from amaranth import Module
from amaranth.lib.wiring import connect, flipped

from tfra.hdl.lib.streams import broadcast
from tfra.hdl.parallel.core.core import PLACES, Core, Fact, Watched
from tfra.hdl.parallel.core.microarchitecture import Parallel
from tfra.hdl.parallel.learned.blocks import Blocks
from tfra.hdl.parallel.learned.payloads import contact, header, share
from tfra.hdl.parallel.learned.plan import FRAMES, UNITS
from tfra.hdl.parallel.learned.timeline import LearnedTimeline
from tfra.hdl.parallel.learned.total import QUADS
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.pipeline import Stage


class LearnedCore(Core):
    """Resultant of a stream of tactile frames, and triaxial forces at the taxels if the design gives them."""

    fact_depth = FRAMES + 2
    """Those in flight, and one at either end of b's bank."""

    blocks = Blocks

    @staticmethod
    def watched(design: LearnedDesign) -> list[Watched]:
        """A stream of each :class:`Stage` but the last, whose words leave at the result port."""
        operators = [op for name in design.products for op in design.stacks[name].operators]
        return [
            Watched(Stage.NORMALISER, "quads", PLACES, design.quads),
            Watched(Stage.MATVEC, "result.words", PLACES, sum(op.quads for op in operators)),
            Watched(Stage.ACTIVATION, "units.words", PLACES, sum(op.quads for op in operators if op.name in UNITS)),
            Watched(Stage.TOTAL, "total", PLACES, QUADS),
            Watched(Stage.RESULTANT, "force.words", (0, 1, 2)),
            Watched(Stage.ANGLE, "angle", ("phi",)),
            Watched(Stage.FRICTION, "friction", ("mu", "mu_x", "mu_y")),
            Watched(Stage.FIELD, "p", PLACES, design.quads),
            Watched(Stage.SHARE, "share", ("mantissa",), 3),
        ]

    def wire(self, m: Module, blocks: Blocks) -> None:
        """Connect the blocks with each other and with ``result``."""
        self._wire_input(m, blocks)
        self._wire_products(m, blocks)
        self._wire_scalars(m, blocks)
        if self.design.taxel_forces:
            self._wire_forces(m, blocks)
        connect(m, blocks.words.result, flipped(self.result))

    def _wire_input(self, m: Module, blocks: Blocks) -> None:
        """Taxels to the normaliser, the normalised frame to the first product, its facts to their users."""
        self.wire_taxels(m, blocks, blocks.normaliser.taxel)
        connect(m, blocks.normaliser.quads, blocks.fold.i)
        connect(m, blocks.fold.o, blocks.matvec.b)
        users = {"total": ("contact",), "words": ("exponent", "contact", "saturated")}
        self.wire_fact(m, blocks, Fact("normaliser.frame", users))

    def _wire_products(self, m: Module, blocks: Blocks) -> None:
        """Results to their users, units back to the products, and tokens to the products."""
        matvec, units = blocks.matvec, blocks.activation.units
        broadcast(m, matvec.result, blocks.activation.result, blocks.total.result)
        for number, name in enumerate(self.design.kinds):
            if name in UNITS:
                source = getattr(matvec, UNITS[name])
                m.d.comb += [
                    source.valid.eq(units.valid & units.p.kind[number]),
                    source.payload.eq(units.p.words),
                ]
        connect(m, blocks.words.frame_token, matvec.frame_token)
        connect(m, blocks.friction.scalars_token, matvec.scalars_token)

    def _wire_scalars(self, m: Module, blocks: Blocks) -> None:
        """Outputs to the header of a frame, which is complete when its friction is."""
        friction = blocks.friction
        # What the header takes with the friction is complete by then.
        to_friction = blocks.resultant.latency + friction.latency
        assert to_friction >= blocks.resultant.judged_latency + self.design.cycles_per_quad
        assert friction.latency >= blocks.angle.angle_latency
        connect(m, blocks.total.total, blocks.resultant.total)
        broadcast(m, blocks.resultant.force, blocks.angle.force, friction.force)
        connect(m, blocks.angle.modulus, friction.modulus)
        fifo = self.fact_fifo(m, "header", header(self.design))
        m.d.comb += [
            fifo.i.valid.eq(friction.friction.valid),
            fifo.i.p.judged.eq(blocks.resultant.judged),
            fifo.i.p.angle.eq(blocks.angle.angle.payload),
            fifo.i.p.friction.eq(friction.friction.payload),
        ]
        connect(m, fifo.o, blocks.words.header)

    def _wire_forces(self, m: Module, blocks: Blocks) -> None:
        """The field from its products and the friction, and its share of the resultant."""
        field, part, forces = blocks.field, blocks.share, blocks.forces
        friction = blocks.friction.friction
        broadcast(m, blocks.matvec.result, field.result)
        for user, fields in (("field", ("mu_x", "mu_y")), ("share", ("total",))):
            fifo = self.fact_fifo(m, f"contact_{user}", contact(self.design), fields)
            m.d.comb += [
                fifo.i.valid.eq(friction.valid),
                fifo.i.p.total.eq(blocks.resultant.force.payload),
                fifo.i.p.mu_x.eq(friction.p.mu_x),
                fifo.i.p.mu_y.eq(friction.p.mu_y),
            ]
            connect(m, fifo.o, getattr(blocks, user).contact)
        connect(m, part.share_token, field.share_token)
        broadcast(m, field.p, part.p, forces.p)
        shares = self.fact_fifo(m, "share", share(self.design), transfers=3)
        broadcast(m, part.share, shares.i)
        connect(m, shares.o, forces.share)
        connect(m, forces.taxel, blocks.words.taxel)


class LearnedParallel(Parallel[LearnedDesign, LearnedTimeline]):
    """The core of blocks that stream to each other."""

    core = LearnedCore
    trace = LearnedTimeline
