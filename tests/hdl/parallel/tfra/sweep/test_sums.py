"""Sums of all candidates equal the sums of terms, each made by itself; crossings equal exact division."""

from fractions import Fraction
from itertools import product
from math import floor

import numpy as np
import pytest
from amaranth import ResetInserter, Signal
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.parallel.designs import make, simulate
from tfra.hdl.parallel.tfra.sweep.crossing import Crossing, crossing_latency
from tfra.hdl.parallel.tfra.sweep.sums import Sums, first_row, slope_bits, sums_wait
from tfra.model.fixed.numbers import signed_bits


def design_of(steps, words=1):
    return make(4, 5, steps=steps, words=words)


def crossing(first, step, steps):
    """``(place, size, excess)``, or None: the definition, in exact fractions."""
    if step == 0 or (first < 0) == (step < 0):
        return None
    root = Fraction(-first, step)
    place = floor(root) + 1 if step < 0 else -floor(-root)
    return (place, abs(step), abs(first + place * step)) if place <= steps else None


def found_crossings(design, bits, terms):
    """What the divider makes of terms, one a cycle."""
    dut, found = Crossing(design, bits), []

    async def drive(ctx):
        for cycle in range(len(terms) + crossing_latency(design)):
            first, step = terms[cycle] if cycle < len(terms) else (0, 0)
            ctx.set(dut.first, first)
            ctx.set(dut.rises, step >= 0)
            ctx.set(dut.i_size, abs(step))
            ctx.set(dut.i_valid, cycle < len(terms))
            if cycle >= crossing_latency(design):
                before, *words = (ctx.get(word) for word in (dut.before, dut.size, dut.excess))
                found.append((before + 1, *words) if ctx.get(dut.valid) else None)
            await ctx.tick()

    simulate(dut, drive)
    return found


@pytest.mark.parametrize("steps", [1, 2, 3, 7, 8, 100])
def test_crossings_at_every_place(steps):
    """Terms that vanish at a candidate, just before it and just behind it, rising and falling; and beyond both ends."""
    sizes, terms = (1, 2, 3, 1000), []
    for size in sizes:
        for place in range(-1, steps + 3):
            for off in (-1, 0, 1):
                terms += [(-size * place + off, size), (size * place + off, -size)]
    terms += [(5, 0), (-5, 0), (0, 0)]
    found = found_crossings(design_of(steps), 24, terms)
    assert found == [crossing(first, step, steps) for first, step in terms]


@settings(max_examples=15)
@given(st.data())
def test_any_crossing(data):
    steps, bits = data.draw(st.integers(1, 200)), data.draw(st.integers(4, 60))
    design, top = design_of(steps), (1 << (bits - 1)) - 1
    largest = (1 << (design.widths.vector - 1)) - 1
    term = st.tuples(st.integers(-top - 1, top), st.integers(-largest, largest) | st.integers(-9, 9))
    terms = data.draw(st.lists(term, min_size=1, max_size=40))
    assert found_crossings(design, bits, terms) == [crossing(*t, steps) for t in terms]


def found_sums(design, bits, frames):
    """Sums of frames of ``(first, step)``, back to back; and the cycles of the first ones behind the end marks."""
    dut = Sums(design, bits, bits + 10)
    found, waits, wait = [], [], sums_wait(design)

    async def drive(ctx):
        for _ in range(wait):  # the memory is being cleared
            await ctx.tick()
        ended = 0
        for terms in [*frames, []]:
            for cycle in range(len(terms) + wait - 1):
                first, step = terms[cycle] if cycle < len(terms) else (0, 0)
                ctx.set(dut.first, first)
                ctx.set(dut.step, step)
                ctx.set(dut.size, abs(step))
                ctx.set(dut.i_valid, cycle < len(terms))
                ctx.set(dut.ended, bool(terms) and cycle == len(terms))
                ended = 0 if cycle == len(terms) else ended + 1
                valid = ctx.get(dut.valid)
                if valid and len(found) % design.candidates == 0:
                    waits.append(ended)
                found.extend(ctx.get(word) for way, word in enumerate(dut.sums) if valid >> way & 1)
                await ctx.tick()

    simulate(dut, drive)
    return np.reshape(found, (-1, design.candidates)).tolist(), waits


