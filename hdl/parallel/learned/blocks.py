"""Every block of the core."""

from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.parallel.core.core import CoreBlocks
from tfra.hdl.parallel.learned.activation import Activation
from tfra.hdl.parallel.learned.angle import Angle
from tfra.hdl.parallel.learned.field import Field
from tfra.hdl.parallel.learned.forces import Forces
from tfra.hdl.parallel.learned.friction import Friction
from tfra.hdl.parallel.learned.plan import plan
from tfra.hdl.parallel.learned.resultant import Resultant
from tfra.hdl.parallel.learned.share import Share
from tfra.hdl.parallel.learned.total import Total
from tfra.hdl.parallel.learned.words import Words
from tfra.hdl.parallel.matvec.unit import MatVec
from tfra.hdl.parallel.normaliser import Normaliser
from tfra.model.fixed.learned.design import LearnedDesign


class Blocks(CoreBlocks):
    """The blocks in dataflow order; field, share and forces if there are forces at the taxels."""

    def __init__(self, design: LearnedDesign) -> None:
        self.normaliser = Normaliser(design)
        self.fold = Butterfly(design.widths.stress)
        self.matvec = MatVec(design, plan(design))
        self.activation = Activation(design)
        self.total = Total(design)
        self.resultant = Resultant(design)
        self.angle = Angle(design)
        self.friction = Friction(design)
        if design.taxel_forces:
            self.field = Field(design)
            self.share = Share(design)
            self.forces = Forces(design)
        self.words = Words(design)
