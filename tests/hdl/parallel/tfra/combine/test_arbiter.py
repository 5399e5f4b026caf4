"""Arbiter in a closed loop with frames that come, leave and wait at random: nothing is begun early, twice or late."""

import random
from collections import deque

import pytest

from tests.hdl.parallel.designs import label, make
from tests.hdl.parallel.tfra.combine.designs import DESIGNS
from tfra.hdl.parallel.tfra.combine.arbiter import Arbiter
from tfra.hdl.parallel.tfra.combine.stages import Job
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.sim.harness import play

NUMBER = 2 * FRAMES
WATCHED = ["valid", "tag", "bank_token.ready", "direction.ready", "affine.ready", "chosen.ready"]
AFFINE = {"vanishing": 0, "sums": [0] * 9, "significant": 0}
DIRECTION = {"cos": 0, "sin": 0, "negative": 0, "vanishing": 0}
CHOSEN = {"index": 0, "mu_x": 0, "mu_y": 0, "out_of_range": 0}


class Frames:
    """What the neighbours of the arbiter do: facts by frame, and when each of them is there."""

    def __init__(self, design, seed, *, busy=0.3):
        self.rng, self.design, self.busy = random.Random(seed), design, busy
        limit = 1 << (design.formats.operand - 1)
        self.alpha, self.beta, self.mu = ([self.rng.randrange(-limit, limit) for _ in range(NUMBER)] for _ in range(3))
        self.sweep_y = [self.rng.randrange(2) for _ in range(NUMBER)]
        self.last = design.quads * design.cycles_per_quad - 1
        self.seen, self.inputs = [], []
        self.known = {"residual": [], "affine": [], "chosen": [], "e1": []}
        """Cycles in which something of each frame comes to be there."""
        self.offered = {"affine": {}, "chosen": {}}
        """First cycle of each frame's transfer, when those before it were taken."""
        self.vectors, self.products = [], []
        """Of each vector its first cycle, tags by cycle; of products the cycle, place and number."""

    def play(self, design):
        play(Arbiter(design), self._cycles(), WATCHED, self.seen)
        return self

    def _cycles(self):
        taken, pulses, d_done = {"affine": 0, "chosen": 0}, deque(), 0
        for cycle in range(60_000):
            if d_done == NUMBER:
                return
            inputs = self._enter(cycle, d_done, taken, pulses)
            self.inputs.append(inputs)
            yield inputs
            row = self.seen[-1]
            assert row["direction.ready"] == row["affine.ready"]
            for port in taken:
                assert not row[f"{port}.ready"] or inputs.get(f"{port}.valid"), "a fact is taken that is not there"
                taken[port] += row[f"{port}.ready"]
            done = self._entered(cycle, inputs, row)
            if done == Job.E1:
                pulses.append(cycle + 5)
            d_done += done == Job.D
        raise AssertionError("no end")

    def _enter(self, cycle, d_done, taken, pulses):
        """The inputs of a cycle."""
        rng, known, inputs = self.rng, self.known, {}
        if len(known["residual"]) < min(NUMBER, d_done + FRAMES) and rng.random() < 0.1:
            known["residual"].append(cycle)
            inputs["residual_stored"] = 1
        if pulses and pulses[0] == cycle:
            pulses.popleft()
            known["e1"].append(cycle)
            inputs["e1_stored"] = 1
        if len(known["affine"]) < len(known["residual"]) and rng.random() < 0.1:
            known["affine"].append(cycle)
        if len(known["chosen"]) < len(known["e1"]) and rng.random() < 0.1:
            known["chosen"].append(cycle)
        if (frame := taken["affine"]) < len(known["affine"]):
            self.offered["affine"].setdefault(frame, cycle)
            inputs |= {"affine.valid": 1, "direction.valid": 1}
            inputs["affine.payload"] = AFFINE | {"alpha": self.alpha[frame], "beta": self.beta[frame]}
            inputs["direction.payload"] = DIRECTION | {"sweep_y": self.sweep_y[frame]}
        if (frame := taken["chosen"]) < len(known["chosen"]):
            self.offered["chosen"].setdefault(frame, cycle)
            inputs |= {"chosen.valid": 1, "chosen.payload": CHOSEN | {"mu_ind": self.mu[frame]}}
        # A token stays until it is taken; then it may be a while until the next.
        before = self.seen[-1]["bank_token.ready"] if self.seen else 1
        stays = self.inputs and self.inputs[-1].get("bank_token.valid") and not before
        inputs["bank_token.valid"] = int(stays or rng.random() < 0.5)
        if rng.random() < self.busy:
            self.products.append((cycle, rng.randrange(FRAMES), rng.randrange(self.last + 1)))
            inputs |= {"product_valid": 1, "product_place": self.products[-1][1]}
            inputs["product_number"] = self.products[-1][2]
        return inputs

    def _entered(self, cycle, inputs, row):
        """Job of the vector that ends in this cycle, if one does; vectors are not interleaved."""
        tag = row["tag"]
        if not row["valid"] or inputs.get("product_valid"):
            return None
        if tag["number"] == 0:
            self.vectors.append((cycle, []))
        self.vectors[-1][1].append((cycle, tag))
        assert [t["number"] for _, t in self.vectors[-1][1]] == list(range(tag["number"] + 1))
        return tag["job"] if tag["number"] == self.last else None


