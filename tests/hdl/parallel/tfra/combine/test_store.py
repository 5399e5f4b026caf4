"""Store against a dictionary: words, and headroom from the lengths of integers."""

import random

import pytest

from tests.hdl.parallel.designs import label
from tests.hdl.parallel.tfra.combine.designs import DESIGNS, beats, words
from tfra.hdl.lib.pipeline import READ
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE, Store
from tfra.sim.harness import play


def _vectors(design, rng, count):
    """``count`` places of vectors ``(Q, 4)``; parities have sizes of their own."""

    def vector():
        parities = [words(rng, rng.randrange(1, design.widths.vector), design.quads) for _ in range(4)]
        return [list(quad) for quad in zip(*parities, strict=True)]

    return {(place, number): vector() for place in range(FRAMES) for number in range(count)}


def _headroom(design, vector):
    """Bits below the sign that no word of a parity needs."""
    return [
        design.widths.vector - 1 - max(word.bit_length() if word >= 0 else (~word).bit_length() for word in parity)
        for parity in zip(*vector, strict=True)
    ]


def _write(design, rng, key, vector):
    place, number = key
    for beat, row in enumerate(beats(design, vector)):
        yield from ({} for _ in range(rng.randrange(2)))
        address = {"write.place": place, "write.vector": number, "write.number": beat}
        yield {"write.valid": 1, "write.words": row, **address}


def _read(key, beat):
    return {"read.place": key[0], "read.vector": key[1], "read.number": beat}


@pytest.mark.parametrize("design", DESIGNS, ids=label)
@pytest.mark.parametrize("count", [1, 2, 3])
def test_finds_what_was_written(design, count):
    rng = random.Random(count)
    vectors, cycles, size = _vectors(design, rng, count), [], design.architecture.vector_words
    for key, vector in vectors.items():
        cycles += _write(design, rng, key, vector)
    cycles += [{}] * MEASURE
    reads = [(key, beat) for key in vectors for beat in range(design.quads * design.cycles_per_quad)]
    rng.shuffle(reads)
    begin = len(cycles)
    cycles += [_read(*read) for read in reads] + [{}] * READ
    seen = play(Store(design, count, headroom=True), cycles, ["beat", "headroom"])[begin + READ :]
    for (key, beat), row in zip(reads, seen, strict=True):
        assert row["beat"] == beats(design, vectors[key])[beat]
        assert row["headroom"] == beats(design, [_headroom(design, vectors[key])])[beat % design.cycles_per_quad]
    assert len(seen[0]["beat"]) == size


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_beats_and_headroom_can_be_read_as_soon_as_told(design):
    rng, key = random.Random(5), (2, 0)
    vector = next(iter(_vectors(design, rng, 1).values()))
    for quad in vector:
        quad[3] = 1  # much headroom, where the memory holds none
    written = list(_write(design, rng, key, vector))
    last = design.quads * design.cycles_per_quad - 1
    cycles = written + [_read(key, last)] * (MEASURE + READ)
    seen = play(Store(design, headroom=True), cycles, ["beat", "headroom"])[len(written) - 1 :]
    assert seen[1 + READ]["beat"] == beats(design, vector)[-1]
    found = beats(design, [_headroom(design, vector)])[-1]
    assert seen[MEASURE + READ - 1]["headroom"] != found
    assert seen[MEASURE + READ]["headroom"] == found
