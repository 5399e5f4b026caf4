"""A skin's records: the header of every contact, then the words of its window."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from amaranth import Array, Mux, Signal, Value

from bench.formal.bench import Bench
from bench.formal.framer import DESIGN
from bench.formal.prove import Proof
from bench.formal.streams import ORDER, RULE, SOON, Scoreboard, stays, taken
from tfra.hdl.skin.records import Records
from tfra.model.skin.finding import Finding
from tfra.model.skin.records import header_bits
from tfra.model.skin.skin import Skin

SKIN = Skin(replace(DESIGN.sensor, rows=6, columns=8), DESIGN, Finding())

LEAVES = "a contact is done with the last word of its window"
HELD = "words of a window wait for the header"


def records(bench: Bench, Block: Any) -> None:
    """Contacts and what is known of them later stay until they are taken; windows have any number of words."""
    block = Block(SKIN)
    inner = bench.place(block)
    m, contact, ending, words, result = bench.m, block.contact, block.ending, block.words, block.result
    for port in (contact, ending):
        waits = bench.past(port.valid & ~port.ready)
        kept = Value.cast(port.payload) == bench.past(Value.cast(port.payload))
        bench.assume(~waits | (port.valid & kept))
    bits = header_bits(SKIN)
    place = Signal(range(len(bits) + 1))
    frame, number = Signal(bits["frame"]), Signal(bits["contact"])
    facts = {"frame": frame, "contact": number, "last": ending.p.last, "dropped": ending.p.dropped}
    header = Array(facts[name] if name in facts else contact.p[name] for name in bits)
    in_header = place < len(bits)
    word = Signal.like(Value.cast(result.payload))
    view = result.payload.shape()(word)
    m.d.comb += view.data.eq(Mux(in_header, header[place], words.p.data))
    m.d.comb += view.last.eq(~in_header & words.p.last)
    there = Mux(in_header, contact.valid & ending.valid, words.valid)
    entry = SimpleNamespace(valid=there, ready=inner["skid.ready"], payload=word)
    with m.If(taken(entry)):
        m.d.sync += place.eq(Mux(in_header, place + 1, place))
        with m.If(view.last):
            m.d.sync += place.eq(0)
            m.d.sync += number.eq(Mux(ending.p.last, 0, number + 1))
            m.d.sync += frame.eq(frame + ending.p.last)
    stays(bench, result)
    board = Scoreboard(bench, entry, result, 2)
    bench.claim(SOON, board.inside != 0, result.valid)
    bench.claim(LEAVES, taken(entry) & view.last, contact.ready & ending.ready & taken(words))
    bench.claim(f"{LEAVES}, not before", contact.ready | ending.ready, taken(words) & words.p.last)
    bench.claim(HELD, in_header, ~words.ready)
    bench.lemma((inner["index"] == place) & (inner["frame"] == frame) & (inner["number"] == number))
    bench.lemma(place <= len(bits))
    bench.lemma(in_header | (contact.valid & ending.valid) | (place == 0))
    bench.lemma(board.inside == result.valid + inner["skid.full"])
    bench.lemma((inner["skid.ready"] == ~inner["skid.full"]) & (result.valid | ~inner["skid.full"]))
    bench.lemma(board.holds([result.payload, inner["skid.skid"]]))


_CONNECT = "wiring.connect(m, skid.o, wiring.flipped(self.result))"

PROOFS = [
    Proof(
        Records,
        records,
        {
            RULE: (_CONNECT, f"{_CONNECT}; m.d.comb += self.result.valid.eq(skid.o.valid & self.contact.valid)"),
            ORDER: ("Mux(ending.last, 0, number + 1)", "number + 1"),
            SOON: (_CONNECT, f"{_CONNECT}; m.d.comb += self.result.valid.eq(skid.o.valid & self.words.valid)"),
            LEAVES: ("self.ending.ready.eq(ends)", "self.ending.ready.eq(ends & ending.last)"),
            f"{LEAVES}, not before": ("self.contact.ready.eq(ends)", "self.contact.ready.eq(sent)"),
            HELD: ("~is_header & skid.i.ready", "skid.i.ready"),
        },
        reach=26,
    ),
]
