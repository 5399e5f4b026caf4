"""Vector updates ``z + s * x`` (Eqs. 7, 8, 10): residuals of the candidates, weights of the forces."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from amaranth import Array, C, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, quad, round_top, two_steps
from tfra.hdl.lib.pipeline import READ, delayed, register, wrapping_counter
from tfra.hdl.lib.streams import TOKEN, Spare, Tokens, always_ready_stream
from tfra.hdl.parallel.beats import beat_in_quad, beat_number, beat_valid, select_beat
from tfra.hdl.parallel.payloads import affine, chosen, direction, operand, vector_beat, vector_quad
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE, Level, Store, headrooms, place
from tfra.model.fixed.design import Design
from tfra.model.fixed.scalars import scalar_fraction

_READ_X = 1
"""Stage beside which x is read: what enters is in a register."""

_FOUND = _READ_X + READ
"""Stage beside which x is there."""

_SUM = _FOUND + 10
"""Stages of the pipeline; the register of the last one is the sum, and that of the output follows."""

_READ_Z = _SUM - 3 - READ
"""Stage beside which z is read, so late that it comes to the adder with its product."""

_START = 2
"""Cycles from the last fact that a vector needs to the entry of its first part; from the last part of x, three more."""

_FINE = 2
"""Bits of a headroom by which the second step of a shift moves: a word's whole shift would be a long path."""


class Job(IntEnum):
    """What a part in the pipeline becomes."""

    E0 = 0
    E1 = 1
    D = 2
    FORCE = 3


