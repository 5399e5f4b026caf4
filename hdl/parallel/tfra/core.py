"""The core: every block of the algorithm, wired in the order data flows.

::

    taxel ─┬▶ normaliser ─▶ fold ─▶ matvec ⟲ weights, combine ─▶ forces ─▶ scaling ─▶ result
           └▶ centroids ─▶ dependent ─▶ sweep ─▶ friction ─▶ resultant ─▶ gain ──┘
"""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Shape, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl import ports
from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.lib.streams import Buffer, Fork, PerFrameQueue, Router
from tfra.hdl.microarchitecture import Probe
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.angle import Angle
from tfra.hdl.parallel.gain import Gain
from tfra.hdl.parallel.matvec.unit import MatVec
from tfra.hdl.parallel.normaliser import Normaliser
from tfra.hdl.parallel.scaling import Scaling
from tfra.hdl.parallel.tfra.centroids import Centroids
from tfra.hdl.parallel.tfra.combine.unit import Combine
from tfra.hdl.parallel.tfra.dependent import Dependent
from tfra.hdl.parallel.tfra.forces import Forces
from tfra.hdl.parallel.tfra.friction import Friction
from tfra.hdl.parallel.tfra.resultant import Resultant
from tfra.hdl.parallel.tfra.sums_queue import SumsQueue
from tfra.hdl.parallel.tfra.sweep.unit import Sweep
from tfra.hdl.parallel.tfra.weights import Weights
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.operators import PRODUCTS

_FAR = ("frame", "direction", "affine")
"""Facts that pass through a register, which keeps the way from their users to their sender short."""

_HELD = 8
"""Frames of which the core may hold facts: those in flight, those whose forces wait, and one at either end."""


def probes(design: Design) -> tuple[Probe, ...]:
    """Every probe, in the order in which data reach them."""
    q, vector = design.quads, payloads.vector_quad(design)
    products = sum(design.stacks[name].quads for name in PRODUCTS)
    places = (0, 1, 2, 3)
    rows: list[tuple[str, str, Any, tuple[int | str, ...], int]] = [
        ("normaliser", "quads", payloads.stress_quad(design), places, q),
        ("centroids", "direction", payloads.direction(design), ("cos", "sin"), 1),
        ("matvec", "result.words", vector, places, products),
        ("weights", "n", vector, places, q),
        ("dependent", "affine", payloads.affine(design), ("alpha", "beta"), 1),
        ("combine", "vector.words", vector, places, 3 * q),
        ("sweep", "index", payloads.sweep_index(design), (), 1),
        ("friction", "chosen", payloads.chosen(design), ("mu_ind", "mu_x", "mu_y"), 1),
        ("gain", "gain", payloads.gain(design), ("mantissa", "mu"), 1),
    ]
    found = []
    for stage, port, shape, keys, transfers in rows:
        members = [shape[key].shape for key in keys] if keys else [shape]
        words = tuple((Shape.cast(member).width, Shape.cast(member).signed) for member in members)
        found.append(Probe(stage, port, keys, words, transfers))
    return tuple(found)


def make_blocks(design: Design) -> dict[str, Any]:
    """Every block of the core by its name, in the order in which data reach them."""
    return {
        "normaliser": Normaliser(design),
        "centroids": Centroids(design),
        "fold": Butterfly(design.widths.stress),
        "weights": Weights(design),
        "matvec": MatVec(design),
        "dependent": Dependent(design),
        "combine": Combine(design),
        "sweep": Sweep(design),
        "friction": Friction(design),
        "resultant": Resultant(design),
        "gain": Gain(design),
        "forces": Forces(design),
        "angle": Angle(design),
        "scaling": Scaling(design),
    }


