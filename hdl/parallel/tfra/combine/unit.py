"""Vector updates ``z + s * x`` (Eqs. 7, 8, 10): residuals of the candidates, weights of the forces."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import quad
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.streams import TOKEN, Tokens, always_ready_stream
from tfra.hdl.parallel.beats import beat_in_quad
from tfra.hdl.parallel.payloads import affine, chosen, direction, operand, vector_quad
from tfra.hdl.parallel.scale_add import ScaleAdd, Stage, staged
from tfra.hdl.parallel.tfra.combine.arbiter import Arbiter
from tfra.hdl.parallel.tfra.combine.loader import load_residuals, load_weights
from tfra.hdl.parallel.tfra.combine.operands import ProductBeats, addend, multiplicand, product_beats
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE, Job, Store
from tfra.model.fixed.design import Design


class Combine(wiring.Component):
    """The one unit for ``z + s * x``; the model is :func:`tfra.model.fixed.combine.combine`, W words at a time.

    ::

        e0 = d0 + alpha d_dep,  d0 = b + g     e1 = d_ind + beta d_dep     d = e0 + mu_ind e1
        f_x = A1-dagger d + mu_x n             f_y = A2-dagger d + mu_y n  f_z = A3-dagger d - n

        b, residual, n -> loaders -> stores of x -> multiplicand -.
                                     stores of z -> addend -------+-> ScaleAdd -> quads -> vector, forces
        products -> product_beats -> Arbiter: which beat enters --'      '-> e0, e1 back to the stores

    x enters as a multiplier operand, shifted left by the headroom of its parity, which is determined while x is
    written.  A quad takes ``design.cycles_per_quad`` cycles; there are W = ``vector_words`` multipliers of operand x
    operand bits.

    Nothing in the pipeline waits: a vector begins when a ``bank_token`` reserves a bank of its receiver.
    ``FRAMES`` frames have a place each in the stores; the sender of a frame's data holds its token.

    e0 leaves ``MEASURE + cycles_per_quad + force_latency`` cycles after the last beat of ``residual``, or three less
    after the clock edge that finds the last of its facts valid; d ``cycles_per_quad + 1 + force_latency`` after that
    which finds ``chosen`` valid, or after the second cycle from the transfer of the last e1.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = always_ready_stream(vector_quad(design))
        super().__init__({
            # Q quads a frame, folded stress in converter codes; of one frame more than those that hold a token.
            "b": In(always_ready_stream(quad(design.adc.bits + 2))),
            "n": In(vector),  # Q quads a frame, folded weights
            "residual": In(vector),  # 3 Q quads a frame, after its b: g, d1, d2
            # One transfer a frame, taken a cycle after the entry of the last beat of e1.
            "direction": In(stream.Signature(direction(design))),
            "affine": In(stream.Signature(affine(design))),  # one transfer a frame, taken with ``direction``
            # One transfer a frame, taken a cycle after the entry of the last beat of d.
            "chosen": In(stream.Signature(chosen(design))),
            # The same, taken when the forces of the previous frame have entered.
            "forced": In(stream.Signature(chosen(design))),
            # 3 Q quads a frame, after its n and ``forced``: A1-dagger d, A2-dagger d, A3-dagger d.
            "products": In(vector),
            "bank_token": In(stream.Signature(TOKEN)),  # one taken for each vector
            # One for each frame that has a place in the stores; its forces return it.
            "frame_token": Out(stream.Signature(TOKEN)),
            "vector": Out(always_ready_stream(operand(design, "force"))),  # 3 Q quads a frame: e0, e1, and later d
            "forces": Out(vector),  # 3 Q quads a frame: folded f_x, f_y, f_z
        })

    @property
    def force_latency(self) -> int:
        """Cycles from the last beat of a quad of ``products`` to the transfer of its quad of ``forces``."""
        return Stage.OUTPUT - Stage.ENTRY

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design = self._design
        m.submodules.n = n = Store(design, headroom=True)
        m.submodules.x_residual = x_residual = Store(design, 2, headroom=True)
        m.submodules.z_residual = z_residual = Store(design, 3)
        m.submodules.e0 = e0 = Store(design)
        m.submodules.e1 = e1 = Store(design, headroom=True)
        m.submodules.arbiter = arbiter = Arbiter(design)
        load_weights(m, design, self.n, n.write)
        stored = load_residuals(m, design, self.b, self.residual, x_residual.write, z_residual.write)
        m.d.comb += arbiter.residual_stored.eq(stored)
        products = product_beats(m, design, self.products, self.forced)
        self._enter(m, products, arbiter)
        valid = staged(m, arbiter.valid, Stage.ENTRY, Stage.SUM, "valid", control=True)
        tag = staged(m, arbiter.tag, Stage.ENTRY, Stage.SUM, "tag")
        with m.If(tag[Stage.X_ADDRESS].job == Job.FORCE):
            m.d.sync += tag[Stage.X_CELL].scalar.eq(products.scalar)
        x, headroom = multiplicand(m, n, x_residual, e1, tag)
        m.submodules.scale_add = scale_add = ScaleAdd(design, design.architecture.vector_words, design.widths.vector)
        m.d.comb += [
            scale_add.x.eq(x),
            scale_add.headroom.eq(headroom),
            scale_add.scalar.eq(tag[Stage.ROUNDED].scalar),
            scale_add.z.eq(addend(m, design, z_residual, e0, products.words, tag)),
        ]
        self._write_back(m, tag, valid, scale_add.sum, {Job.E0: e0.write, Job.E1: e1.write})
        self._announce_e1(m, tag[Stage.SUM], valid[Stage.SUM], arbiter)
        self._send(m, tag[Stage.SUM], valid[Stage.SUM], scale_add.sum)
        return m

    def _enter(self, m: Module, products: ProductBeats, arbiter: Arbiter) -> None:
        """The arbiter's candidates, and the tokens of the frames whose products have entered."""
        for name in ("direction", "affine", "chosen", "bank_token"):
            wiring.connect(m, wiring.flipped(getattr(self, name)), getattr(arbiter, name))
        m.submodules.frame_tokens = frame_tokens = Tokens(FRAMES)
        wiring.connect(m, frame_tokens.o, wiring.flipped(self.frame_token))
        m.d.comb += [
            frame_tokens.give.eq(products.frame_done),
            arbiter.product_valid.eq(products.valid),
            arbiter.product_place.eq(products.place),
            arbiter.product_number.eq(products.number),
        ]

    def _write_back(
        self, m: Module, tag: dict[Stage, Any], valid: dict[Stage, Any], words: Any, stores: dict[Job, Any]
    ) -> None:
        """Sums that are e0 and e1 go to the stores that d reads."""
        for job, write in stores.items():
            is_next = valid[Stage.SHIFTED] & (tag[Stage.SHIFTED].job == job)
            m.d.comb += [
                write.valid.eq(register(m, is_next, f"is_{job.name.lower()}", control=True)),
                write.place.eq(tag[Stage.SUM].place),
                write.number.eq(tag[Stage.SUM].number),
                write.words.eq(words),
            ]

    def _announce_e1(self, m: Module, tag: Any, valid: Any, arbiter: Arbiter) -> None:
        """d may be begun when the headroom of e1 can be read."""
        last = self._design.quads * self._design.cycles_per_quad - 1
        ends = valid & (tag.job == Job.E1) & (tag.number == last)
        m.d.comb += arbiter.e1_stored.eq(delayed(m, ends, MEASURE - 1, "e1_stored", control=True))

    def _send(self, m: Module, tag: Any, valid: Any, beat: Any) -> None:
        """Quads, a cycle after their last beat; beats of a force's quad may come between those of a vector's."""
        is_force = tag.job == Job.FORCE
        whole = valid & (beat_in_quad(self._design, tag.number) == self._design.cycles_per_quad - 1)
        words = register(m, self._quad(m, valid, is_force, beat.as_value()), "words")
        m.d.comb += [
            self.vector.valid.eq(register(m, whole & ~is_force, "vector_valid", control=True)),
            self.vector.payload.words.eq(words),
            self.vector.payload.force.eq(register(m, tag.job == Job.D, "is_d")),
            self.forces.valid.eq(register(m, whole & is_force, "forces_valid", control=True)),
            self.forces.payload.eq(words),
        ]

    def _quad(self, m: Module, valid: Value, is_force: Value, latest: Value) -> Value:
        """The beat after those of its quad that came before it."""
        if self._design.cycles_per_quad == 1:
            return latest
        earlier = {}
        for name, mine in (("vector", ~is_force), ("force", is_force)):
            beats = Signal((self._design.cycles_per_quad - 1) * len(latest), name=f"{name}_beats", reset_less=True)
            with m.If(valid & mine):
                m.d.sync += beats.eq(Cat(beats, latest)[len(latest) :])
            earlier[name] = beats
        return Cat(Mux(is_force, earlier["force"], earlier["vector"]), latest)
