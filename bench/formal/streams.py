"""What streams promise, and the blocks of :mod:`tfra.hdl.lib.streams`."""

from types import SimpleNamespace
from typing import Any

from amaranth import Array, Cat, Const, Mux, Signal, Value, unsigned
from amaranth.lib import data

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from tfra.hdl.lib.streams import Buffer, Fifo, Fork, PerFrameFifo, Router, SkidBuffer, Tokens

WIDTH = 3
RULE, ORDER, SOON = "what is offered stays until it is taken", "no word is lost, doubled or changed", "words leave soon"


def taken(port: Any) -> Value:
    """A transfer ends."""
    return port.valid & port.ready


def stays(bench: Bench, port: Any, name: str = RULE, unless: Any = 0) -> None:
    """AXI4-Stream's rule of the output ``port``: valid stays high, and its payload as it is, until ready.

    It does not hold in the cycle after one of ``unless``.
    """
    waits = bench.past(port.valid & ~port.ready & ~Value.cast(unless))
    before = bench.past(Value.cast(port.payload))
    bench.claim(name, waits, port.valid & (Value.cast(port.payload) == before))


class Scoreboard:
    """Follows any one transfer from ``i`` through a block to ``o``; others are counted.

    ``ahead`` transfers have to leave before the one that is ``followed``, whose payload is ``word``.  ``inside`` counts
    all, ``most`` of them.
    """

    def __init__(self, bench: Bench, i: Any, o: Any, most: int, name: str = ORDER) -> None:
        m = bench.m
        self.inside = Signal(range(most + 2))
        self.ahead = Signal(range(most + 2))
        self.followed = Signal()
        self.word = Signal(Value.cast(i.payload).shape())
        follow = bench.free(1, "follow")
        enters, leaves = taken(i), taken(o)
        m.d.sync += self.inside.eq(self.inside + enters - leaves)
        with m.If(self.followed & leaves):
            m.d.sync += self.ahead.eq(self.ahead - 1)
            m.d.sync += self.followed.eq(self.ahead != 0)
        with m.If(~self.followed & follow & enters):
            m.d.sync += self.followed.eq(1)
            m.d.sync += self.ahead.eq(self.inside - leaves)
            m.d.sync += self.word.eq(i.payload)
        first = self.followed & (self.ahead == 0)
        bench.claim(name, leaves, (self.inside != 0) & (~first | (Value.cast(o.payload) == self.word)))
        bench.lemma(self.inside <= most)
        bench.lemma(~self.followed | (self.ahead < self.inside))

    def holds(self, places: list[Any]) -> Value:
        """The followed word is at its place of ``places``, the next to leave first."""
        return ~self.followed | (Array(Value.cast(place) for place in places)[self.ahead] == self.word)


def offered_within(bench: Bench, inside: Value, valid: Value, cycles: int) -> None:
    """Whatever is ``inside`` is offered after some ``cycles`` at the latest."""
    waits = Signal(range(cycles + 2))
    bench.m.d.sync += waits.eq(Mux((inside != 0) & ~valid, waits + 1, 0))
    bench.claim(SOON, inside != 0, waits <= cycles)
    bench.lemma(waits <= cycles)


def skid_buffer(bench: Bench, Block: Any) -> None:
    """Two places."""
    block = Block(unsigned(WIDTH))
    inner = bench.place(block)
    stays(bench, block.o)
    board = Scoreboard(bench, block.i, block.o, 2)
    offered_within(bench, board.inside, block.o.valid, 0)
    bench.lemma(board.inside == block.o.valid + inner["full"])
    bench.lemma(inner["ready"] == ~inner["full"])
    bench.lemma(block.o.valid | ~inner["full"])
    bench.lemma(board.holds([block.o.payload, inner["skid"]]))


def buffer(bench: Bench, Block: Any) -> None:
    """One place."""
    block = Block(unsigned(WIDTH))
    bench.place(block)
    stays(bench, block.o)
    board = Scoreboard(bench, block.i, block.o, 1)
    offered_within(bench, board.inside, block.o.valid, 0)
    bench.lemma(board.inside == block.o.valid)
    bench.lemma(board.holds([block.o.payload]))


def fifo(depth: int, beats: int) -> Any:
    """``depth`` transfers of ``beats``; the sender keeps one until all of its beats have entered."""

    def setup(bench: Bench, Block: Any) -> None:
        block = Block(unsigned(2 * beats), depth, *([beats] if beats > 1 else []))
        inner = bench.place(block)
        if beats > 1:
            bench.assume(~bench.past(block.i.valid & ~block.i.ready) | block.i.valid)
            bench.assume(~bench.past(block.i.valid & ~block.i.ready) | (block.i.payload == bench.past(block.i.payload)))
        stays(bench, block.o)
        board = Scoreboard(bench, block.i, block.o, depth)
        offered_within(bench, board.inside, block.o.valid, 2 * beats - 1)
        fifo_lemmas(bench, block, inner, board, depth, beats)

    return setup


