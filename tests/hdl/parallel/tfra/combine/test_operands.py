"""Multiplicand and Addend against dictionaries of what was written."""

import random

import pytest

from tests.hdl.parallel.designs import label
from tests.hdl.parallel.tfra.combine.designs import DESIGNS, words
from tfra.hdl.lib.pipeline import READ
from tfra.hdl.parallel.scale_add import Stage
from tfra.hdl.parallel.tfra.combine.operands import Addend, Multiplicand
from tfra.hdl.parallel.tfra.combine.stages import Job
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE
from tfra.sim.harness import play

READS = 150


def _fill(design, rng, port, vectors, headroom):
    """Cycles that write every beat of a store, and what is in it then, by place, vector and number.

    All words of a vector have the same length, so that its ``headroom`` needs no more than a look at one of them.
    """
    cycles, found = [], {}
    for place in range(FRAMES):
        for vector in range(vectors):
            length = rng.randrange(design.widths.vector)
            for number in range(design.quads * design.cycles_per_quad):
                row = [rng.choice([(1 << length) - 1, -1 << length]) for _ in range(design.architecture.vector_words)]
                address = {f"{port}.place": place, f"{port}.vector": vector, f"{port}.number": number}
                cycles.append({f"{port}.valid": 1, f"{port}.words": row} | address)
                found[place, vector, number] = row
            headroom[port, place, vector] = design.widths.vector - 1 - length
    return cycles, found


def _tags(design, rng):
    last = design.quads * design.cycles_per_quad
    return [
        {"job": rng.choice(list(Job)), "place": rng.randrange(FRAMES), "number": rng.randrange(last)}
        | {"swap": rng.randrange(2), "scalar": 0}
        for _ in range(READS)
    ]


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_multiplicand(design):
    rng, headroom, cycles, stored = random.Random(6), {}, [], {}
    for port, vectors in (("n", 1), ("residual", 2), ("e1", 1)):
        written, stored[port] = _fill(design, rng, port, vectors, headroom)
        cycles += written
    cycles += [{}] * MEASURE
    begin, tags = len(cycles), _tags(design, rng)
    cycles += [{} for _ in range(READS + Stage.X_CHOSEN + 1)]
    for beat, tag in enumerate(tags):
        cycles[begin + beat + Stage.X_ADDRESS] |= {"address": tag}
        cycles[begin + beat + Stage.X_ADDRESS + READ] |= {"job": int(tag["job"])}
    seen = play(Multiplicand(design), cycles, ["words", "headroom"])
    for beat, tag in enumerate(tags):
        # The sweep along y has d1 as d_dep, along x d2.
        d_dep = ("residual", 0 if tag["swap"] else 1)
        port, vector = {Job.E0: d_dep, Job.E1: d_dep, Job.D: ("e1", 0), Job.FORCE: ("n", 0)}[tag["job"]]
        found = seen[begin + beat + Stage.X_CHOSEN]
        assert found["words"] == stored[port][tag["place"], vector, tag["number"]]
        assert set(found["headroom"]) == {headroom[port, tag["place"], vector]}


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_addend(design):
    rng, cycles, stored = random.Random(7), [], {}
    for port, vectors in (("residual", 3), ("e0", 1)):
        written, stored[port] = _fill(design, rng, port, vectors, {})
        cycles += written
    begin, tags = len(cycles), _tags(design, rng)
    products = [words(rng, design.widths.vector, design.architecture.vector_words) for _ in tags]
    cycles += [{} for _ in range(READS + Stage.Z + 1)]
    for beat, tag in enumerate(tags):
        cycles[begin + beat + Stage.ENTRY] |= {"product": products[beat]}
        cycles[begin + beat + Stage.Z_ADDRESS] |= {"address": tag}
        cycles[begin + beat + Stage.Z_READ] |= {"job": int(tag["job"])}
    seen = play(Addend(design), cycles, ["words"])
    for beat, tag in enumerate(tags):
        d_ind = stored["residual"][tag["place"], 2 if tag["swap"] else 1, tag["number"]]
        expected = {
            Job.E0: stored["residual"][tag["place"], 0, tag["number"]],
            Job.E1: d_ind,
            Job.D: stored["e0"][tag["place"], 0, tag["number"]],
            Job.FORCE: products[beat],
        }
        assert seen[begin + beat + Stage.Z]["words"] == expected[tag["job"]]