def sums(design, terms):
    return [sum(max(0, first + k * step) for first, step in terms) for k in range(design.candidates)]


@pytest.mark.parametrize("words", [1, 4])
@pytest.mark.parametrize("steps", [1, 2, 3, 7, 100])
def test_sums_of_frames_back_to_back(steps, words):
    """Places met again 1, 2, 3, 4 and more terms later, in every order; nothing is left of the frame before."""
    design, rng = design_of(steps, words), np.random.default_rng(steps)
    frames = [[(-3 * k, 3) for k in places] for places in ([1] * 6, [1, 2] * 4, [1, 2, 3] * 3, [1, 2, 3, 4] * 3)]
    frames += [[(int(a), int(b)) for a, b in rng.integers(-9, 10, (20, 2))] for _ in range(8)]
    found, waits = found_sums(design, 20, frames)
    assert found == [sums(design, terms) for terms in frames]
    assert set(waits) == {first_row(design)}


@pytest.mark.parametrize("words", [1, 4])
def test_crossings_of_one_place_at_every_distance(words):
    """The accumulator takes the latest of several sums from a register, whatever comes between."""
    design, frames, gaps = design_of(3, words), [], range(1, 7)
    for first, second, other in product(gaps, gaps, (0, 2, 3)):
        places = [1, *[other] * (first - 1), 1, *[other] * (second - 1), 1]
        frames.append([(-size * place, size * (place > 0)) for size, place in enumerate(places, 1)])
    assert found_sums(design, 20, frames)[0] == [sums(design, terms) for terms in frames]


@pytest.mark.parametrize("words", [1, 4])
@pytest.mark.parametrize("steps", [1, 3, 5, 7, 12])
def test_a_reset_of_one_cycle_stops_crossings(steps, words):
    """None that was on its way comes behind the reset, when the memory is, or has been, cleared."""
    design, reset = design_of(steps, words), Signal()
    dut, found = Sums(design, 20, 32), []
    terms = [(-3 * (k % steps + 1) + 1, 3) for k in range(12)]

    async def drive(ctx):
        for cycle in range(-30, sums_wait(design) + len(terms) + first_row(design) + steps + 2):
            ctx.set(reset, cycle == 0)
            term = cycle - sums_wait(design) - 1
            first, step = terms[term % len(terms)]
            ctx.set(dut.first, first)
            ctx.set(dut.step, step)
            ctx.set(dut.size, step)
            ctx.set(dut.i_valid, cycle <= 0 or 0 <= term < len(terms))
            ctx.set(dut.ended, term == len(terms))
            if cycle > 0:
                found.extend(ctx.get(word) for way, word in enumerate(dut.sums) if ctx.get(dut.valid) >> way & 1)
            await ctx.tick()

    simulate(ResetInserter(reset)(dut), drive)
    assert found == sums(design, terms)


@pytest.mark.parametrize("words", [1, 4])
def test_the_longest_steps_of_all_taxels(words):
    """They fill slope and entries to the last bit: words that were shorter by one would lose it."""
    design = design_of(3, words)
    m, largest = design.sensor.taxels, (1 << (design.widths.vector - 1)) - 1
    assert (m * largest).bit_length() == slope_bits(design)
    frames = [
        [(0, largest)] * m,  # the slope to begin with
        [(-largest, largest)] * m,  # one entry
        [(-largest - 1, largest)] * m,  # with excesses
        [(m * largest, -largest)] * m,  # falling for ever
    ]
    bits = signed_bits(m * largest)
    assert found_sums(design, bits, frames)[0] == [sums(design, terms) for terms in frames]


@settings(max_examples=10)
@given(st.data())
def test_any_sums(data):
    design = design_of(data.draw(st.integers(1, 40)), data.draw(st.sampled_from([1, 4])))
    scale = data.draw(st.sampled_from([1, 3, 1000, 1 << 20]))
    number = st.integers(-4, 4).map(lambda n: n * scale) | st.integers(-8 * scale, 8 * scale)
    frames = data.draw(st.lists(st.lists(st.tuples(number, number), min_size=1, max_size=20), min_size=1, max_size=4))
    assert found_sums(design, 40, frames)[0] == [sums(design, terms) for terms in frames]
