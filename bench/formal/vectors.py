"""The arbiter of the vector updates: who enters the pipeline in each cycle, and with what."""

from types import SimpleNamespace
from typing import Any

from amaranth import Array, Mux, Signal, Value

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from bench.formal.streams import taken
from tfra.hdl.parallel.tfra.combine.arbiter import Arbiter
from tfra.hdl.parallel.tfra.combine.store import FRAMES, Job
from tfra.model.choices import Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

DESIGN = TfraDesign(SensorArray(4, 2, 4e-3, 4e-3, 3e-3), architecture=Architecture(4, 2))
LAST = DESIGN.quads * DESIGN.cycles_per_quad - 1
"""Number of a vector's last beat."""

PRODUCT, BEATS = "a beat of products enters when it comes", "the beats of a vector enter once each, in order"
ONE, ON = "of one vector at a time", "without a pause but for products"
TURNS, PLACES = "e1 follows e0", "frames take their turns"
FACTS, STORED = "a vector has the facts of its frame", "no vector begins before its frame is stored"
TOKEN = "a bank is taken for each vector"


def arbiter(bench: Bench, Block: Any) -> None:
    """Beats of products in any cycle; facts stay until they are taken; no more frames wait than there are places."""
    block = Block(DESIGN)
    inner = bench.place(block)
    m, tag = bench.m, block.tag
    for port in (block.affine, block.direction, block.chosen, block.bank_token):
        waits = bench.past(port.valid & ~port.ready)
        bench.assume(~waits | (port.valid & (Value.cast(port.p) == bench.past(Value.cast(port.p)))))
    vector = block.valid & ~block.product_valid
    number, first, owed, second = Signal(range(LAST + 1)), Signal(tag.shape()), Signal(), Signal()
    ends, is_d = vector & (number == LAST), tag.job == Job.D
    with m.If(vector):
        m.d.sync += number.eq(Mux(number == LAST, 0, number + 1))
        m.d.sync += first.eq(tag)
    with m.If(ends):
        m.d.sync += owed.eq(0)
        m.d.sync += second.eq(second ^ ~is_d)
    with m.Elif(taken(block.bank_token)):
        m.d.sync += owed.eq(1)
    frames = [
        _waiting(bench, enter, bench.past(ends & (tag.job == job)))
        for enter, job in ((block.residual_stored, Job.E1), (block.e1_stored, Job.D))
    ]
    at = SimpleNamespace(vector=vector, number=number, first=first, owed=owed, second=second, frames=frames)
    _claims(bench, block, at)
    _lemmas(bench, block, inner, at)


def _waiting(bench: Bench, enter: Any, leave: Any) -> Any:
    """Frames that wait, and the place of the oldest."""
    count, oldest = Signal(range(FRAMES + 1)), Signal(range(FRAMES))
    bench.assume(~enter | leave | (count != FRAMES))
    bench.m.d.sync += count.eq(count + enter - leave)
    bench.m.d.sync += oldest.eq(oldest + leave)
    return SimpleNamespace(count=count, oldest=oldest, leave=leave)


def _facts(block: Any, tag: Any) -> Value:
    """Those of a vector with ``tag`` are there, and are in it."""
    alpha, beta = block.affine.p.alpha, block.affine.p.beta
    of_e = block.affine.valid & block.direction.valid & (tag.swap == block.direction.p.sweep_y)
    is_e = of_e & (tag.scalar == Mux(tag.job == Job.E0, alpha, beta))
    return Mux(tag.job == Job.D, block.chosen.valid & (tag.scalar == block.chosen.p.mu_ind), is_e)


