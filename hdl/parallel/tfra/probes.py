"""Streams between blocks that a simulation may watch, in dataflow order."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Shape, Signal, signed, unsigned
from amaranth.lib import data

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.parallel import payloads
from tfra.model.fixed.cordic import iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.stages import Stage

_PLACES = (0, 1, 2, 3)
"""The words of a quad."""


def probes(design: Design) -> tuple[Probe, ...]:
    """Every probe of the core of ``design``: one for each :class:`Stage` but the last, whose words leave at the result
    port."""
    q, m, vector = design.quads, design.sensor.taxels, payloads.vector_quad(design)
    products = sum(design.stacks[name].quads for name in design.products)
    total = data.ArrayLayout(signed(design.widths.division), 3)
    return (
        _probe(Stage.NORMALISER, "quads", payloads.stress_quad(design), _PLACES, q),
        _probe(Stage.CENTROIDS, "direction", payloads.direction(design), ("cos", "sin"), 1),
        _probe(Stage.MATVEC, "result.words", vector, _PLACES, products),
        _probe(Stage.WEIGHTS, "n", vector, _PLACES, q),
        _probe(Stage.DEPENDENT, "affine", payloads.affine(design), ("alpha", "beta"), 1),
        _probe(Stage.COMBINE, "vector.words", vector, _PLACES, 3 * q),
        _probe(Stage.SWEEP, "index", payloads.sweep_index(design), (), 1),
        _probe(Stage.FRICTION, "chosen", payloads.chosen(design), ("mu_ind", "mu_x", "mu_y"), 1),
        _probe(Stage.RESULTANT, "total.words", total, (0, 1, 2), 1),
        _probe(Stage.GAIN, "gain", payloads.gain(design), ("mantissa", "mu"), 1),
        _probe(Stage.FORCES, "taxel", signed(design.widths.force), (), 3 * m),
        _probe(Stage.ANGLE, "phi", unsigned(iterations(design)), (), 1),
    )


def _probe(stage: Stage, port: str, shape: Any, keys: tuple[int | str, ...], transfers: int) -> Probe:
    members = [shape[key].shape for key in keys] if keys else [shape]
    words = tuple((Shape.cast(member).width, Shape.cast(member).signed) for member in members)
    return Probe(stage, port, keys, words, transfers)


def add_probe(m: Module, probe: Probe, block: Any) -> None:
    """Name the stream of ``block`` that ``probe`` watches; nothing depends on it, so it costs no hardware."""
    transfer = Signal(name=f"probe_{probe.stage}")
    words = Signal(sum(bits for bits, _ in probe.words), name=f"probe_{probe.stage}_words")
    name, _, member = probe.port.partition(".")
    port = getattr(block, name)
    payload = port.payload[member] if member else port.payload
    members = [payload[key] for key in probe.keys] if probe.keys else [payload]
    m.d.comb += [transfer.eq(port.valid & port.ready), words.eq(Cat(members))]
