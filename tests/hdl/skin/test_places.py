"""Places: centroids, corners and marks of the model for any region."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.skin.skins import skin_of, small_window
from tfra.hdl.skin.places import Places
from tfra.model.skin.finding import MARK_SHIFT, Mark
from tfra.model.skin.regions import spans
from tfra.model.skin.windows import corners, places
from tfra.sim.harness import flowing, random_stalls, run

NONE = {"first": 0, "last": 0, "total": 0}


def regions_of(bits, touching):
    """Records of regions as the block gets them."""
    named = dict(zip(("rows", "columns"), spans(bits), strict=True))
    return [
        {
            "taxels": int(bits[number].sum()),
            "touching": int(touching[number]),
            **{
                name: {key: int(getattr(span, key)[number]) for key in ("first", "last", "total")}
                for name, span in named.items()
            },
        }
        for number in range(len(bits))
    ]


def expected(bits, touching, window):
    """Contacts by the model's functions."""
    taxels, found = bits.sum(axis=(1, 2)), []
    edge = large = np.zeros(len(bits), dtype=np.bool_)
    for span, size, whole in zip(spans(bits), window, bits.shape[1:], strict=True):
        place = places(span.total, taxels)
        corner = corners(place, size)
        found += [place, corner]
        edge = edge | (corner < 0) | (corner + size > whole)
        large = large | (span.first < corner) | (span.last >= corner + size)
    marks = (Mark.EDGE * edge | Mark.LARGE * large | Mark.TOUCHING * touching) >> MARK_SHIFT
    names = ("row", "top", "column", "left", "taxels", "marks")
    return [dict(zip(names, map(int, each), strict=True)) for each in zip(*found, taxels, marks, strict=True)]


@settings(max_examples=10)
@given(
    shape=st.tuples(st.integers(5, 9), st.integers(5, 12)),
    window=st.tuples(st.integers(2, 5), st.integers(2, 5)),
    seed=st.integers(0, 999),
    stalls=st.sampled_from((flowing, random_stalls)),
)
def test_contacts_are_those_of_the_model(shape, window, seed, stalls):
    rng = np.random.default_rng(seed)
    bits = rng.random((8, *shape)) < rng.uniform(0, 1, (8, 1, 1)) ** 2
    bits[np.arange(8), rng.integers(0, shape[0], 8), rng.integers(0, shape[1], 8)] = True
    bits[0] = True
    touching = rng.integers(0, 2, 8)
    block = Places(skin_of(*shape, small_window(*window)))
    given_regions = regions_of(bits, touching)
    seen = run(block, {"region": given_regions}, {"contact": 8}, stall_out=stalls)
    assert [dict(sorted(each.items())) for each in seen.values["contact"]] == [
        dict(sorted(each.items())) for each in expected(bits, touching, window)
    ]


@pytest.mark.parametrize("shape", [(5, 6), (12, 20)])
def test_a_region_without_taxels_is_zero_and_the_stated_interval(shape):
    block = Places(skin_of(*shape))
    full = regions_of(np.ones((1, *shape), dtype=np.bool_), [1])
    seen = run(block, {"region": [*full, {"taxels": 0, "touching": 1, "rows": NONE, "columns": NONE}]}, {"contact": 2})
    empty = seen.values["contact"][1]
    assert [empty[name] for name in ("row", "column", "taxels", "marks")] == [0] * 4
    assert np.diff(seen.cycles["contact"]) == [block.interval]
