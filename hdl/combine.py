"""Vector updates ``z + s * x`` (Eqs. 7, 8, 10): residuals of the candidates, weights of the forces."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from amaranth import Array, C, Cat, Module, Mux, Shape, Signal, Value
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count, leading_zeros, magnitude_bits, quad, round_top
from tfra.hdl.payloads import affine, chosen, direction, vector_quad
from tfra.model.design import Design
from tfra.model.fixed.scalars import scalar_fraction
from tfra.model.fixed.widths import widths

_SUM = 7
"""Stages of the pipeline; the register of the last one is the sum."""


class Slot(IntEnum):
    """Places of the two operand memories: x operands (n, d1, d2, e1) and z operands (d0, d1, d2, e0)."""

    FIRST = 0
    D1 = 1
    D2 = 2
    LAST = 3


class Job(IntEnum):
    """What the unit computes, in order; bit 2 marks planes of forces, whose z comes in as a stream."""

    E0 = 0
    E1 = 1
    D = 2
    FX = 4
    FY = 5
    FZ = 6


class Step(IntEnum):
    """What is loaded, in order."""

    B = 0
    N = 1
    G = 2
    D1 = 3
    D2 = 4


class Combine(wiring.Component):
    """The one unit for ``z + s * x``; the model is :func:`tfra.model.fixed.combine.combine`, four words at a time.

    ::

        e0 = d0 + alpha d_dep,  d0 = b + g     e1 = d_ind + beta d_dep     d = e0 + mu_ind e1
        f_x = A1-dagger d + mu_x n             f_y = A2-dagger d + mu_y n  f_z = A3-dagger d - n

        x memory -> register -> align -> round -> x s -> shift -> + z     z: z memory -> register, or ``products``
            1          2          3        4       5       6       7         (one register each)

    x enters as a multiplier operand, moved left by the bits that its parity leaves free; these are found while x
    is written.  Results e0 and e1 return to the memories as they leave.  One quad per cycle, four multipliers of
    operand x operand bits, two memories of 4 slots x Q quads with one port to read and one to write.

    A frame is loaded in the order b, n, g, d1, d2.  The b of the next frame is taken as soon as e1 has left, its
    n once the forces have left.

    Members:
        b: Q quads a frame, folded stress in converter codes.
        n: Q quads a frame, folded weights.
        residual: 3 Q quads a frame: g, d1, d2.
        direction: one transfer a frame, taken with the last e1.
        affine: one transfer a frame, taken with the last e1.
        chosen: one transfer a frame, taken with the last f_z.
        products: 3 Q quads a frame: A1-dagger d, A2-dagger d, A3-dagger d.
        vector: 3 Q quads a frame: e0, e1, d.
        forces: 3 Q quads a frame: folded f_x, f_y, f_z.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = stream.Signature(vector_quad(design))
        super().__init__(
            {
                "b": In(stream.Signature(quad(design.adc.bits + 2))),
                "n": In(vector),
                "residual": In(vector),
                "direction": In(stream.Signature(direction(design))),
                "affine": In(stream.Signature(affine(design))),
                "chosen": In(stream.Signature(chosen(design))),
                "products": In(vector),
                "vector": Out(vector),
                "forces": Out(vector),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the last transfer of ``residual`` to the first of ``vector``, e0.

        ``affine`` and ``direction`` are held by their senders; when one comes later, cycles count from the first
        clock edge that finds both valid.
        """
        return 2 + _SUM

    @property
    def update_latency(self) -> int:
        """Cycles from the first clock edge that finds ``chosen`` valid to the first transfer of d.

        When the last e1 leaves later than that, cycles count from its transfer.
        """
        return 2 + _SUM

    @property
    def force_latency(self) -> int:
        """Cycles from a transfer of ``products`` to the transfer of its quad of ``forces``; d has left before."""
        return 1

    @property
    def job_cycles(self) -> int:
        """Cycles from the first quad of a vector to the first of the next when nothing stalls: e0 to e1, f_x to f_y."""
        return self._design.quads

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        w = _Wires(self._design)
        self._load(m, w)
        self._write(m, w)
        self._headroom(m, w)
        self._sequence(m, w)
        self._flow(m, w)
        self._fetch(m, w)
        self._multiply(m, w)
        self._add(m, w)
        return m

    def _load(self, m: Module, w: _Wires) -> None:
        """Take b, n, g, d1 and d2 in turn, each when its slot is free."""
        top = self._design.quads - 1
        last = w.load_number == top
        m.d.comb += [
            self.b.ready.eq((w.step == Step.B) & ~w.busy),
            self.n.ready.eq((w.step == Step.N) & w.idle),
            self.residual.ready.eq(w.step >= Step.G),
            w.load.eq(
                (self.b.valid & self.b.ready)
                | (self.n.valid & self.n.ready)
                | (self.residual.valid & self.residual.ready)
            ),
        ]
        with m.If(w.sent):
            m.d.sync += w.busy.eq(0)
        with m.If(w.load):
            m.d.sync += [w.load_number.eq(Mux(last, 0, w.load_number + 1)), w.step.eq(w.step + last)]
            with m.If(last & (w.step == Step.D2)):
                m.d.sync += [w.step.eq(Step.B), w.busy.eq(1)]

    def _write(self, m: Module, w: _Wires) -> None:
        """One register for all that is written.

        A result is written for as long as it waits for its receiver: the same words to the same address.
        """
        result = w.valid[_SUM] & ((w.tag[_SUM].job == Job.E0) | (w.tag[_SUM].job == Job.E1))
        to_e1 = w.tag[_SUM].job[0]
        step, put = w.step, w.put
        m.d.sync += [
            w.put_x.eq(Mux(result, to_e1, w.load & (step != Step.B) & (step != Step.G))),
            w.put_z.eq(Mux(result, ~to_e1, w.load & (step != Step.N))),
            put.add.eq(~result & (step == Step.G)),
            put.number.eq(Mux(result, w.tag[_SUM].number, w.load_number)),
        ]
        with m.If(result):
            m.d.sync += [put.slot.eq(Slot.LAST), put.words.eq(w.sum)]
        with m.Else():
            with m.Switch(step):
                with m.Case(Step.B):
                    for k in range(4):
                        m.d.sync += put.words[k].eq(self.b.payload[k] << self._design.formats.vector_fraction)
                with m.Case(Step.N):
                    m.d.sync += put.words.eq(self.n.payload)
                with m.Default():
                    m.d.sync += put.words.eq(self.residual.payload)
            m.d.sync += put.slot.eq(Mux(step == Step.D1, Slot.D1, Mux(step == Step.D2, Slot.D2, Slot.FIRST)))

    def _headroom(self, m: Module, w: _Wires) -> None:
        """Bits that each parity of an x slot leaves free: OR while it is written, zeros behind its last quad."""
        bits = widths(self._design).vector - 1
        masks = Signal(data.ArrayLayout(bits, 4), reset_less=True)
        done, slot = Signal(), Signal(2, reset_less=True)
        m.d.sync += [done.eq(w.put_x & (w.put.number == self._design.quads - 1)), slot.eq(w.put.slot)]
        with m.If(w.put_x):
            for k in range(4):
                before = Mux(w.put.number == 0, 0, masks[k])
                m.d.sync += masks[k].eq(before | magnitude_bits(w.put.words[k]))
        with m.If(done), m.Switch(slot):
            for number, headroom in enumerate(w.headroom):
                with m.Case(number):
                    m.d.sync += [headroom[k].eq(leading_zeros(masks[k])) for k in range(4)]

    def _sequence(self, m: Module, w: _Wires) -> None:
        """Which quad of which job enters the pipeline."""
        facts, update, last = Signal(), Signal(), Signal()
        job, number = w.tag[0].job, w.tag[0].number
        m.d.sync += [
            facts.eq(self.affine.valid & self.direction.valid & ~w.sent),
            update.eq(self.chosen.valid & ~w.finished),
        ]
        m.d.comb += [
            last.eq(w.valid[0] & w.move & (number == self._design.quads - 1)),
            w.tag[0].last.eq(number == self._design.quads - 1),
        ]
        with m.If(w.valid[0] & w.move):
            m.d.sync += number.eq(Mux(last, 0, number + 1))
        with m.FSM():
            with m.State("load"):
                m.d.comb += w.idle.eq(1)
                with m.If(w.busy & facts):
                    m.d.sync += job.eq(Job.E0)
                    m.next = "candidates"
            with m.State("candidates"):
                m.d.comb += w.valid[0].eq(1)
                with m.If(last):
                    m.d.sync += job.eq(Job.E1)
                    with m.If(job == Job.E1):
                        m.next = "search"
            with m.State("search"), m.If(~w.busy & update):
                m.d.sync += job.eq(Job.D)
                m.next = "forces"
            with m.State("forces"):
                m.d.comb += w.valid[0].eq(1)
                with m.If(last):
                    m.d.sync += job.eq(Mux(job == Job.D, Job.FX, job + 1))
                    with m.If(job == Job.FZ):
                        m.next = "drain"
            with m.State("drain"), m.If(w.finished):
                m.next = "load"

    def _flow(self, m: Module, w: _Wires) -> None:
        """Valid bits: the last stage waits for its receiver, those before it for ``products`` too."""
        tag, valid = w.tag[_SUM], w.valid[_SUM]
        before, streamed, ready = w.tag[_SUM - 1].job[2], Signal(), Signal()
        m.d.comb += [
            self.vector.valid.eq(valid & ~tag.job[2]),
            self.forces.valid.eq(valid & tag.job[2]),
            w.leave.eq(~valid | Mux(tag.job[2], self.forces.ready, self.vector.ready)),
            streamed.eq(w.valid[_SUM - 1] & before),
            ready.eq(~before | self.products.valid),
            w.move.eq(~w.valid[_SUM - 1] | (w.leave & ready)),
            self.products.ready.eq(streamed & w.leave),
            w.sent.eq(self.vector.valid & self.vector.ready & tag.last & (tag.job == Job.E1)),
            w.finished.eq(self.forces.valid & self.forces.ready & tag.last & (tag.job == Job.FZ)),
            self.affine.ready.eq(w.sent),
            self.direction.ready.eq(w.sent),
            self.chosen.ready.eq(w.finished),
        ]
        with m.If(w.move):
            for k in range(1, _SUM):
                m.d.sync += [w.valid[k].eq(w.valid[k - 1]), w.tag[k].eq(w.tag[k - 1])]
        with m.If(w.leave):
            m.d.sync += [w.valid[_SUM].eq(w.valid[_SUM - 1] & ready), w.tag[_SUM].eq(w.tag[_SUM - 1])]

    def _fetch(self, m: Module, w: _Wires) -> None:
        """The two memories; z is read late, so that it comes to the adder with its product."""
        shape, width = vector_quad(self._design), len(w.load_number)
        m.submodules.x = xs = memory.Memory(shape=shape, depth=4 << width, init=[])
        m.submodules.z = zs = memory.Memory(shape=shape, depth=4 << width, init=[])
        x_write, z_write = xs.write_port(), zs.write_port()
        # A single quad's b is still on its way into the memory when its g asks for it.
        x_read, z_read = xs.read_port(), zs.read_port(transparent_for=[z_write] if self._design.quads == 1 else [])
        swap, late = self.direction.payload.sweep_y, w.tag[_SUM - 3]
        x_slot = _x_slot(w.tag[0].job, swap)
        z_slot = Mux(late.job == Job.E1, Mux(swap, Slot.D2, Slot.D1), Mux(late.job == Job.E0, Slot.FIRST, Slot.LAST))
        sums = Signal(shape, reset_less=True)
        loading = w.step == Step.G
        m.d.comb += [
            x_read.addr.eq(Cat(w.tag[0].number, x_slot)),
            x_read.en.eq(w.move),
            x_write.addr.eq(Cat(w.put.number, w.put.slot)),
            x_write.data.eq(w.put.words),
            x_write.en.eq(w.put_x),
            z_read.addr.eq(Mux(loading, Cat(w.load_number, C(Slot.FIRST, 2)), Cat(late.number, z_slot))),
            z_read.en.eq(w.move),
            z_write.data.eq(sums),
        ]
        m.d.sync += [z_write.addr.eq(Cat(w.put.number, w.put.slot)), z_write.en.eq(w.put_z)]
        for k in range(4):
            m.d.sync += sums[k].eq(w.put.words[k] + Mux(w.put.add, z_read.data[k], 0))
        with m.If(w.move):
            m.d.sync += [w.x.eq(x_read.data), w.z.eq(z_read.data)]

    def _multiply(self, m: Module, w: _Wires) -> None:
        """Align x by its headroom, round it to an operand, multiply, and shift back by the headroom."""
        fmt, bits = self._design.formats, widths(self._design).vector
        drop = scalar_fraction(self._design) + fmt.operand - bits
        rooms = data.ArrayLayout(count(bits - 1), 4)
        room = {k: Signal(rooms, name=f"room{k}", reset_less=True) for k in range(2, _SUM - 1)}
        aligned = Signal(quad(bits), reset_less=True)
        words, scalar = Signal(quad(fmt.operand), reset_less=True), Signal(Shape(fmt.operand, True), reset_less=True)
        product = Signal(quad(2 * fmt.operand), reset_less=True)
        slot = _x_slot(w.tag[1].job, self.direction.payload.sweep_y)
        with m.If(w.move):
            m.d.sync += [room[k].eq(room[k - 1]) for k in range(3, _SUM - 1)]
            m.d.sync += scalar.eq(self._scalar(w.tag[3].job))
            for k in range(4):
                m.d.sync += [
                    room[2][k].eq(Array(h[k] for h in w.headroom)[slot]),
                    aligned[k].eq(w.x[k] << room[2][k]),
                    words[k].eq(round_top(aligned[k], fmt.operand)),
                    product[k].eq(words[k] * scalar),
                    w.shifted[k].eq(_drop(product[k], drop) >> room[5][k]),
                ]

    def _scalar(self, job: Value) -> Value:
        """s of a job."""
        minus_one = C(-1 << scalar_fraction(self._design), Shape(self._design.formats.operand, True))
        a, c = self.affine.payload, self.chosen.payload
        return Array([a.alpha, a.beta, c.mu_ind, minus_one, c.mu_x, c.mu_y, minus_one, minus_one])[job]

    def _add(self, m: Module, w: _Wires) -> None:
        """``z + round_half(shifted)`` in one adder: ``(2 z + 1 + shifted) >> 1``."""
        streamed = w.tag[_SUM - 1].job[2]
        with m.If(w.leave):
            for k in range(4):
                z = Mux(streamed, self.products.payload[k], w.z[k])
                m.d.sync += w.sum[k].eq((Cat(1, z).as_signed() + w.shifted[k]) >> 1)
        m.d.comb += [self.vector.payload.eq(w.sum), self.forces.payload.eq(w.sum)]


class _Wires:
    """Signals that the parts of the unit share; ``valid[k]`` and ``tag[k]`` stand beside the register of stage k."""

    def __init__(self, design: Design) -> None:
        bits, number = widths(design).vector, count(design.quads - 1)
        tag = data.StructLayout({"job": 3, "number": number, "last": 1})
        put = data.StructLayout({"words": vector_quad(design), "slot": 2, "number": number, "add": 1})
        self.step, self.load_number, self.load = Signal(3), Signal(number), Signal()
        self.busy = Signal()
        """All is loaded, and e1 has not left yet."""
        self.idle = Signal()
        """No job of this frame has begun, and none of the frame before is left."""
        self.sent, self.finished = Signal(), Signal()
        """The last e1 leaves, the last f_z leaves."""
        self.move, self.leave = Signal(), Signal()
        """Stages 1 to 6 advance; the sum advances."""
        self.valid = [Signal(name=f"valid{k}") for k in range(_SUM + 1)]
        self.tag = [Signal(tag, name=f"tag{k}", reset_less=k > 0) for k in range(_SUM + 1)]
        self.put, self.put_x, self.put_z = Signal(put, reset_less=True), Signal(), Signal()
        rooms = data.ArrayLayout(count(bits - 1), 4)
        self.headroom = [Signal(rooms, name=f"headroom{k}", reset_less=True) for k in range(4)]
        self.x, self.z = Signal(quad(bits), reset_less=True), Signal(quad(bits), reset_less=True)
        self.shifted, self.sum = Signal(quad(bits + 1), reset_less=True), Signal(quad(bits), reset_less=True)


def _x_slot(job: Value, swap: Value) -> Value:
    """Slot of a job's x: d_dep for the candidates, e1 for d, n for the forces."""
    return Mux(job[2], Slot.FIRST, Mux(job == Job.D, Slot.LAST, Mux(swap, Slot.D1, Slot.D2)))


def _drop(product: Value, drop: int) -> Value:
    """``product / 2^drop`` with one bit below the point; what is left to shift is the headroom of x.

    The bits cut off can't reach the rounding; vectors longer than operands make ``drop`` negative.
    """
    return product[drop - 1 :].as_signed() if drop > 0 else Cat(C(0, 1 - drop), product).as_signed()