@pytest.fixture(
    scope="module",
    name="frames",
    params=[(design, seed) for design in DESIGNS[:3] for seed in (0, 1)],
    ids=lambda param: f"{label(param[0])}-{param[1]}",
)
def _frames(request):
    design, seed = request.param
    return Frames(design, seed).play(design)


def test_products_enter_in_the_cycle_in_which_they_come(frames):
    for cycle, place, number in frames.products:
        if cycle < len(frames.seen):
            row = frames.seen[cycle]
            assert row["valid"]
            assert (row["tag"]["job"], row["tag"]["place"], row["tag"]["number"]) == (Job.FORCE, place, number)


def test_each_vector_enters_once_with_its_facts_in_the_order_of_frames(frames):
    tags = [tag for _, ((_, tag), *_) in frames.vectors]
    found = {job: [t for t in tags if t["job"] == job] for job in (Job.E0, Job.E1, Job.D)}
    for job, scalars in ((Job.E0, frames.alpha), (Job.E1, frames.beta), (Job.D, frames.mu)):
        assert [tag["place"] for tag in found[job]] == [frame % FRAMES for frame in range(NUMBER)]
        assert [tag["scalar"] for tag in found[job]] == scalars
        if job != Job.D:
            assert [tag["swap"] for tag in found[job]] == frames.sweep_y
    for _, beats in frames.vectors:
        assert all(tag | {"number": 0} == beats[0][1] for _, tag in beats)


def test_no_beat_waits_but_for_products(frames):
    busy = {cycle for cycle, *_ in frames.products}
    for start, beats in frames.vectors:
        free = [cycle for cycle in range(start, beats[-1][0] + 1) if cycle not in busy]
        assert [cycle for cycle, _ in beats] == free


def test_vectors_begin_when_their_operands_and_a_token_are_there(frames):
    """The choice is made in the cycle before the first beat, or earlier if products come; a token goes with it."""
    begun = {job: 0 for job in (Job.E0, Job.E1, Job.D)}
    tokens = [cycle for cycle, row in enumerate(frames.seen) if row["bank_token.ready"]]
    assert len(tokens) == len(frames.vectors) == 3 * NUMBER
    for token, (start, ((_, tag), *_)) in zip(tokens, frames.vectors, strict=True):
        choice, job, frame = token - 1, tag["job"], begun[tag["job"]]
        begun[job] += 1
        assert choice < start
        assert frames.inputs[choice]["bank_token.valid"]
        stored, facts = ("e1", "chosen") if job == Job.D else ("residual", "affine")
        assert max(frames.known[stored][frame], frames.offered[facts][frame]) < choice
        d_waits = frames.offered["chosen"].get(begun[Job.D], choice) < choice
        assert job == Job.D or not d_waits, "d goes first"


@pytest.mark.parametrize("design", [make(4, 4), make(2, 2, words=1)], ids=label)
def test_begin_latency_and_pause(design):
    """With tokens and no products, from the last fact to the first beat, and from vector to vector."""
    beats = design.quads * design.cycles_per_quad
    facts = {"affine.valid": 1, "direction.valid": 1, "bank_token.valid": 1}
    cycles = [{"residual_stored": 1}, *[{"bank_token.valid": 1}] * 4, *[facts] * (2 * beats + 8)]
    seen = play(Arbiter(design), cycles, WATCHED)
    entered = [cycle for cycle, row in enumerate(seen) if row["valid"]]
    first = 5 + Arbiter.begin_latency
    second = first + beats + Arbiter.pause
    assert entered[: 2 * beats] == [*range(first, first + beats), *range(second, second + beats)]
