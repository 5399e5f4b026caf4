"""Streams between blocks that a simulation may watch, in dataflow order."""

from amaranth import signed, unsigned
from amaranth.lib import data

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.probes import probe_of
from tfra.model.fixed.cordic import iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.pipeline import Stage

_PLACES = (0, 1, 2, 3)
"""The words of a quad."""


def probes(design: Design) -> tuple[Probe, ...]:
    """Every probe of the core of ``design``: one for each :class:`Stage` but the last, whose words leave at the result
    port."""
    q, m, vector = design.quads, design.sensor.taxels, payloads.vector_quad(design)
    products = sum(design.stacks[name].quads for name in design.products)
    total = data.ArrayLayout(signed(design.widths.division), 3)
    return (
        probe_of(Stage.NORMALISER, "quads", payloads.stress_quad(design), _PLACES, q),
        probe_of(Stage.CENTROIDS, "direction", payloads.direction(design), ("cos", "sin"), 1),
        probe_of(Stage.MATVEC, "result.words", vector, _PLACES, products),
        probe_of(Stage.WEIGHTS, "n", vector, _PLACES, q),
        probe_of(Stage.DEPENDENT, "affine", payloads.affine(design), ("alpha", "beta"), 1),
        probe_of(Stage.COMBINE, "vector.words", vector, _PLACES, 3 * q),
        probe_of(Stage.SWEEP, "index", payloads.sweep_index(design), (), 1),
        probe_of(Stage.FRICTION, "chosen", payloads.chosen(design), ("mu_ind", "mu_x", "mu_y"), 1),
        probe_of(Stage.RESULTANT, "total.words", total, (0, 1, 2), 1),
        probe_of(Stage.GAIN, "gain", payloads.gain(design), ("mantissa", "mu"), 1),
        probe_of(Stage.FORCES, "taxel", signed(design.widths.force), (), 3 * m),
        probe_of(Stage.ANGLE, "phi", unsigned(iterations(design)), (), 1),
    )
