"""The blocks around a core, :mod:`tfra.hdl.ip`: every stream of words in and out."""

from types import SimpleNamespace
from typing import Any

from amaranth import Array, Mux, Signal, Value

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from bench.formal.streams import ORDER, RULE, SOON, Scoreboard, stays, taken
from tfra.hdl.ip.output_stage import CUT, OUTPUT_BEAT, OutputStage
from tfra.hdl.ip.width_converter import WidthConverter

TAXELS, LANES = 5, 2
"""Of a frame, and of a beat: a complete frame's last beat has one lane."""


def width_converter(bench: Bench, Block: Any) -> None:
    """Frames of any length, complete ones among them, and restarts in any cycle."""
    block = Block(TAXELS, LANES)
    inner = bench.place(block)
    m, beats = bench.m, -(-TAXELS // LANES)
    beat = Signal(Value.cast(block.i.payload).shape())
    words = Array(block.i.payload.shape()(beat).words[lane] for lane in range(LANES))
    number, lane, lanes = Signal(range(beats)), Signal(range(LANES)), Signal(range(LANES + 1))
    with m.If(taken(block.o)):
        m.d.sync += lane.eq(lane + 1)
        m.d.sync += lanes.eq(lanes - 1)
    with m.If(taken(block.i)):
        complete = block.i.p.last & (number == beats - 1)
        m.d.sync += [
            beat.eq(block.i.payload),
            lane.eq(0),
            lanes.eq(Mux(complete, TAXELS - LANES * (beats - 1), LANES)),
            number.eq(Mux(block.i.p.last, 0, Mux(number == beats - 1, number, number + 1))),
        ]
    with m.If(block.restart):
        m.d.sync += lanes.eq(0)
    kept = block.i.payload.shape()(beat)
    out = block.o.payload
    stays(bench, block.o, unless=block.restart)
    ends = kept.last & (lanes == 1)
    word = (lanes != 0) & (out.word == words[lane]) & (out.user == kept.user) & (out.last == ends)
    bench.claim(ORDER, taken(block.o), word)
    bench.claim(SOON, lanes != 0, block.o.valid)
    bench.claim("a beat is taken when the one before has left", (lanes == 0) & ~block.restart, block.i.ready)
    bench.claim("a restart takes no beat", block.restart, ~block.i.ready)
    bench.lemma((inner["full"] == (lanes != 0)) & (inner["number"] == number) & (number < beats))
    bench.lemma((lanes == 0) | (inner["lane"] == lane) & (inner["beat"] == beat))
    bench.lemma((lanes == 0) | (inner["last_lane"] == lane + lanes - 1))
    bench.lemma((lanes == 0) | (lane + lanes <= LANES))


def single(bench: Bench, Block: Any) -> None:
    """A taxel a beat, which its sender keeps until it is taken."""
    block = Block(TAXELS, 1)
    bench.place(block)
    i, o = block.i, block.o
    bench.assume(~bench.past(i.valid & ~i.ready) | i.valid)
    bench.assume(~bench.past(i.valid & ~i.ready) | (Value.cast(i.p) == bench.past(Value.cast(i.p))))
    stays(bench, o)
    same = (o.p.word == i.p.words[0]) & (o.p.user == i.p.user) & (o.p.last == i.p.last)
    bench.claim(ORDER, i.valid, o.valid & same)
    bench.claim("both ends take it at once, but for a restart", taken(o) & ~block.restart, taken(i))
    bench.claim("a restart takes no beat", block.restart, ~i.ready)


def output_stage(bench: Bench, Block: Any) -> None:
    """Frames of two words or more, each of one time; restarts in any cycle."""
    block = Block()
    inner = bench.place(block)
    m, i, o = bench.m, block.i, block.o
    enters = taken(i) & ~block.restart
    opened, cut = Signal(), Signal()
    with m.If(enters):
        m.d.sync += opened.eq(~i.p.last)
    with m.Elif(block.restart & opened):
        m.d.sync += cut.eq(1)
        m.d.sync += opened.eq(0)
    ends = cut & inner["skid.ready"]
    with m.If(ends):
        m.d.sync += cut.eq(0)
    beat = Signal(OUTPUT_BEAT)
    m.d.comb += beat.data.eq(Mux(cut, CUT, i.p.data))
    m.d.comb += beat.last.eq(cut | i.p.last)
    m.d.comb += beat.user.eq(cut)
    stays(bench, o)
    entry = SimpleNamespace(valid=enters | ends, ready=1, payload=beat)
    board = Scoreboard(bench, entry, o, 2)
    bench.claim(SOON, board.inside != 0, o.valid)
    bench.claim("a frame that a restart cuts is ended before the next", cut, ~i.ready)
    bench.claim("its end says so", o.valid & o.p.user, o.p.last & (o.p.data == CUT))
    bench.claim("a complete frame is told when its last word is taken", taken(o) & o.p.last & ~o.p.user, block.ended)
    _time(bench, block, inner, opened, enters)
    bench.lemma((inner["abort"] == cut) & (inner["opened"] == (opened | cut)) & ~(opened & cut))
    bench.lemma(board.inside == o.valid + inner["skid.full"])
    bench.lemma((inner["skid.ready"] == ~inner["skid.full"]) & (o.valid | ~inner["skid.full"]))
    bench.lemma(board.holds([o.payload, inner["skid.skid"]]))
    skid = OUTPUT_BEAT(inner["skid.skid"])
    bench.lemma(~(inner["skid.full"] & skid.user) | (skid.last & (skid.data == CUT)))


def _time(bench: Bench, block: Any, inner: Any, opened: Any, enters: Any) -> None:
    """The time that is given with the end of a frame is the frame's."""
    m, i, o = bench.m, block.i, block.o
    time, ending, due = Signal(32), Signal(32), Signal()
    bench.assume(~(enters & opened) | (i.p.started == time))
    bench.assume(~(enters & ~opened) | ~i.p.last)
    with m.If(enters):
        m.d.sync += time.eq(i.p.started)
        with m.If(i.p.last):
            m.d.sync += ending.eq(i.p.started)
    m.d.sync += due.eq((due & ~block.ended) | (enters & i.p.last))
    bench.claim("with the time of that frame", block.ended, due & (block.started == ending))
    full, skid = inner["skid.full"], OUTPUT_BEAT(inner["skid.skid"])
    in_out, in_skid = o.valid & o.p.last & ~o.p.user, full & skid.last & ~skid.user
    bench.lemma(due == (in_out | in_skid))
    bench.lemma(~due | ((block.started == ending) & (full | ~inner["opened"])))
    bench.lemma(~(in_out & full) | (inner["opened"] & ~skid.last))
    bench.lemma(~in_skid | ~inner["opened"])


_OUT = "wiring.connect(m, skid.o, wiring.flipped(self.o))"

PROOFS = [
    Proof(
        WidthConverter,
        width_converter,
        {
            RULE: ("self.o.valid.eq(full)", "self.o.valid.eq(full & ~self.i.valid)"),
            ORDER: ("Mux(final, self._last_lane, self._per_beat - 1)", "self._per_beat - 1"),
            SOON: ("self.o.valid.eq(full)", "self.o.valid.eq(full & ~taken)"),
            "a beat is taken when the one before has left": (
                "(~full | (last & self.o.ready))",
                "(last & self.o.ready)",
            ),
            "a restart takes no beat": (
                "(~full | (last & self.o.ready)) & ~self.restart",
                "(~full | (last & self.o.ready))",
            ),
        },
        size=f"{TAXELS} taxels, {LANES} a beat",
    ),
    Proof(
        WidthConverter,
        single,
        {
            RULE: ("self.o.valid.eq(self.i.valid)", "self.o.valid.eq(self.i.valid & ~self.restart)"),
            ORDER: ("self.o.p.user.eq(self.i.p.user)", "self.o.p.user.eq(self.i.p.words[0])"),
            "both ends take it at once, but for a restart": ("self.o.ready & ~self.restart", "0"),
            "a restart takes no beat": ("self.o.ready & ~self.restart", "self.o.ready"),
        },
        size="a taxel a beat",
    ),
    Proof(
        OutputStage,
        output_stage,
        {
            RULE: (_OUT, f"{_OUT}; m.d.comb += self.o.valid.eq(skid.o.valid & ~self.restart)"),
            ORDER: ("(self.i.valid & ~self.restart)", "self.i.valid"),
            SOON: (_OUT, f"{_OUT}; m.d.comb += self.o.valid.eq(skid.o.valid & self.i.valid)"),
            "a frame that a restart cuts is ended before the next": ("skid.i.ready & ~abort", "skid.i.ready"),
            "its end says so": ("self.i.p.data | abort.replicate(BITS)", "self.i.p.data"),
            "a complete frame is told when its last word is taken": ("& ~self.o.p.user", "& ~opened"),
            "with the time of that frame": ("with m.If(opened & skid.i.ready)", "with m.If(skid.i.ready)"),
        },
    ),
]
