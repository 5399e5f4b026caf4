"""Streams between the blocks of the learned estimator that a simulation may watch, in dataflow order."""

from amaranth import signed
from amaranth.lib import data

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.lib.arithmetic import quad
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.learned.payloads import angle, friction, share, taxel_quad
from tfra.hdl.parallel.learned.plan import UNITS, mirror_bits
from tfra.hdl.parallel.learned.total import QUADS
from tfra.hdl.parallel.probes import probe_of
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.pipeline import Stage

_PLACES = (0, 1, 2, 3)
"""The words of a quad."""


def probes(design: LearnedDesign) -> tuple[Probe, ...]:
    """One for each :class:`Stage` but the last, whose words leave at the result port."""
    q, vector = design.quads, payloads.vector_quad(design)
    operators = [op for name in design.products for op in design.stacks[name].operators]
    units = sum(op.quads for op in operators if op.name in UNITS)
    words = data.ArrayLayout(signed(design.widths.division), 3)
    always = (
        probe_of(Stage.NORMALISER, "quads", payloads.stress_quad(design), _PLACES, q),
        probe_of(Stage.MATVEC, "result.words", vector, _PLACES, sum(op.quads for op in operators)),
        probe_of(Stage.ACTIVATION, "units.words", quad(mirror_bits(design) + 2), _PLACES, units),
        probe_of(Stage.TOTAL, "total", vector, _PLACES, QUADS),
        probe_of(Stage.RESULTANT, "force.words", words, (0, 1, 2), 1),
        probe_of(Stage.ANGLE, "angle", angle(design), ("phi",), 1),
        probe_of(Stage.FRICTION, "friction", friction(design), ("mu", "mu_x", "mu_y"), 1),
    )
    if not design.taxel_forces:
        return always
    return (
        *always,
        probe_of(Stage.FIELD, "p", taxel_quad(design), _PLACES, q),
        probe_of(Stage.SHARE, "share", share(design), ("mantissa",), 3),
    )
