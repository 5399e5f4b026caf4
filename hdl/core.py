"""The core: every block of the algorithm, wired in the order data flows.

::

    taxel ─┬▶ normaliser ─▶ fold ─▶ matvec ⟲ weights, combine ─▶ forces ─▶ scaling ─▶ result
           └▶ centroids ─▶ dependent ─▶ sweep ─▶ friction ─▶ resultant ─▶ gain ──┘
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from amaranth import Cat, Module, Shape, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl import payloads
from tfra.hdl.arithmetic import quad
from tfra.hdl.butterfly import Butterfly
from tfra.hdl.centroids import Centroids
from tfra.hdl.combine import Combine
from tfra.hdl.cordic import Cordic
from tfra.hdl.dependent import Dependent
from tfra.hdl.forces import Forces
from tfra.hdl.friction import Friction
from tfra.hdl.gain import Gain
from tfra.hdl.matvec import MatVec
from tfra.hdl.normaliser import Normaliser
from tfra.hdl.resultant import Resultant
from tfra.hdl.scaling import Scaling
from tfra.hdl.streams import Buffer, Fork, Merge, Queue, Router
from tfra.hdl.sweep import Sweep
from tfra.hdl.weights import Weights
from tfra.model.design import Design
from tfra.model.fixed.coefficients import PRODUCTS, stacks
from tfra.model.fixed.widths import DIVISION_GUARD, widths


@dataclass(frozen=True)
class Probe:
    """A stream between blocks that a simulation may watch: ``probe_STAGE`` is high for every transfer of it.

    ``probe_STAGE_words`` then holds the payload's members ``keys``, the first lowest; ``words`` are their bits and
    sign.  A frame has ``transfers`` of them, equal to ``FixedTfra``'s stage of the same name.
    """

    stage: str
    port: str
    keys: tuple[int | str, ...]
    words: tuple[tuple[int, bool], ...]
    transfers: int


def probes(design: Design) -> tuple[Probe, ...]:
    """Every probe, in the order in which data reach them."""
    q, vector = design.quads, payloads.vector_quad(design)
    products = sum(stacks(design)[name].quads for name in PRODUCTS)
    places = (0, 1, 2, 3)
    rows: list[tuple[str, str, Any, tuple[int | str, ...], int]] = [
        ("normaliser", "quads", payloads.stress_quad(design), places, q),
        ("centroids", "direction", payloads.direction(design), ("cos", "sin"), 1),
        ("matvec", "result", vector, places, products),
        ("weights", "n", vector, places, q),
        ("dependent", "affine", payloads.affine(design), ("alpha", "beta"), 1),
        ("combine", "vector", vector, places, 3 * q),
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


class Core(wiring.Component):
    """Triaxial contact forces of a stream of tactile frames.

    Members:
        taxel: converter codes, row-major, ``m`` transfers a frame.
        result: words of :func:`tfra.model.fixed.words.layout`, ``last`` on a frame's final word.

    Frames follow each other without a gap or a reset; both ports may stall at any time.
    """

    def __init__(self, design: Design) -> None:
        self.design = design
        super().__init__(
            {
                "taxel": In(stream.Signature(payloads.stress(design))),
                "result": Out(stream.Signature(payloads.result(design))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        blocks = self._blocks()
        for name, block in blocks.items():
            m.submodules[name] = block
        self._wire_input(m, blocks)
        self._wire_products(m, blocks)
        self._wire_facts(m, blocks)
        connect(m, blocks["forces"].taxel, blocks["scaling"].taxel)
        connect(m, blocks["scaling"].result, flipped(self.result))
        for probe in probes(self.design):
            self._probe(m, probe, getattr(blocks[probe.stage], probe.port))
        return m

    def _probe(self, m: Module, probe: Probe, port: Any) -> None:
        """Name a stream for those who watch a simulation; costs nothing, since nothing depends on it."""
        transfer = Signal(name=f"probe_{probe.stage}")
        words = Signal(sum(bits for bits, _ in probe.words), name=f"probe_{probe.stage}_words")
        members = [port.payload[key] for key in probe.keys] if probe.keys else [port.payload]
        m.d.comb += [transfer.eq(port.valid & port.ready), words.eq(Cat(members))]

    def _blocks(self) -> dict[str, Any]:
        design = self.design
        return {
            "normaliser": Normaliser(design),
            "centroids": Centroids(design),
            "fold": Butterfly(widths(design).stress),
            "weights": Weights(design),
            "matvec": MatVec(design),
            "dependent": Dependent(design),
            "combine": Combine(design),
            "sweep": Sweep(design),
            "friction": Friction(design),
            "resultant": Resultant(design),
            "gain": Gain(design),
            "forces": Forces(design),
            "phi": Cordic(design),
            "scaling": Scaling(design),
        }

    def _wire_input(self, m: Module, blocks: dict[str, Any]) -> None:
        """Taxels to the normaliser and to the centroids; the normalised frame to the fold and to the sweep."""
        m.submodules.taxel_fork = taxels = Fork(payloads.stress(self.design), 2)
        connect(m, flipped(self.taxel), taxels.i)
        connect(m, taxels.o[0], blocks["normaliser"].taxel)
        connect(m, taxels.o[1], blocks["centroids"].taxel)
        m.submodules.stress_fork = stress = Fork(payloads.stress_quad(self.design), 2)
        connect(m, blocks["normaliser"].quads, stress.i)
        connect(m, stress.o[0], blocks["fold"].i)
        connect(m, stress.o[1], blocks["sweep"].stress)

    def _wire_products(self, m: Module, blocks: dict[str, Any]) -> None:
        """Operands to the products in the order of the schedule, results to those who wait for them."""
        q, vector = self.design.quads, payloads.vector_quad(self.design)
        folded = quad(widths(self.design).stress + 2)
        m.submodules.b_fork = b = Fork(folded, 2)
        m.submodules.n_fork = n = Fork(vector, 2)
        m.submodules.operand_merge = operand = Merge(vector, [(q, 0), (q, 1), (3 * q, 2)], 3)
        # The sweep takes a quad of q in the time of its taxels; the products do not wait for that.
        m.submodules.normal_queue = queue = Queue(vector, q + 2)
        connect(m, queue.o, blocks["sweep"].normal)
        table = [
            (q, ["weights"]),
            (1, ["sums"]),
            (q, ["residual", "g"]),
            (2 * q, ["residual"]),
            (3, ["sums"]),
            (2 * q, ["normal"]),
            (3 * q, ["products"]),
        ]
        sinks = {
            "weights": blocks["weights"].solution,
            "sums": blocks["dependent"].sums,
            "residual": blocks["combine"].residual,
            "g": blocks["sweep"].g,
            "normal": queue.i,
            "products": blocks["combine"].products,
        }
        numbers = {name: number for number, name in enumerate(sinks)}
        m.submodules.result_router = router = Router(
            vector, [(n, [numbers[name] for name in names]) for n, names in table], len(sinks)
        )
        connect(m, blocks["fold"].o, b.i)
        connect(m, b.o[0], blocks["combine"].b)
        m.d.comb += [operand.i[0].valid.eq(b.o[1].valid), b.o[1].ready.eq(operand.i[0].ready)]
        for word, code in zip(operand.i[0].payload, b.o[1].payload, strict=True):
            m.d.comb += word.eq(code << self.design.formats.vector_fraction)
        connect(m, blocks["weights"].n, n.i)
        connect(m, n.o[0], operand.i[1])
        connect(m, n.o[1], blocks["combine"].n)
        connect(m, blocks["combine"].vector, operand.i[2])
        connect(m, operand.o, blocks["matvec"].operand)
        connect(m, blocks["matvec"].result, router.i)
        for number, sink in enumerate(sinks.values()):
            connect(m, router.o[number], sink)
        connect(m, blocks["combine"].forces, blocks["forces"].folded)

    def _wire_facts(self, m: Module, blocks: dict[str, Any]) -> None:
        """Per-frame facts to all who need them.

        Those who need them late share a buffered copy, so that the next frame may start in the meantime.
        """
        design = self.design
        facts = {
            "frame": (
                payloads.frame_facts(design),
                ("weights", "dependent", "sweep"),
                ("friction", "resultant", "gain"),
            ),
            "direction": (payloads.direction(design), ("dependent", "combine", "sweep", "friction", "phi"), ()),
            "affine": (payloads.affine(design), ("combine", "friction", "resultant"), ()),
            "chosen": (payloads.chosen(design), ("combine", "resultant"), ()),
            "total": (payloads.total(design), ("gain",), ()),
            "gain": (payloads.gain(design), (), ()),
        }
        sources = {
            "frame": "normaliser",
            "direction": "centroids",
            "affine": "dependent",
            "chosen": "friction",
            "total": "resultant",
            "gain": "gain",
        }
        connect(m, blocks["sweep"].index, blocks["friction"].index)
        for name, (shape, early, late) in facts.items():
            rest = self._share(m, name, shape, getattr(blocks[sources[name]], name), early, blocks)
            if late:
                rest = self._share(m, f"late_{name}", shape, rest, late, blocks)
            connect(m, rest, getattr(blocks["scaling"], name))

    def _share(
        self, m: Module, label: str, shape: Any, source: Any, users: tuple[str, ...], blocks: dict[str, Any]
    ) -> Any:
        """Give ``source`` to ``users``, and return a buffered copy for those behind them."""
        m.submodules[f"{label}_fork"] = fork = Fork(shape, len(users) + 1)
        m.submodules[f"{label}_buffer"] = buffer = Buffer(shape)
        connect(m, source, fork.i)
        for way, user in enumerate(users):
            if user == "phi":
                self._wire_phi(m, blocks, fork.o[way])
            else:
                connect(m, fork.o[way], getattr(blocks[user], label.removeprefix("late_")))
        connect(m, fork.o[len(users)], buffer.i)
        return buffer.o

    def _wire_phi(self, m: Module, blocks: dict[str, Any], direction: Any) -> None:
        """phi = atan2(sin, cos) by a CORDIC of its own, long before the result needs it."""
        phi, scaling = blocks["phi"], blocks["scaling"].phi
        m.d.comb += [
            phi.i.payload.x.eq(direction.payload.cos << DIVISION_GUARD),
            phi.i.payload.y.eq(direction.payload.sin << DIVISION_GUARD),
            phi.i.valid.eq(direction.valid),
            direction.ready.eq(phi.i.ready),
            scaling.payload.eq(phi.o.payload.angle),
            scaling.valid.eq(phi.o.valid),
            phi.o.ready.eq(scaling.ready),
        ]