def fifo_lemmas(bench: Bench, block: Any, inner: Any, board: Scoreboard, depth: int, beats: int) -> None:
    """Counters agree with each other, and the followed word is where they say."""
    places, size = depth * beats, len(board.word) // beats
    head, tail, stored, occupied = (inner[name] for name in ("head", "tail", "taken", "occupied"))
    put, got = (inner[name] if beats > 1 else Const(0) for name in ("put", "got"))
    bench.lemma((head < places) & (inner["head_last"] == (head == places - 1)))
    bench.lemma((tail < places) & (inner["tail_last"] == (tail == places - 1)))
    bench.lemma(_wrapped(tail + stored, places) == head)
    bench.lemma((stored < places) & (inner["some"] == (stored != 0)) & (inner["full"] == (stored == places - 1)))
    bench.lemma(board.inside * beats + put == stored + occupied + got)
    if beats > 1:
        bench.lemma((put < beats) & (inner["put_last"] == (put == beats - 1)))
        bench.lemma((got < beats) & (inner["got_last"] == (got == beats - 1)))
        latest = bench.look_up(inner["memory"], Mux(head == 0, places - 1, head - 1))
        bench.lemma((put == 0) | (latest == bench.past(block.i.payload)[:size]) & bench.past(block.i.valid))
    for beat in range(beats):
        later = board.ahead * beats + beat - got  # beats that leave before this one
        stored_word = bench.look_up(inner["memory"], _wrapped(tail + later - occupied, places))
        out = Value.cast(block.o.payload)
        word = Mux(
            occupied & (later == 0), out[-size:], Mux(later < 0, inner["earlier"] if beats > 1 else 0, stored_word)
        )
        bench.lemma(~board.followed | (word == board.word.word_select(beat, size)))


def _wrapped(place: Value, places: int) -> Value:
    """``place`` within two turns, in one."""
    return Mux(place >= places, place - places, place)


def fork(bench: Bench, Block: Any) -> None:
    """Two sinks; the sender keeps what it offers."""
    block = Block(unsigned(WIDTH), 2)
    inner = bench.place(block)
    waits = bench.past(block.i.valid & ~block.i.ready)
    bench.assume(~waits | (block.i.valid & (block.i.payload == bench.past(block.i.payload))))
    had = [Signal(name=f"had{way}") for way in range(2)]
    bench.lemma(inner["taken"] == Cat(had))
    for way, o in enumerate(block.o):
        stays(bench, o, f"{RULE} ({way})")
        bench.m.d.sync += had[way].eq((had[way] | taken(o)) & ~taken(block.i))
        bench.claim(f"{ORDER} ({way})", taken(o), block.i.valid & ~had[way] & (o.payload == block.i.payload))
        bench.claim(f"a word ends when it has been taken ({way})", taken(block.i), had[way] | taken(o))
        bench.claim(f"it is offered at once ({way})", block.i.valid & ~had[way], o.valid)


def tokens(bench: Bench, Block: Any) -> None:
    """Three tokens, two pulses for each; none is given that is not out."""
    number, every = 3, 2
    block = Block(number, every)
    inner = bench.place(block)
    parts, left = Signal(range(every)), Signal(range(number + 1), init=number)
    leaves, gives = taken(block.o), block.give & (parts == every - 1)
    bench.assume(~gives | leaves | (left != number))
    bench.m.d.sync += left.eq(left + gives - leaves)
    with bench.m.If(block.give):
        bench.m.d.sync += parts.eq(Mux(parts == every - 1, 0, parts + 1))
    stays(bench, block.o)
    bench.claim("a token is offered while one is left", left != 0, block.o.valid)
    bench.claim("none is offered when all are out", left == 0, ~block.o.valid)
    bench.lemma((inner["parts"] == parts) & (inner["parts_last"] == (parts == every - 1)))
    bench.lemma(inner["taken"] == Array((1 << n) - 1 for n in range(number + 1))[left])
    bench.lemma(left <= number)


