"""The framer: output frames of the facts and the result of every frame, and of no other."""

from types import SimpleNamespace
from typing import Any

from amaranth import Cat, Mux, Signal, Value

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from bench.formal.streams import RULE, Scoreboard, fifo_lemmas, stays, taken
from tfra.hdl.front_end.ports import FACTS
from tfra.hdl.ip.framer import FAULTS, FORMAT, FORMAT_PLACE, Framer, forces, frames
from tfra.model.choices import Architecture
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.skin.records import result_shape

DESIGN = TfraDesign(SensorArray(2, 2, 4e-3, 4e-3, 3e-3), architecture=Architecture(4))
WORDS, _ = result_shape(DESIGN)

FACTS_LEAVE = "the facts of a frame are kept until its result has left"
FIRST, SECOND = "a frame begins with its number", "then come its faults and the format"
EACH, NO_OTHER = "then every word of its result once", "and nothing else"
DROPPED, SOON = "a bad frame, and forces that are not wanted, are dropped", "a word is offered as soon as it comes"

_SEQUENCE, _FAULTS, _WORDS, _FRAME = range(4)
"""States of the framer, in the order in which its source names them."""


def framer(bench: Bench, Block: Any) -> None:
    """Results of the stated length, which stay until they are taken; facts and the setting at any time."""
    block = Block(DESIGN)
    inner = bench.place(block)
    result, o, m = block.result, block.o, bench.m
    number, sent, frame = Signal(range(WORDS)), Signal(2), Signal(COUNTER_BITS)
    wanted = Signal(init=1)
    waits = bench.past(result.valid & ~result.ready)
    bench.assume(~waits | (result.valid & (Value.cast(result.p) == bench.past(Value.cast(result.p)))))
    bench.assume(~result.valid | (result.p.last == (number == WORDS - 1)))
    ends = taken(result) & result.p.last
    facts = FACTS(inner["fifo.o__payload"])
    leaves = SimpleNamespace(valid=ends, ready=1, payload=inner["fifo.o__payload"])
    board = Scoreboard(bench, block.facts, leaves, frames(DESIGN), FACTS_LEAVE)
    with m.If(taken(result)):
        m.d.sync += number.eq(Mux(result.p.last, 0, number + 1))
        m.d.sync += frame.eq(frame + ((number == 0) & ~facts.bad))
    with m.If(ends):
        m.d.sync += sent.eq(0)
    with m.Elif((sent != 2) & taken(o)):
        m.d.sync += sent.eq(sent + 1)
    with m.If((sent == 0) & taken(o)):
        m.d.sync += wanted.eq(block.taxel_forces)
    field = forces(DESIGN)
    assert field
    inside = (number >= field.start) & (number < field.start + field.count)
    _claims(bench, block, facts, SimpleNamespace(
        number=number, sent=sent, frame=frame, dropped=facts.bad | (inside & ~wanted)
    ))  # fmt: skip
    _lemmas(bench, block, inner, board, SimpleNamespace(number=number, sent=sent, facts=facts))
    bench.lemma((inner["inside"] == inside) & (inner["with_forces"] == wanted) & (inner["frame"] == frame))


def _claims(bench: Bench, block: Any, facts: Any, at: Any) -> None:
    result, o = block.result, block.o
    stays(bench, o)
    header = Cat(facts.sequence, facts.user)
    bench.claim(FIRST, taken(o) & (at.sent == 0), (o.p.data == header) & ~facts.bad & ~o.p.last)
    faults = Signal(32)
    bench.m.d.comb += faults.eq(sum((facts.flags[name] << bit for name, bit in FAULTS.items()), FORMAT << FORMAT_PLACE))
    bench.claim(SECOND, taken(o) & (at.sent == 1), (o.p.data == faults) & ~o.p.last)
    word = Mux(at.number == 0, at.frame, result.p.data)
    same = (o.p.data.as_signed() == word) & (o.p.last == result.p.last)
    bench.claim(EACH, taken(result) & ~at.dropped, (at.sent == 2) & taken(o) & same)
    bench.claim(NO_OTHER, taken(o) & (at.sent == 2), taken(result) & ~at.dropped)
    bench.claim(DROPPED, taken(result) & at.dropped, ~o.valid)
    bench.claim(SOON, result.valid & (at.sent == 2) & ~at.dropped, o.valid)


def _lemmas(bench: Bench, block: Any, inner: Any, board: Scoreboard, at: Any) -> None:
    state, bad = inner["fsm_state"], at.facts.bad
    good = state == Mux(at.sent == 2, Mux(at.number == 0, _FRAME, _WORDS), at.sent)
    bench.lemma(Mux(state == _SEQUENCE, (at.sent == 0) & (at.number == 0), inner["fifo.occupied"]))
    bench.lemma((state == _SEQUENCE) | Mux(bad, (state == _WORDS) & (at.sent == 0), good))
    bench.lemma(bad | (at.sent == 2) | (at.number == 0) | (state == _SEQUENCE))
    bench.lemma((at.number < WORDS) & (inner["number"] == at.number) & (at.sent <= 2))
    bench.lemma(inner["number_last"] == (at.number == WORDS - 1))
    queue = SimpleNamespace(i=block.facts, o=SimpleNamespace(payload=inner["fifo.o__payload"]))
    fifo = {name.removeprefix("fifo."): signal for name, signal in inner.items() if name.startswith("fifo.")}
    fifo_lemmas(bench, queue, fifo, board, frames(DESIGN), 1)


PROOFS = [
    Proof(
        Framer,
        framer,
        {
            RULE: ("o.valid.eq(result.valid & ~drop)", "o.valid.eq(result.valid & ~drop & ~self.facts.valid)"),
            FACTS_LEAVE: ("fifo.o.ready.eq(ends)", "fifo.o.ready.eq(result.valid & result.p.last)"),
            FIRST: ("Cat(facts.sequence, facts.user)", "Cat(facts.user, facts.sequence)"),
            SECOND: ("self._format << FORMAT_PLACE", "self._format"),
            EACH: ("o.p.last.eq(last)", "o.p.last.eq(0)"),
            NO_OTHER: ("result.ready.eq(o.ready | drop)", "result.ready.eq(drop)"),
            DROPPED: ("drop = facts.bad | (forces & ~with_forces)", "drop = facts.bad"),
            SOON: ("drop = facts.bad | (forces & ~with_forces)", "drop = facts.bad | forces"),
        },
        reach=34,
        size=f"{WORDS} words",
    ),
]
