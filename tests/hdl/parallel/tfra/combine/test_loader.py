"""Loaders: each beat of n, d0 = b + g, d1 and d2 goes where its frame has its place."""

import random

import pytest

from tests.hdl.parallel.designs import label
from tests.hdl.parallel.tfra.combine.designs import DESIGNS, beats, transfers, words
from tfra.hdl.parallel.tfra.combine.loader import ResidualLoader, WeightLoader
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE
from tfra.sim.harness import play

NUMBER = FRAMES + 2
"""Frames of a run, so that places come round."""


def _quads(rng, bits, count):
    return [words(rng, bits, 4) for _ in range(count)]


def _written(seen, port):
    """Cycle, place, vector, number and words of what is written."""
    return [
        (cycle, row[f"{port}.place"], row[f"{port}.vector"], row[f"{port}.number"], row[f"{port}.words"])
        for cycle, row in enumerate(seen)
        if row[f"{port}.valid"]
    ]


def _ports(*names):
    return [f"{port}.{member}" for port in names for member in ("valid", "place", "vector", "number", "words")]


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_weights(design):
    rng = random.Random(1)
    frames = [_quads(rng, design.widths.vector, design.quads) for _ in range(NUMBER)]
    cycles = [cycle for quads in frames for cycle in transfers(design, rng, "n", quads)] + [{}]
    found = _written(play(WeightLoader(design), cycles, _ports("write")), "write")
    assert [row[1:] for row in found] == [
        (frame % FRAMES, 0, number, row)
        for frame, quads in enumerate(frames)
        for number, row in enumerate(beats(design, quads))
    ]
    starts = [cycle for cycle, inputs in enumerate(cycles) if inputs.get("n.valid")]
    assert [row[0] for row in found] == [s + beat + 1 for s in starts for beat in range(design.cycles_per_quad)]


def _residuals(design, rng):
    """Codes of b, and g, d1, d2 on the vector grid; sums of b and g fit a vector."""
    bits, quads = design.widths.vector, design.quads
    code = min(design.adc.bits + 2, bits - 2 - design.formats.vector_fraction)
    return [(_quads(rng, code, quads), *(_quads(rng, bits - 2, quads) for _ in range(3))) for _ in range(NUMBER)]


def _residual_cycles(design, rng, frames):
    """As in the core: b of a frame before its g, also that of the next frame."""
    cycles = [*transfers(design, rng, "b", frames[0][0])]
    for number, (_, *vectors) in enumerate(frames):
        if number + 1 < len(frames):
            cycles += transfers(design, rng, "b", frames[number + 1][0])
        for quads in vectors:
            cycles += transfers(design, rng, "residual", quads)
    return cycles + [{}] * MEASURE


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_residuals(design):
    rng = random.Random(2)
    frames = _residuals(design, rng)
    cycles = _residual_cycles(design, rng, frames)
    seen = play(ResidualLoader(design), cycles, ["stored", *_ports("x", "z")])
    x, z = [], []
    for frame, (b, g, d1, d2) in enumerate(frames):
        scale = 1 << design.formats.vector_fraction
        d0 = [[code * scale + word for code, word in zip(*pair, strict=True)] for pair in zip(b, g, strict=True)]
        for vector, quads in enumerate((d0, d1, d2)):
            z += [(frame % FRAMES, vector, number, row) for number, row in enumerate(beats(design, quads))]
        for vector, quads in enumerate((d1, d2)):
            x += [(frame % FRAMES, vector, number, row) for number, row in enumerate(beats(design, quads))]
    assert [row[1:] for row in _written(seen, "x")] == x
    assert [row[1:] for row in _written(seen, "z")] == z


def test_a_frame_is_announced_when_its_headroom_can_be_read_by_its_first_beat():
    """The arbiter's choice and its first beat's way to the store take two cycles from there."""
    design, rng = DESIGNS[-1], random.Random(3)
    frames = _residuals(design, rng)
    seen = play(ResidualLoader(design), _residual_cycles(design, rng, frames), ["stored", *_ports("x", "z")])
    last = design.quads * design.cycles_per_quad - 1
    ends = [row[0] for row in _written(seen, "x") if row[2] == 1 and row[3] == last]
    stored = [cycle for cycle, row in enumerate(seen) if row["stored"]]
    assert stored == [cycle + MEASURE - 2 for cycle in ends]