class Combine(wiring.Component):
    """The one unit for ``z + s * x``; the model is :func:`tfra.model.fixed.tfra.combine.combine`, W words at a time.

    ::

        e0 = d0 + alpha d_dep,  d0 = b + g     e1 = d_ind + beta d_dep     d = e0 + mu_ind e1
        f_x = A1-dagger d + mu_x n             f_y = A2-dagger d + mu_y n  f_z = A3-dagger d - n

        entry -> x store -> choice -> align -> round -> x s -> shift -> + z      z: z store -> choices
          1       2, 3        4       5, 6      7, 8    9, 10   11, 12    13         (one register each)

    x enters as a multiplier operand, moved left by the bits that its parity leaves free; these are found while x
    is written.  A quad takes ``design.cycles_per_quad`` cycles; there are W = ``vector_words`` multipliers of operand x
    operand bits.

    Products enter as they come, before a vector's parts.  Of the vectors d goes before e0, so that the
    older of two frames does; a vector is begun when ``bank_token`` says that its receiver can take it, since nothing in
    the pipeline waits.  ``combine_store.FRAMES`` frames have a place each in the stores: whoever sends something of
    a frame holds its token.

    Members:
        b: Q quads a frame, folded stress in converter codes; of one frame more than those that hold a token.
        n: Q quads a frame, folded weights.
        residual: 3 Q quads a frame, behind its b: g, d1, d2.
        direction, affine: one transfer a frame, taken a cycle behind the entry of the last part of e1.
        chosen: one transfer a frame, taken a cycle behind the entry of the last part of d.
        forced: the same, taken when the forces of the frame before are on their way.
        products: 3 Q quads a frame, behind its n and ``forced``: A1-dagger d, A2-dagger d, A3-dagger d.
        bank_token: tokens, one taken for each vector.
        frame_token: tokens out, one for each frame that has a place in the stores; its forces return it.
        vector: 3 Q quads a frame: e0, e1, and later d.
        forces: 3 Q quads a frame: folded f_x, f_y, f_z.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = always_ready_stream(vector_quad(design))
        super().__init__(
            {
                "b": In(always_ready_stream(quad(design.adc.bits + 2))),
                "n": In(vector),
                "residual": In(vector),
                "direction": In(stream.Signature(direction(design))),
                "affine": In(stream.Signature(affine(design))),
                "chosen": In(stream.Signature(chosen(design))),
                "forced": In(stream.Signature(chosen(design))),
                "products": In(vector),
                "bank_token": In(stream.Signature(TOKEN)),
                "frame_token": Out(stream.Signature(TOKEN)),
                "vector": Out(always_ready_stream(operand(design))),
                "forces": Out(vector),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the last part of ``residual`` to the first transfer of ``vector``, e0.

        ``affine`` and ``direction`` are held by their senders; when one comes later, it is three less from the first
        clock edge that finds both valid.
        """
        return MEASURE + self._design.cycles_per_quad + self.force_latency

    @property
    def update_latency(self) -> int:
        """Cycles from the first clock edge that finds ``chosen`` valid to the first transfer of d.

        When the last e1 leaves later than that, cycles count from the second one behind its transfer.
        """
        return _START + self._design.cycles_per_quad - 1 + self.force_latency

    @property
    def force_latency(self) -> int:
        """Cycles from the last part of a quad of ``products`` to the transfer of its quad of ``forces``."""
        return _SUM + 1

    @property
    def pause(self) -> int:
        """Cycles between the entry of a vector's last part and that of the next one's first, beyond one."""
        return 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        w = _Wires(self._design)
        for name in ("n", "x", "z", "e0", "e1"):
            m.submodules[f"{name}_store"] = getattr(w, name)
        for name in ("d_level", "e_level"):
            m.submodules[name] = getattr(w, name)
        m.submodules.frame_tokens = frames = Tokens(FRAMES)
        wiring.connect(m, frames.o, wiring.flipped(self.frame_token))
        self._load_weights(m, w)
        self._load_residuals(m, w)
        self._enter(m, w, frames)
        self._vectors(m, w)
        self._leave(m, w)
        self._read(m, w)
        self._multiply(m, w)
        self._add(m, w)
        return m

    def _walk(self, m: Module, valid: Value) -> tuple[Value, Value, Value]:
        """A part is there; its number in the vector; it ends the vector."""
        design, step = self._design, Signal()
        number, last = wrapping_counter(m, step, design.quads * design.cycles_per_quad)
        m.d.comb += step.eq(beat_valid(m, valid, beat_in_quad(design, number) == design.cycles_per_quad - 1))
        return step, number, step & last

    def _load_weights(self, m: Module, w: _Wires) -> None:
        """A cycle behind the transfer."""
        loaded, number, ends = self._walk(m, self.n.valid)
        head, _ = wrapping_counter(m, ends, FRAMES, "head")
        m.d.sync += w.n.write.eq(loaded)
        m.d.comb += [
            w.n.write_place.eq(register(m, head)),
            w.n.write_number.eq(register(m, number)),
            w.n.words.eq(register(m, select_beat(self._design, self.n.payload, number))),
        ]

    def _load_residuals(self, m: Module, w: _Wires) -> None:
        """b waits in a memory of its own for g; d1 and d2 go to both stores, since each is an x or a z.

        That memory has one place more than there are frames with a token: of the one that is still an operand.
        """
        design, q, fraction = self._design, self._design.quads, self._design.formats.vector_fraction
        loaded, number, ends = self._walk(m, self.residual.valid)
        step, whole = wrapping_counter(m, ends, 3, "step")  # g, d1, d2
        head, _ = wrapping_counter(m, ends & whole, FRAMES, "head")
        facts = {"step": 2, "place": place, "number": len(number)}
        put = Signal(data.StructLayout({"words": vector_beat(design), **facts}), reset_less=True)
        valid = register(m, loaded, control=True)
        m.d.sync += [
            put.words.eq(select_beat(design, self.residual.payload, number)),
            put.step.eq(step),
            put.place.eq(head),
            put.number.eq(number),
        ]
        depth = (FRAMES + 1) << counter_shape(q - 1).width
        m.submodules.b = bs = memory.Memory(shape=self.b.payload.shape(), depth=depth, init=[])
        b_write, b_read = bs.write_port(), bs.read_port()
        b_number, b_last = wrapping_counter(m, self.b.valid, q)
        b_head, _ = wrapping_counter(m, self.b.valid & b_last, FRAMES + 1, "b_head")
        b_tail, _ = wrapping_counter(m, register(m, ends & (step == 0), control=True), FRAMES + 1, "b_tail")
        m.d.comb += [
            b_write.en.eq(self.b.valid),
            b_write.addr.eq(Cat(b_number, b_head)),
            b_write.data.eq(self.b.payload),
            b_read.addr.eq(Cat((number >> len(beat_in_quad(design, number)))[: len(b_number)], b_tail)),
            w.d_level.enter.eq(delayed(m, ends & whole, MEASURE - 1, control=True)),
            w.x.write.eq(register(m, loaded & (step != 0), control=True)),
            w.x.write_place.eq(put.place),
            w.x.write_vector.eq(put.step == 2),
            w.x.write_number.eq(put.number),
            w.x.words.eq(put.words),
        ]
        later = data.View(put.shape(), register(m, put.as_value()))
        found = data.View(b_read.data.shape(), register(m, b_read.data.as_value()))
        codes = select_beat(design, found, later.number)
        m.d.sync += w.z.write.eq(register(m, valid, control=True))
        m.d.comb += [
            w.z.write_place.eq(register(m, later.place)),
            w.z.write_vector.eq(register(m, later.step)),
            w.z.write_number.eq(register(m, later.number)),
        ]
        for k in range(design.architecture.vector_words):
            b = Mux(later.step == 0, codes.word_select(k, len(found[k])).as_signed() << fraction, 0)
            m.d.comb += w.z.words[k].eq(register(m, (later.words[k] + b)[: len(later.words[k])]))

    def _enter(self, m: Module, w: _Wires, frames: Tokens) -> None:
        """What enters the pipeline: a part of products, or else one of the vector in hand."""
        m.submodules.forced = waiting = Spare(self.forced.payload.shape())
        wiring.connect(m, wiring.flipped(self.forced), waiting.i)
        take, number, ends = self._walk(m, self.products.valid)
        plane, _ = wrapping_counter(m, ends, 3, "plane")
        _, last = wrapping_counter(m, take, 3 * self._design.quads * self._design.cycles_per_quad, "part")
        whole = take & last
        tail, _ = wrapping_counter(m, whole, FRAMES, "tail")
        minus_one = C(-1 << scalar_fraction(self._design), signed(self._design.formats.operand))
        forced, tag = waiting.o.payload, w.tag[0]
        # A cycle behind the entry, since the way from the products is long.
        left, entered = register(m, whole, "left", control=True), register(m, plane, "entered")
        m.d.comb += [
            w.take.eq(take),
            w.product.eq(select_beat(self._design, self.products.payload, number)),
            w.forced.eq(Array([forced.mu_x, forced.mu_y, minus_one])[entered]),
            waiting.o.ready.eq(left),
            frames.give.eq(left),
            w.valid[0].eq(w.take | w.busy),
        ]
        with m.If(w.take):
            m.d.comb += [tag.job.eq(Job.FORCE), tag.place.eq(tail), tag.number.eq(number)]
        with m.Else():
            m.d.comb += tag.eq(w.vector)

    def _vectors(self, m: Module, w: _Wires) -> None:
        """Begin a vector when all it needs is there, and walk through its parts."""
        candidates, update, second = Signal(), Signal(), Signal()
        step, ends, vector, final = Signal(), Signal(), w.vector, Signal()  # final: vector is its last part
        sweep_y, facts, winner = self.direction.payload.sweep_y, self.affine.payload, self.chosen.payload
        m.d.comb += [
            step.eq(w.busy & ~w.take),
            ends.eq(step & final),
            self.affine.ready.eq(w.d_level.leave),
            self.direction.ready.eq(w.d_level.leave),
            self.chosen.ready.eq(w.e_level.leave),
        ]
        m.d.sync += [  # registers, since the way from here to the queues of facts is long
            w.d_level.leave.eq(ends & (vector.job == Job.E1)),
            w.e_level.leave.eq(ends & (vector.job == Job.D)),
            candidates.eq(self.affine.valid & self.direction.valid & ~w.d_level.leave),
            update.eq(self.chosen.valid & ~w.e_level.leave),
        ]
        begin_d = update & w.e_level.some & ~w.e_level.leave
        begin_e = candidates & w.d_level.some & ~w.d_level.leave
        with m.If(step):
            m.d.sync += [vector.number.eq(vector.number + 1), final.eq(vector.number == w.last - 1), w.busy.eq(~final)]
        # A cycle late, since the way to the tokens is long; until then the unit is busy.
        m.d.comb += self.bank_token.ready.eq(
            register(m, ~w.busy & self.bank_token.valid & (begin_d | begin_e), control=True)
        )
        with m.If(~w.busy & self.bank_token.valid):
            m.d.sync += [w.busy.eq(begin_d | begin_e), vector.number.eq(0), final.eq(w.last == 0)]
            with m.If(begin_d):
                m.d.sync += [vector.job.eq(Job.D), vector.place.eq(w.e_level.tail), vector.scalar.eq(winner.mu_ind)]
            with m.Elif(begin_e):
                m.d.sync += [
                    second.eq(~second),
                    vector.job.eq(Mux(second, Job.E1, Job.E0)),
                    vector.place.eq(w.d_level.tail),
                    vector.scalar.eq(Mux(second, facts.beta, facts.alpha)),
                    vector.swap.eq(sweep_y),
                ]

    def _leave(self, m: Module, w: _Wires) -> None:
        """Stages move on in every cycle; behind the last, whole quads."""
        tag, valid = w.tag[_SUM], w.valid[_SUM]
        force = tag.job == Job.FORCE
        whole = valid & (beat_in_quad(self._design, tag.number) == self._design.cycles_per_quad - 1)
        words = register(m, self._quad(m, w), "words")
        m.d.comb += [
            self.vector.valid.eq(register(m, whole & ~force, control=True)),
            self.vector.payload.words.eq(words),
            self.vector.payload.force.eq(register(m, tag.job == Job.D)),
            self.forces.valid.eq(register(m, whole & force, control=True)),
            self.forces.payload.eq(words),
        ]
        ends = valid & (tag.job == Job.E1) & (tag.number == w.last)
        m.d.comb += w.e_level.enter.eq(delayed(m, ends, MEASURE - 1, control=True))
        for k in range(1, _SUM + 1):
            m.d.sync += [w.valid[k].eq(w.valid[k - 1]), w.tag[k].eq(w.tag[k - 1])]
        with m.If(w.tag[1].job == Job.FORCE):
            m.d.sync += w.tag[2].scalar.eq(w.forced)

    def _quad(self, m: Module, w: _Wires) -> Value:
        """The sums of a quad's parts; those of a force may come between those of a vector."""
        latest, force = w.sum.as_value(), w.tag[_SUM].job == Job.FORCE
        if self._design.cycles_per_quad == 1:
            return latest
        kept = []
        for number, mine in enumerate((~force, force)):
            parts = Signal((self._design.cycles_per_quad - 1) * len(latest), name=f"kept{number}", reset_less=True)
            with m.If(w.valid[_SUM] & mine):
                m.d.sync += parts.eq(Cat(parts, latest)[len(latest) :])
            kept.append(parts)
        return Cat(Mux(force, kept[1], kept[0]), latest)

    def _read(self, m: Module, w: _Wires) -> None:
        """x first; z so late that it comes to the adder with its product.  Sums e0 and e1 return to stores."""
        early, late, tag = w.tag[_READ_X], w.tag[_READ_Z], w.tag[_SUM]
        for store, at in ((w.n, early), (w.x, early), (w.e1, early), (w.z, late), (w.e0, late)):
            m.d.comb += [store.read_place.eq(at.place), store.read_number.eq(at.number)]
        m.d.comb += [
            w.x.read_vector.eq(~early.swap),  # d_dep
            w.z.read_vector.eq(Mux(late.job == Job.E0, 0, Mux(late.swap, 2, 1))),  # d0, d_ind
        ]
        for store, job in ((w.e0, Job.E0), (w.e1, Job.E1)):
            m.d.comb += [
                store.write.eq(register(m, w.valid[_SUM - 1] & (w.tag[_SUM - 1].job == job), control=True)),
                store.write_place.eq(tag.place),
                store.write_number.eq(tag.number),
                store.words.eq(w.sum),
            ]
        job, sources = w.tag[_FOUND].job, [w.x, w.x, w.e1, w.n]
        found, update = w.tag[_READ_Z + READ], w.tag[_READ_Z + READ].job == Job.D
        stored = register(m, Mux(update, w.e0.part.as_value(), w.z.part.as_value()), "stored")
        m.d.sync += [
            w.words.eq(Array(s.part.as_value() for s in sources)[job]),
            w.room[_FOUND + 1].eq(Array(s.room.as_value() for s in sources)[job]),
            w.base.eq(Mux(register(m, found.job == Job.FORCE), self._products(m, w), stored)),
        ]

    def _products(self, m: Module, w: _Wires) -> Value:
        """The z of forces: what enters meets its x n where other parts' z comes from the store."""
        wait = _READ_Z + 1
        m.submodules.products = ring = memory.Memory(shape=vector_beat(self._design), depth=16, init=[])
        write, read = ring.write_port(), ring.read_port()
        cycle = Signal(range(ring.depth))
        assert wait < ring.depth
        m.d.sync += cycle.eq(cycle + 1)
        m.d.comb += [
            write.en.eq(1),
            write.addr.eq(cycle),
            write.data.eq(w.product),
            read.addr.eq(cycle - wait),
        ]
        return register(m, read.data.as_value(), "found")

    def _multiply(self, m: Module, w: _Wires) -> None:
        """Align x by its headroom, round it to an operand, multiply, and shift back by the headroom.

        Either shift takes two steps, the low bits of the headroom the second.
        """
        fmt, bits = self._design.formats, self._design.widths.vector
        drop = scalar_fraction(self._design) + fmt.operand - bits
        size = self._design.architecture.vector_words
        aligned = Signal(vector_beat(self._design), reset_less=True)
        scalar = Signal(signed(fmt.operand), reset_less=True)
        words = Signal(data.ArrayLayout(signed(fmt.operand), size), reset_less=True)
        # A register for each word: yosys packs one of all words into the SB_MAC16 of the first and loses the rest.
        product = [Signal(signed(2 * fmt.operand), name=f"product{k}", reset_less=True) for k in range(size)]
        m.d.sync += [w.room[k].eq(w.room[k - 1]) for k in range(_FOUND + 2, _SUM - 1)]
        m.d.sync += scalar.eq(w.tag[_FOUND + 4].scalar)
        for k in range(size):
            room = {stage: two_steps(w.room[stage][k], _FINE) for stage in w.room}
            coarse = register(m, w.words[k] << room[_FOUND + 1][0], "coarse")
            # A second register, for multipliers are far from what follows; of the bits that are read alone, or yosys
            # packs it into an SB_MAC16 and loses it.
            later = register(m, _drop(product[k], drop), "later")
            back = register(m, later >> room[_SUM - 3][0], "back")
            m.d.sync += [
                aligned[k].eq(coarse << room[_FOUND + 2][1]),
                words[k].eq(register(m, round_top(aligned[k], fmt.operand), "rounded")),
                product[k].eq(words[k] * scalar),
                w.shifted[k].eq(back >> room[_SUM - 2][1]),
            ]

    def _add(self, m: Module, w: _Wires) -> None:
        """``z + round_half(shifted)`` in one adder: ``(2 z + 1 + shifted) >> 1``."""
        for k in range(self._design.architecture.vector_words):
            m.d.sync += w.sum[k].eq((Cat(1, w.base[k]).as_signed() + w.shifted[k]) >> 1)


