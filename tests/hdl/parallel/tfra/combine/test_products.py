"""ProductBeats: beats in the cycles in which they come, each with its place, number and scalar."""

import random

import pytest

from tests.hdl.parallel.designs import label
from tests.hdl.parallel.tfra.combine.designs import DESIGNS, beats, transfers, words
from tfra.hdl.parallel.tfra.combine.products import ProductBeats
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.model.fixed.scalars import scalar_fraction
from tfra.sim.harness import play

NUMBER = FRAMES + 2
WATCHED = ["valid", "words", "place", "number", "scalar", "frame_done", "forced.ready"]


def _run(design, rng, mu, products):
    """Facts are offered all the time; products of a frame come when theirs were taken."""
    seen, taken = [], 0

    def cycles():
        nonlocal taken
        frames = iter(products)
        entering = iter(())
        begun = 0
        while True:
            x, y = mu[min(taken, len(mu) - 1)]
            payload = {"index": 0, "mu_ind": 0, "mu_x": x, "mu_y": y, "out_of_range": 0}
            inputs = next(entering, None)
            if inputs is None and begun == len(products):
                yield {}
                return
            if inputs is None and taken > begun:
                entering = transfers(design, rng, "products", next(frames))
                begun += 1
            yield (inputs or {}) | {"forced.valid": int(taken < len(mu)), "forced.payload": payload}
            taken += seen[-1]["forced.ready"]

    return play(ProductBeats(design), cycles(), WATCHED, seen)


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_beats_places_and_scalars(design):
    rng, limit = random.Random(4), 1 << (design.formats.operand - 1)
    mu = [(rng.randrange(-limit, limit), rng.randrange(-limit, limit)) for _ in range(NUMBER)]
    products = [[words(rng, design.widths.vector, 4) for _ in range(3 * design.quads)] for _ in range(NUMBER)]
    seen = _run(design, rng, mu, products)
    entered = [cycle for cycle, row in enumerate(seen) if row["valid"]]
    in_plane = design.quads * design.cycles_per_quad
    assert [seen[cycle]["words"] for cycle in entered] == [row for quads in products for row in beats(design, quads)]
    for count, cycle in enumerate(entered):
        frame, beat = divmod(count, 3 * in_plane)
        plane, number = divmod(beat, in_plane)
        assert (seen[cycle]["place"], seen[cycle]["number"]) == (frame % FRAMES, number)
        assert seen[cycle + 1]["scalar"] == (*mu[frame], -1 << scalar_fraction(design))[plane]
        assert seen[cycle + 1]["frame_done"] == (beat == 3 * in_plane - 1)
    assert sum(row["frame_done"] for row in seen) == NUMBER
