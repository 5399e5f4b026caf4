"""The core: every block of the algorithm, wired in dataflow order.

::

    taxel ─┬▶ normaliser ─▶ fold ─▶ matvec ⟲ weights, combine ─▶ forces ─▶ scaling ─▶ result
           └▶ centroids ─▶ dependent ─▶ sweep ─▶ friction ─▶ resultant ─▶ gain ──┘
"""

from __future__ import annotations

from typing import Any

from amaranth import Const, Module, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.lib.streams import Buffer, Fork, PerFrameFifo, Router
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.probes import add_probe
from tfra.hdl.parallel.tfra.blocks import Blocks
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.forces import PLANES
from tfra.hdl.parallel.tfra.probes import probes
from tfra.hdl.parallel.tfra.routes import Fact, FactRoute, facts, product_routes
from tfra.hdl.parallel.tfra.sums_queue import SumsQueue
from tfra.model.fixed.design import Design

HELD = FRAMES + PLANES // 3 + 2
"""Most frames whose facts the core holds: those in flight, those whose forces wait, and one at either end."""


class Core(wiring.Component):
    """Triaxial contact forces of a stream of tactile frames.

    Members:
        load: if ``design.images`` is "load", coefficients after a reset, lane by lane as
            :func:`tfra.hdl.parallel.matvec.images.lane_images` has them; taxels wait for the last one.
        taxel: converter codes, row-major, ``m`` transfers a frame.
        result: words of ``design.layout``, ``last`` on a frame's final word.

    Frames follow each other without a gap or a reset; both ports may stall at any time.
    """

    def __init__(self, design: Design) -> None:
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
        self._wire_results(m, blocks)
        for fact in facts(blocks):
            self._wire_fact(m, fact)
        connect(m, blocks.sweep.index, blocks.friction.index)
        self._wire_angle(m, blocks)
        connect(m, blocks.forces.taxel, blocks.scaling.taxel)
        connect(m, blocks.scaling.result, flipped(self.result))
        for probe in probes(self.design):
            add_probe(m, probe, getattr(blocks, probe.stage))
        return m

    def _wire_input(self, m: Module, blocks: Blocks) -> None:
        """Taxels to the normaliser and to the centroids; the normalised frame to the fold and to the sweep.

        After a frame's first quad the others follow in every cycle, as the products of b require: the bank of b is
        free by then, and the sweep has a place for the stress of every frame that may be in the core.
        """
        shape = payloads.stress_quad(self.design)
        m.submodules.taxel_fork = taxels = Fork(ports.taxel(self.design), 2)
        go: Value = Const(1)
        if self.design.images == "load":
            connect(m, flipped(self.load), blocks.matvec.load)
            go = ~blocks.matvec.loading
        m.d.comb += [
            taxels.i.payload.eq(self.taxel.payload),
            taxels.i.valid.eq(self.taxel.valid & go),
            self.taxel.ready.eq(taxels.i.ready & go),
        ]
        connect(m, taxels.o[0], blocks.normaliser.taxel)
        connect(m, taxels.o[1], blocks.centroids.taxel)
        m.submodules.stress_fork = stress = Fork(shape, 2)
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
        n = blocks.weights.n
        for block in (combine, matvec):
            m.d.comb += [block.n.valid.eq(n.valid), block.n.payload.eq(n.payload)]
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
        table = [
            [way for way, route in enumerate(routes) if kind in route.operators] for kind in self.design.kinds
        ]
        m.submodules.result_router = router = Router(payloads.product(self.design), table, len(routes))
        connect(m, blocks.matvec.result, router.i)
        for way, route in enumerate(routes):
            connect(m, router.o[way], route.sink)

    def _wire_fact(self, m: Module, fact: Fact) -> None:
        """A fact to all its users, each with its own queue, so that no block waits for another."""
        shape, sent = fact.source.payload.shape(), fact.source
        m.submodules[f"{fact.name}_fork"] = fork = Fork(shape, len(fact.routes))
        if fact.registered:
            m.submodules[f"{fact.name}_sent"] = buffer = Buffer(shape)
            connect(m, sent, buffer.i)
            sent = buffer.o
        connect(m, sent, fork.i)
        for way, route in enumerate(fact.routes):
            self._queue(m, f"{fact.name}_{route.user}_facts", fork.o[way], route)

    def _wire_angle(self, m: Module, blocks: Blocks) -> None:
        """The second user of the CORDIC: phi, long before the result needs it."""
        connect(m, blocks.gain.vector, blocks.angle.vector)
        connect(m, blocks.angle.turned, blocks.gain.turned)
        self._queue(m, "phi_facts", blocks.angle.phi, FactRoute("scaling", blocks.scaling.phi))

    def _queue(self, m: Module, name: str, source: Any, route: FactRoute) -> None:
        m.submodules[name] = queue = PerFrameFifo(source.payload.shape(), route.fields, HELD)
        connect(m, source, queue.i)
        connect(m, queue.o, route.sink)