def _claims(bench: Bench, block: Any, at: Any) -> None:
    tag, (residuals, candidates) = block.tag, at.frames
    is_d = tag.job == Job.D
    product = (tag.place == block.product_place) & (tag.number == block.product_number)
    bench.claim(PRODUCT, block.product_valid, block.valid & (tag.job == Job.FORCE) & product)
    bench.claim(BEATS, at.vector, (tag.number == at.number) & (tag.job != Job.FORCE))
    same = (tag.job == at.first.job) & (tag.place == at.first.place) & (tag.scalar == at.first.scalar)
    bench.claim(ONE, at.vector & (at.number != 0), same)
    bench.claim(ON, (at.number != 0) & ~block.product_valid, block.valid)
    bench.claim(TURNS, at.vector & ~is_d, (tag.job == Job.E1) == at.second)
    bench.claim(PLACES, at.vector, tag.place == Mux(is_d, candidates.oldest, residuals.oldest))
    bench.claim(FACTS, at.vector, _facts(block, tag))
    bench.claim(STORED, at.vector, Mux(is_d, candidates.count, residuals.count) != 0)
    bench.claim(TOKEN, at.vector, at.owed | taken(block.bank_token))
    bench.claim(f"{TOKEN}, one alone", taken(block.bank_token), ~at.owed)


def _lemmas(bench: Bench, block: Any, inner: Any, at: Any) -> None:
    busy, beat = inner["busy"], block.tag.shape()(inner["beat"])
    residuals, candidates = at.frames
    is_d = beat.job == Job.D
    bench.lemma(busy | (at.number == 0))
    bench.lemma(
        ~busy | ((beat.number == at.number) & (inner["final"] == (at.number == LAST)) & (beat.job != Job.FORCE))
    )
    same = (beat.job == at.first.job) & (beat.place == at.first.place) & (beat.scalar == at.first.scalar)
    bench.lemma((at.number == 0) | same)
    bench.lemma(inner["second"] == (at.second ^ (busy & ~is_d)))
    bench.lemma(~busy | is_d | ((beat.job == Job.E1) == at.second))
    bench.lemma(~busy | (beat.place == Mux(is_d, candidates.oldest, residuals.oldest)))
    bench.lemma(~busy | _facts(block, beat))
    bench.lemma(~busy | (Mux(is_d, candidates.count, residuals.count) != 0))
    bench.lemma(busy == (at.owed | inner["take_token"]))
    bench.lemma(~inner["take_token"] | (block.bank_token.valid & ~at.owed))
    for name, waiting, unary in (("residual", residuals, "taken"), ("candidate", candidates, "taken (2)")):
        bench.lemma(inner[f"{name}_leaves"] == waiting.leave)
        bench.lemma(~waiting.leave | (~busy & (waiting.count != 0)))
        bench.lemma(inner[unary] == Array((1 << n) - 1 for n in range(FRAMES + 1))[waiting.count])
        bench.lemma((waiting.count <= FRAMES) & (inner[f"oldest_{name}"] == waiting.oldest))
        bench.lemma(inner[f"oldest_{name}_last"] == (waiting.oldest == FRAMES - 1))
    bench.lemma(~inner["candidate_facts"] | (block.affine.valid & block.direction.valid))
    bench.lemma(~inner["update_facts"] | block.chosen.valid)


PROOFS = [
    Proof(
        Arbiter,
        arbiter,
        {
            PRODUCT: ("self.tag.job.eq(Job.FORCE)", "self.tag.job.eq(Job.D)"),
            BEATS: ("step.eq(busy & ~self.product_valid)", "step.eq(busy)"),
            ONE: ("with m.If(~busy & self.bank_token.valid)", "with m.If(self.bank_token.valid)"),
            ON: ("busy.eq(~final)", "busy.eq(~final & ~self.bank_token.valid)"),
            TURNS: ("second.eq(~second)", "second.eq(1)"),
            PLACES: ("beat.place.eq(candidate_place)", "beat.place.eq(residual_place)"),
            FACTS: ("Mux(second, self.affine.payload.beta", "Mux(~second, self.affine.payload.beta"),
            STORED: ("update_facts & candidates.some", "update_facts"),
            TOKEN: ("~busy & self.bank_token.valid & (begin_d", "~busy & self.bank_token.valid & ~(begin_d"),
            f"{TOKEN}, one alone": ("ready.eq(take_token)", "ready.eq(busy)"),
        },
        reach=18,
        size=f"vectors of {LAST + 1} beats",
    ),
]
