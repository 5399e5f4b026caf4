"""Every block of the core, the products, and the routes of their results and of the facts of a frame."""

from typing import Any

from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.parallel.angle import Angle
from tfra.hdl.parallel.core.core import CoreBlocks, Fact
from tfra.hdl.parallel.gain import Gain
from tfra.hdl.parallel.matvec.plan import Plan, Source
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

PLAN = Plan(
    (
        Source("vector", ("normal", "force"), 2, "bank_token"),
        Source("n", ("residual",), 2, "weight_token"),
        Source("b", ("contact",), 1),
    ),
    {"force": ("plane_token",), "contact": ("frame_token", "weight_token")},
)
"""A contact needs a place of its frame in all that follows, and a bank that its n will need; a product that gives
forces needs their planes."""


class Blocks(CoreBlocks):
    """The blocks in dataflow order."""

    def __init__(self, design: Design) -> None:
        self.normaliser = Normaliser(design)
        self.centroids = Centroids(design)
        self.fold = Butterfly(design.widths.stress)
        self.weights = Weights(design)
        self.matvec = MatVec(design, PLAN)
        self.dependent = Dependent(design)
        self.combine = Combine(design)
        self.sweep = Sweep(design)
        self.friction = Friction(design)
        self.resultant = Resultant(design)
        self.gain = Gain(design)
        self.forces = Forces(design)
        self.angle = Angle(design)
        self.scaling = Scaling(design)


def product_routes(blocks: Blocks, sums: SumsQueue) -> list[tuple[Any, tuple[str, ...]]]:
    """Streams to which the results of these operators go; g goes to two blocks."""
    return [
        (blocks.weights.solution, ("c33_inv",)),
        (sums.b, ("sums_b",)),
        (sums.n, ("sums_n",)),
        (blocks.combine.residual, ("c33", "c31", "c32")),
        (blocks.sweep.g, ("c33",)),
        (blocks.sweep.normal, ("normal",)),
        (blocks.combine.products, ("pinv1", "pinv2", "pinv3")),
    ]


_REGULAR = ("contact", "traction")
_FRAME = {
    "weights": _REGULAR,
    "dependent": _REGULAR,
    "sweep": ("exponent",),
    "friction": _REGULAR,
    "resultant": _REGULAR,
    "gain": ("exponent", "magnitude", "contact", "traction"),
    "scaling": ("exponent", "contact", "traction", "saturated"),
}
_DIRECTION = {
    "dependent": ("cos", "sin", "sweep_y"),
    "combine": ("sweep_y",),
    "sweep": ("negative",),
    "friction": ("sweep_y", "negative"),
    "angle": ("cos", "sin"),
    "scaling": ("vanishing",),
}
_AFFINE = {
    "combine": ("alpha", "beta"),
    "friction": ("alpha", "beta"),
    "resultant": ("sums", "significant"),
    "scaling": ("vanishing",),
}
_CHOSEN = {
    "combine": ("mu_ind",),
    "combine.forced": ("mu_x", "mu_y"),
    "resultant": ("mu_x", "mu_y"),
    "scaling": ("index", "mu_x", "mu_y", "out_of_range"),
}
FACTS = (
    Fact("normaliser.frame", _FRAME, registered=True),
    Fact("centroids.direction", _DIRECTION, registered=True),
    Fact("dependent.affine", _AFFINE, registered=True),
    Fact("friction.chosen", _CHOSEN),
    Fact("resultant.total", {"gain": ("words", "exponent"), "scaling": ("words",)}),
    Fact("gain.gain", {"scaling": ()}),
)
"""Every fact of a frame, in the order of the blocks that compute them."""