def per_frame_fifo(bench: Bench, Block: Any) -> None:
    """Three transfers, of which one of two fields is stored."""
    block = Block(data.StructLayout({"kept": WIDTH, "left": WIDTH}), ("kept",), 3)
    inner = bench.place(block)
    ends = [SimpleNamespace(valid=o.valid, ready=o.ready, payload=o.p.kept) for o in (block.i, block.o)]
    board = Scoreboard(bench, ends[0], ends[1], 3)
    bench.claim("fields that are not stored are zero", block.o.valid, block.o.p.left == 0)
    fifo_lemmas(bench, SimpleNamespace(i=ends[0], o=ends[1]), inner, board, 3, 1)


def router(bench: Bench, Block: Any) -> None:
    """Three kinds, two sinks, one of which takes two of the kinds."""
    table = ((0,), (0, 1), (1,))
    block = Block(data.StructLayout({"kind": len(table), "words": WIDTH}), table, 2)
    bench.place(block)
    came, sent = bench.past(block.i.valid), bench.past(Value.cast(block.i.p.words))
    kind = bench.past(Value.cast(block.i.p.kind))
    for way, o in enumerate(block.o):
        meant = Cat(kind[number] for number, ways in enumerate(table) if way in ways).any()
        bench.claim(
            f"a word that is meant for it comes a cycle later ({way})", came & meant, o.valid & (o.payload == sent)
        )
        bench.claim(f"no other comes ({way})", ~(came & meant), ~o.valid)


PROOFS = [
    Proof(
        SkidBuffer,
        skid_buffer,
        {
            RULE: ("~self.o.valid | self.o.ready", "self.o.ready | self.i.valid"),
            ORDER: ("Mux(full, skid, self.i.p)", "Mux(full, self.i.p, skid)"),
            SOON: ("self.i.valid | full", "self.i.valid"),
        },
    ),
    Proof(
        Buffer,
        buffer,
        {
            RULE: ("with m.If(~full)", "with m.If(~full | self.i.valid)"),
            ORDER: ("ready.eq(~full)", "ready.eq(1)"),
            SOON: ("self.o.valid.eq(full)", "self.o.valid.eq(full & self.i.valid)"),
        },
    ),
    Proof(
        Fifo,
        fifo(3, 1),
        {
            RULE: ("advance.eq(~occupied | pop)", "advance.eq(1)"),
            ORDER: ("push.eq(self.i.valid & ~full)", "push.eq(self.i.valid)"),
            SOON: ("advance.eq(~occupied | pop)", "advance.eq(pop)"),
        },
        reach=14,
        size="3 words",
    ),
    Proof(
        Fifo,
        fifo(2, 2),
        {
            RULE: ("advance.eq(~occupied | pop)", "advance.eq(1)"),
            ORDER: ("Cat(earlier, beat)", "Cat(beat, earlier)"),
            SOON: ("advance.eq(~occupied | pop)", "advance.eq(pop)"),
        },
        reach=16,
        size="2 words of 2 beats",
    ),
    Proof(
        Fork,
        fork,
        {
            f"{RULE} (0)": ("self.i.valid & ~taken[way]", "self.i.valid & ~taken[way] & self.o[1].ready"),
            f"{RULE} (1)": ("self.i.valid & ~taken[way]", "self.i.valid & ~taken[way] & self.o[0].ready"),
            **{
                f"{ORDER} ({way})": ("o.valid.eq(self.i.valid & ~taken[way])", "o.valid.eq(self.i.valid)")
                for way in (0, 1)
            },
            "a word ends when it has been taken (0)": ("self.i.ready.eq(done.all())", "self.i.ready.eq(done[1])"),
            "a word ends when it has been taken (1)": ("self.i.ready.eq(done.all())", "self.i.ready.eq(done[0])"),
            **{f"it is offered at once ({way})": ("Mux(done.all(), 0, done)", "done") for way in (0, 1)},
        },
    ),
    Proof(
        Tokens,
        tokens,
        {
            RULE: ("m.d.comb += self.o.valid.eq(left[0])", "m.d.comb += self.o.valid.eq(left[0] & ~self.give)"),
            "a token is offered while one is left": ("left[0]", "left[1]"),
            "none is offered when all are out": ("self.give & completes", "self.give"),
        },
    ),
    Proof(
        PerFrameFifo,
        per_frame_fifo,
        {
            ORDER: ("payload[name] for", "payload[name][:-1] for"),
            "fields that are not stored are zero": ("if self._fields else", "if not self._fields else"),
        },
    ),
    Proof(
        Router,
        router,
        {
            **{
                f"a word that is meant for it comes a cycle later ({way})": ('words, "words"', 'words + 1, "words"')
                for way in (0, 1)
            },
            **{f"no other comes ({way})": ("self.i.valid & selected", "self.i.valid") for way in (0, 1)},
        },
    ),
]
