"""The core: every block of the algorithm, wired in dataflow order.

::

    taxel ─┬▶ normaliser ─▶ fold ─▶ matvec ⟲ weights, combine ─▶ forces ─▶ scaling ─▶ result
           └▶ centroids ─▶ dependent ─▶ sweep ─▶ friction ─▶ resultant ─▶ gain ──┘
"""

from amaranth import Module
from amaranth.lib.wiring import connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.lib.streams import Fork, Router, broadcast
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.core.core import PLACES, Core, Watched
from tfra.hdl.parallel.core.microarchitecture import Parallel
from tfra.hdl.parallel.tfra.blocks import FACTS, Blocks, product_routes
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.forces import PLANES
from tfra.hdl.parallel.tfra.sums_queue import SumsQueue
from tfra.hdl.parallel.tfra.timeline import TfraTimeline
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.pipeline import Stage


class TfraCore(Core):
    """Triaxial contact forces of a stream of tactile frames."""

    fact_depth = FRAMES + PLANES // 3 + 2
    """Those in flight, those whose forces wait, and one at either end."""

    blocks = Blocks

    @staticmethod
    def watched(design: Design) -> list[Watched]:
        """A stream of each :class:`Stage` but the last, whose words leave at the result port."""
        q = design.quads
        return [
            Watched(Stage.NORMALISER, "quads", PLACES, q),
            Watched(Stage.CENTROIDS, "direction", ("cos", "sin")),
            Watched(Stage.MATVEC, "result.words", PLACES, sum(design.stacks[name].quads for name in design.products)),
            Watched(Stage.WEIGHTS, "n", PLACES, q),
            Watched(Stage.DEPENDENT, "affine", ("alpha", "beta")),
            Watched(Stage.COMBINE, "vector.words", PLACES, 3 * q),
            Watched(Stage.SWEEP, "index", ()),
            Watched(Stage.FRICTION, "chosen", ("mu_ind", "mu_x", "mu_y")),
            Watched(Stage.RESULTANT, "total.words", (0, 1, 2)),
            Watched(Stage.GAIN, "gain", ("mantissa", "mu")),
            Watched(Stage.FORCES, "taxel", (), 3 * design.sensor.taxels),
            Watched(Stage.ANGLE, "phi", ()),
        ]

    def wire(self, m: Module, blocks: Blocks) -> None:
        """Connect the blocks with each other and with ``result``."""
        self._wire_input(m, blocks)
        self._wire_products(m, blocks)
        self._wire_results(m, blocks)
        for fact in FACTS:
            self.wire_fact(m, blocks, fact)
        connect(m, blocks.sweep.index, blocks.friction.index)
        self._wire_angle(m, blocks)
        connect(m, blocks.forces.taxel, blocks.scaling.taxel)
        connect(m, blocks.scaling.result, flipped(self.result))

    def _wire_input(self, m: Module, blocks: Blocks) -> None:
        """Taxels to the normaliser and to the centroids; the normalised frame to the fold and to the sweep.

        After a frame's first quad the others follow in every cycle, as the products of b require: the bank of b is
        free by then, and the sweep has a place for the stress of every frame that may be in the core.
        """
        m.submodules.taxel_fork = taxels = Fork(ports.taxel(self.design), 2)
        self.wire_taxels(m, blocks, taxels.i)
        connect(m, taxels.o[0], blocks.normaliser.taxel)
        connect(m, taxels.o[1], blocks.centroids.taxel)
        m.submodules.stress_fork = stress = Fork(payloads.stress_quad(self.design), 2)
        connect(m, blocks.normaliser.quads, stress.i)
        connect(m, stress.o[0], blocks.fold.i)
        connect(m, stress.o[1], blocks.sweep.stress)

    def _wire_products(self, m: Module, blocks: Blocks) -> None:
        """Operands to the products, and tokens to the blocks that need them."""
        matvec, combine, forces = blocks.matvec, blocks.combine, blocks.forces
        connect(m, blocks.fold.o, matvec.b)
        m.d.comb += [
            combine.b.valid.eq(matvec.b.valid & matvec.b.ready),
            combine.b.payload.eq(matvec.b.payload),
        ]
        broadcast(m, blocks.weights.n, combine.n, matvec.n)
        connect(m, combine.vector, matvec.vector)
        connect(m, combine.forces, forces.folded)
        connect(m, combine.frame_token, matvec.frame_token)
        connect(m, forces.plane_token, matvec.plane_token)
        connect(m, matvec.bank_token, combine.bank_token)

    def _wire_results(self, m: Module, blocks: Blocks) -> None:
        """Results of the products to their users."""
        m.submodules.sums = sums = SumsQueue(self.design)
        connect(m, sums.o, blocks.dependent.sums)
        routes = product_routes(blocks, sums)
        table = [[way for way, (_, operators) in enumerate(routes) if kind in operators] for kind in self.design.kinds]
        m.submodules.result_router = router = Router(payloads.product(self.design), table, len(routes))
        connect(m, blocks.matvec.result, router.i)
        for way, (sink, _) in enumerate(routes):
            connect(m, router.o[way], sink)

    def _wire_angle(self, m: Module, blocks: Blocks) -> None:
        """The second user of the CORDIC: phi, long before the result needs it."""
        connect(m, blocks.gain.vector, blocks.angle.vector)
        connect(m, blocks.angle.turned, blocks.gain.turned)
        phi = blocks.angle.phi
        fifo = self.fact_fifo(m, "phi", phi.payload.shape())
        connect(m, phi, fifo.i)
        connect(m, fifo.o, blocks.scaling.phi)


class TfraParallel(Parallel[Design, TfraTimeline]):
    """The core of blocks that stream to each other."""

    core = TfraCore
    trace = TfraTimeline
