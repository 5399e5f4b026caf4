"""Every block of the core, and the products that it multiplies."""

from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.parallel.angle import Angle
from tfra.hdl.parallel.core.core import CoreBlocks
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