class _Wires:
    """Signals that the parts of the unit share; ``valid[k]`` and ``tag[k]`` stand beside the register of stage k."""

    def __init__(self, design: Design) -> None:
        size, scalar = design.architecture.vector_words, signed(design.formats.operand)
        number = beat_number(design)
        self.last = design.quads * design.cycles_per_quad - 1
        tag = data.StructLayout({"job": 2, "place": place, "number": number, "swap": 1, "scalar": scalar})
        self.n, self.x = Store(design, headroom=True), Store(design, 2, headroom=True)
        self.z, self.e0, self.e1 = Store(design, 3), Store(design), Store(design, headroom=True)
        self.d_level, self.e_level = Level(), Level()
        """Frames of d0, d1 and d2, until e1 has entered; of e0 and e1, from the sum of e1 until d has entered.  They
        enter when their headroom can be read."""
        self.busy, self.vector = Signal(), Signal(tag, reset_less=True)
        """A vector is in hand; its next part."""
        self.take, self.product = Signal(), Signal(vector_beat(design))
        """A part of products enters."""
        self.forced = Signal(scalar)
        """The scalar of what entered a cycle ago, if it is of a force."""
        self.valid = [Signal(name=f"valid{k}") for k in range(_SUM + 1)]
        self.tag = [Signal(tag, name=f"tag{k}", reset_less=k > 0) for k in range(_SUM + 1)]
        rooms, part = headrooms(design, size), vector_beat(design)
        self.room = {k: Signal(rooms, name=f"room{k}", reset_less=True) for k in range(_FOUND + 1, _SUM - 1)}
        self.words, self.base, self.sum = (Signal(part, name=n, reset_less=True) for n in ("words", "base", "sum"))
        longer = data.ArrayLayout(signed(design.widths.vector + 1), size)
        self.shifted = Signal(longer, reset_less=True)


def _drop(product: Value, drop: int) -> Value:
    """``product / 2^drop`` with one bit below the point; what is left to shift is the headroom of x.

    The bits cut off can't reach the rounding; vectors longer than operands make ``drop`` negative.
    """
    return product[drop - 1 :].as_signed() if drop > 0 else Cat(C(0, 1 - drop), product).as_signed()
