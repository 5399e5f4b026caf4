"""The reader of a frame's codes, the last stage of the front end: what the core gets."""

from types import SimpleNamespace
from typing import Any

from amaranth import Array, Mux, Signal, Value

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from bench.formal.streams import ORDER, RULE, stays, taken
from tfra.hdl.front_end.output_reader import OutputReader

TAXELS, BITS = 3, 3

DONE, QUIET = "a frame is done with its last code", "no frame is repaired while codes of one are on their way"

_REPAIR, _READ, _SEND = range(3)
"""States of the reader, in the order in which its source names them."""


def output_reader(bench: Bench, Block: Any) -> None:
    """Any codes in memory; frames that wait, are repaired and are cut through at any time."""
    block = Block(SimpleNamespace(sensor=SimpleNamespace(taxels=TAXELS), adc=SimpleNamespace(bits=BITS)))
    inner = bench.place(block)
    m, codes, shape = bench.m, block.codes, block.stored.shape()
    table = Array(bench.constant(len(Value.cast(block.stored))) for _ in range(TAXELS))
    silent = bench.constant(1)
    read, number = Signal(range(TAXELS)), Signal(range(TAXELS))
    with m.If(block.read):
        m.d.sync += read.eq(block.address)
    with m.If(taken(codes)):
        m.d.sync += number.eq(Mux(number == TAXELS - 1, 0, number + 1))
    bench.assume(Value.cast(block.stored) == table[read])
    bench.assume(block.silent == silent)

    def code(place: Any) -> Value:
        word = shape(table[place])
        return Mux(silent | word.small, 0, word.code)

    stays(bench, codes)
    bench.claim(ORDER, taken(codes), codes.payload == code(number))
    bench.claim(DONE, taken(codes), block.done == (number == TAXELS - 1))
    bench.claim(f"{DONE}, not before", ~taken(codes), ~block.done)
    bench.claim(QUIET, block.repair, (number == 0) & ~codes.valid & ~inner["i__valid"] & ~inner["fetched"])
    _lemmas(bench, block, inner, SimpleNamespace(number=number, read=read, table=table, code=code))


def _lemmas(bench: Bench, block: Any, inner: Any, at: Any) -> None:
    """Where each code is: at the output, beside it, before it, in the memory's register."""
    state, address, valid, full = inner["fsm_state"], inner["address"], block.codes.valid, inner["skid.full"]
    before, fetched = inner["i__valid"], inner["fetched"]
    sent = at.number + valid + full  # codes that have reached the skid buffer
    under_way = valid + full + before + fetched
    bench.lemma((inner["skid.ready"] == ~full) & (valid | ~full) & (address < TAXELS) & (at.number < TAXELS))
    bench.lemma(inner["address_last"] == (address == TAXELS - 1))
    bench.lemma(at.number + under_way == Mux(state == _SEND, TAXELS, address))
    bench.lemma((state != _SEND) | ((address == 0) & (under_way != 0)))
    bench.lemma((state != _REPAIR) | ((address == 0) & (under_way == 0) & (at.number == 0)))
    bench.lemma(state <= _SEND)
    bench.lemma(~fetched | ((at.read == sent + before) & (inner["end"] == (at.read == TAXELS - 1))))
    entering = inner["i__payload"]
    bench.lemma(~before | ((Value.cast(inner["word"]) == at.table[sent]) & (entering[BITS] == (sent == TAXELS - 1))))
    for there, word, place in ((valid, inner["skid.out"], at.number), (full, inner["skid.skid"], at.number + 1)):
        bench.lemma(~there | ((word[:BITS] == at.code(place)[:BITS]) & (word[BITS] == (place == TAXELS - 1))))


_VALID = "self.codes.valid.eq(skid.o.valid)"

PROOFS = [
    Proof(
        OutputReader,
        output_reader,
        {
            RULE: (_VALID, "self.codes.valid.eq(skid.o.valid & self.waiting)"),
            ORDER: ("fetched.eq(reading)", "fetched.eq(reading | last)"),
            DONE: ("end.eq(last)", "end.eq(0)"),
            f"{DONE}, not before": ("self.codes.valid & self.codes.ready", "self.codes.valid"),
            QUIET: ('with m.State("SEND"), m.If(self.done)', 'with m.State("SEND"), m.If(skid.o.valid)'),
        },
        reach=20,
        size=f"{TAXELS} taxels",
    ),
]