class Core(wiring.Component):
    """Triaxial contact forces of a stream of tactile frames.

    Members:
        load: if ``design.images`` is "load", coefficients after a reset, lane by lane as
            :func:`tfra.hdl.parallel.matvec.images.lane_images` has them; taxels wait for the last one.
        taxel: converter codes, row-major, ``m`` transfers a frame.
        result: words of :func:`tfra.model.fixed.words.layout`, ``last`` on a frame's final word.

    Frames follow each other without a gap or a reset; both ports may stall at any time.
    """

    def __init__(self, design: Design) -> None:
        self.design = design
        load = {"load": In(stream.Signature(signed(design.formats.coefficient)))} if design.images == "load" else {}
        super().__init__(
            {
                **load,
                "taxel": In(stream.Signature(ports.taxel(design))),
                "result": Out(stream.Signature(ports.result(design))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        blocks = make_blocks(self.design)
        for name, block in blocks.items():
            m.submodules[name] = block
        self._wire_input(m, blocks)
        self._wire_products(m, blocks)
        self._wire_results(m, blocks)
        self._wire_facts(m, blocks)
        self._wire_angle(m, blocks["angle"], blocks["gain"], blocks["scaling"].phi)
        connect(m, blocks["forces"].taxel, blocks["scaling"].taxel)
        connect(m, blocks["scaling"].result, flipped(self.result))
        for probe in probes(self.design):
            self._probe(m, probe, blocks[probe.stage])
        return m

    def _probe(self, m: Module, probe: Probe, block: Any) -> None:
        """Name a stream for those who watch a simulation; costs nothing, since nothing depends on it."""
        transfer = Signal(name=f"probe_{probe.stage}")
        words = Signal(sum(bits for bits, _ in probe.words), name=f"probe_{probe.stage}_words")
        name, _, member = probe.port.partition(".")
        port = getattr(block, name)
        payload = port.payload[member] if member else port.payload
        members = [payload[key] for key in probe.keys] if probe.keys else [payload]
        m.d.comb += [transfer.eq(port.valid & port.ready), words.eq(Cat(members))]

    def _wire_input(self, m: Module, blocks: dict[str, Any]) -> None:
        """Taxels to the normaliser and to the centroids; the normalised frame to the fold and to the sweep.

        Behind a frame's first quad the others follow in every cycle, as the products of b want them: the bank of b is
        free by then, and the sweep has a place for the stress of every frame that may be in the core.
        """
        shape = payloads.stress_quad(self.design)
        m.submodules.taxel_fork = taxels = Fork(ports.taxel(self.design), 2)
        go: Value = Const(1)
        if self.design.images == "load":
            connect(m, flipped(self.load), blocks["matvec"].load)
            go = ~blocks["matvec"].loading
        m.d.comb += [
            taxels.i.payload.eq(self.taxel.payload),
            taxels.i.valid.eq(self.taxel.valid & go),
            self.taxel.ready.eq(taxels.i.ready & go),
        ]
        connect(m, taxels.o[0], blocks["normaliser"].taxel)
        connect(m, taxels.o[1], blocks["centroids"].taxel)
        m.submodules.stress_fork = stress = Fork(shape, 2)
        connect(m, blocks["normaliser"].quads, stress.i)
        connect(m, stress.o[0], blocks["fold"].i)
        connect(m, stress.o[1], blocks["sweep"].stress)

    def _wire_products(self, m: Module, blocks: dict[str, Any]) -> None:
        """Operands to the products, and leave to go to those who must ask for it."""
        matvec, combine, forces = blocks["matvec"], blocks["combine"], blocks["forces"]
        connect(m, blocks["fold"].o, matvec.b)
        m.d.comb += [
            combine.b.valid.eq(matvec.b.valid & matvec.b.ready),
            combine.b.payload.eq(matvec.b.payload),
        ]
        n = blocks["weights"].n
        for block in (combine, matvec):
            m.d.comb += [block.n.valid.eq(n.valid), block.n.payload.eq(n.payload)]
        connect(m, combine.vector, matvec.vector)
        connect(m, combine.forces, forces.folded)
        connect(m, combine.frame, matvec.frame)
        connect(m, forces.room, matvec.planes)
        connect(m, matvec.room, combine.room)

    def _wire_results(self, m: Module, blocks: dict[str, Any]) -> None:
        """Results of the products to those who wait for them."""
        m.submodules.sums = sums = SumsQueue(self.design)
        connect(m, sums.o, blocks["dependent"].sums)
        operators = {
            "weights": (["c33_inv"], blocks["weights"].solution),
            "sums_b": (["sums_b"], sums.b),
            "sums_n": (["sums_n"], sums.n),
            "residual": (["c33", "c31", "c32"], blocks["combine"].residual),
            "g": (["c33"], blocks["sweep"].g),
            "normal": (["normal"], blocks["sweep"].normal),
            "products": (["pinv1", "pinv2", "pinv3"], blocks["combine"].products),
        }
        table = [
            [way for way, (names, _) in enumerate(operators.values()) if kind in names] for kind in self.design.kinds
        ]
        m.submodules.result_router = router = Router(payloads.product(self.design), table, len(operators))
        connect(m, blocks["matvec"].result, router.i)
        for way, (_, sink) in enumerate(operators.values()):
            connect(m, router.o[way], sink)

    def _wire_facts(self, m: Module, blocks: dict[str, Any]) -> None:
        """Per-frame facts to all who need them, what each of them looks at, in a queue of its own."""
        design = self.design
        regular = ("contact", "traction")
        connect(m, blocks["sweep"].index, blocks["friction"].index)
        users: dict[str, tuple[Any, str, dict[str, tuple[str, ...]]]] = {
            "frame": (
                payloads.frame_facts(design),
                "normaliser",
                {
                    "weights": regular,
                    "dependent": regular,
                    "sweep": ("exponent",),
                    "friction": regular,
                    "resultant": regular,
                    "gain": ("exponent", "magnitude", "contact", "traction"),
                    "scaling": ("exponent", "contact", "traction", "saturated"),
                },
            ),
            "direction": (
                payloads.direction(design),
                "centroids",
                {
                    "dependent": ("cos", "sin", "sweep_y"),
                    "combine": ("sweep_y",),
                    "sweep": ("negative",),
                    "friction": ("sweep_y", "negative"),
                    "angle": ("cos", "sin"),
                    "scaling": ("vanishing",),
                },
            ),
            "affine": (
                payloads.affine(design),
                "dependent",
                {
                    "combine": ("alpha", "beta"),
                    "friction": ("alpha", "beta"),
                    "resultant": ("sums", "significant"),
                    "scaling": ("vanishing",),
                },
            ),
            "chosen": (
                payloads.chosen(design),
                "friction",
                {
                    "combine": ("mu_ind",),
                    "combine.forced": ("mu_x", "mu_y"),
                    "resultant": ("mu_x", "mu_y"),
                    "scaling": ("index", "mu_x", "mu_y", "out_of_range"),
                },
            ),
            "total": (payloads.total(design), "resultant", {"gain": ("words", "exponent"), "scaling": ("words",)}),
            "gain": (payloads.gain(design), "gain", {"scaling": ()}),
        }
        for name, (shape, source, fields) in users.items():
            m.submodules[f"{name}_fork"] = fork = Fork(shape, len(fields))
            sent = getattr(blocks[source], name)
            if name in _FAR:
                m.submodules[f"{name}_sent"] = buffer = Buffer(shape)
                connect(m, sent, buffer.i)
                sent = buffer.o
            connect(m, sent, fork.i)
            for way, (user, looked_at) in enumerate(fields.items()):
                block, _, port = user.partition(".")
                sink, label = getattr(blocks[block], port or name), f"{name}_{user.replace('.', '_')}"
                connect(m, fork.o[way], self._facts(m, label, shape, looked_at, _HELD, sink))

    def _wire_angle(self, m: Module, angle: Any, gain: Any, phi: Any) -> None:
        """The CORDIC's other user; phi, long before the result needs it."""
        connect(m, gain.vector, angle.vector)
        connect(m, angle.turned, gain.turned)
        connect(m, angle.phi, self._facts(m, "phi", phi.payload.shape(), (), _HELD, phi))

    def _facts(self, m: Module, label: str, shape: Any, fields: tuple[str, ...], depth: int, sink: Any) -> Any:
        m.submodules[f"{label}_facts"] = facts = PerFrameQueue(shape, fields, depth)
        connect(m, facts.o, sink)
        return facts.i
