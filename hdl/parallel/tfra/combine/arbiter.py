"""Arbiter of the vector updates: the next vector, and the beat that enters the pipeline in each cycle."""

from typing import Any

from amaranth import Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import occupancy, register, wrapping_counter
from tfra.hdl.lib.streams import TOKEN
from tfra.hdl.parallel.beats import beat_number
from tfra.hdl.parallel.payloads import affine, chosen, direction
from tfra.hdl.parallel.tfra.combine.store import FRAMES, Job, place, tag_layout
from tfra.model.fixed.design import Design


class _Waiting:
    """Frames that wait: from a pulse of ``enter`` until one of ``leave``, in the order of their places.

    ``some``: there is one; ``oldest``: place of the next to leave.  At most ``FRAMES`` frames hold a token, so they are
    never too many.
    """

    def __init__(self, m: Module, enter: Value, name: str) -> None:
        self.leave = Signal(name=f"{name}_leaves")
        self.some = occupancy(m, FRAMES, enter, self.leave)[0]
        self.oldest, _ = wrapping_counter(m, self.leave, FRAMES, f"oldest_{name}")


class Arbiter(wiring.Component):
    """A beat of products enters in the cycle in which it arrives; in other cycles a beat of the current vector enters.

    A vector begins when all its inputs are available and a bank is free for it.  d goes before e0, so that the older of
    two frames goes first; e1 follows e0.

    ============  ========  =========  ==================================================
    state         ``busy``  ``final``  a cycle without a beat of products
    ============  ========  =========  ==================================================
    idle          0         any        begins d, or else e0 or e1, if it may
    in hand       1         0          the vector's next beat enters
    last in hand  1         1          the vector's last beat enters; idle follows
    ============  ========  =========  ==================================================

    An idle arbiter begins a vector in a cycle with a beat of products, too.  Its first beat enters two cycles after the
    first clock edge that finds the last of its facts, or of the vector before with a cycle between them.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self._last_number = design.quads * design.cycles_per_quad - 1
        super().__init__({
            "residual_stored": In(1),  # pulse, d0, d1 and d2 of a frame can be read
            "e1_stored": In(1),  # pulse, e1 of a frame, and so its e0, can be read
            "product_valid": In(1),  # a beat of products enters
            "product_place": In(place),  # place of its frame
            "product_number": In(beat_number(design)),  # its number in its product
            # One transfer a frame, taken a cycle after the entry of the last beat of e1.
            "direction": In(stream.Signature(direction(design))),
            "affine": In(stream.Signature(affine(design))),  # one transfer a frame, taken with ``direction``
            # One transfer a frame, taken a cycle after the entry of the last beat of d.
            "chosen": In(stream.Signature(chosen(design))),
            "bank_token": In(stream.Signature(TOKEN)),  # one taken for each vector
            "valid": Out(1),  # a beat enters
            "tag": Out(tag_layout(design)),  # that of the beat; without the scalar, if it is one of products
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        residuals = _Waiting(m, self.residual_stored, "residual")
        candidates = _Waiting(m, self.e1_stored, "candidate")
        busy = Signal()
        final = Signal()
        beat = Signal(tag_layout(self._design), reset_less=True)  # the next one of the current vector
        step = Signal()
        m.d.comb += [
            step.eq(busy & ~self.product_valid),
            self.valid.eq(self.product_valid | busy),
        ]
        self._enter(m, beat)
        begin_d, begin_e = self._may_begin(m, residuals, candidates, beat.job, step & final)
        with m.If(step):
            m.d.sync += [
                beat.number.eq(beat.number + 1),
                final.eq(beat.number == self._last_number - 1),
                busy.eq(~final),
            ]
        # TIMING: facts -> tokens; until then the arbiter is busy
        take_token = register(m, ~busy & self.bank_token.valid & (begin_d | begin_e), "take_token", control=True)
        m.d.comb += self.bank_token.ready.eq(take_token)
        with m.If(~busy & self.bank_token.valid):
            m.d.sync += busy.eq(begin_d | begin_e)
            m.d.sync += beat.number.eq(0)
            m.d.sync += final.eq(self._last_number == 0)
            self._begin(m, beat, begin_d, begin_e, residuals.oldest, candidates.oldest)
        return m

    def _enter(self, m: Module, beat: Any) -> None:
        with m.If(self.product_valid):
            m.d.comb += [
                self.tag.job.eq(Job.FORCE),
                self.tag.place.eq(self.product_place),
                self.tag.number.eq(self.product_number),
            ]
        with m.Else():
            m.d.comb += self.tag.eq(beat)

    def _may_begin(
        self, m: Module, residuals: _Waiting, candidates: _Waiting, job: Value, enters_last: Value
    ) -> tuple[Value, Value]:
        """Whether the oldest frame's d may be begun, and whether a frame's e0 or e1; facts go with the last beat."""
        ends = Signal()
        candidate_facts = Signal()
        update_facts = Signal()
        # TIMING: arbiter -> queues of facts, and back
        m.d.sync += [
            residuals.leave.eq(ends & (job == Job.E1)),
            candidates.leave.eq(ends & (job == Job.D)),
            candidate_facts.eq(self.affine.valid & self.direction.valid & ~residuals.leave),
            update_facts.eq(self.chosen.valid & ~candidates.leave),
        ]
        m.d.comb += [
            ends.eq(enters_last),
            self.affine.ready.eq(residuals.leave),
            self.direction.ready.eq(residuals.leave),
            self.chosen.ready.eq(candidates.leave),
        ]
        begin_d = update_facts & candidates.some & ~candidates.leave
        begin_e = candidate_facts & residuals.some & ~residuals.leave
        return begin_d, begin_e

    def _begin(
        self, m: Module, beat: Any, begin_d: Value, begin_e: Value, residual_place: Value, candidate_place: Value
    ) -> None:
        """The tag of the vector with the highest priority."""
        second = Signal()  # e0 was begun: e1 is next
        with m.If(begin_d):
            m.d.sync += [
                beat.job.eq(Job.D),
                beat.place.eq(candidate_place),
                beat.scalar.eq(self.chosen.payload.mu_ind),
            ]
        with m.Elif(begin_e):
            m.d.sync += [
                second.eq(~second),
                beat.job.eq(Mux(second, Job.E1, Job.E0)),
                beat.place.eq(residual_place),
                beat.scalar.eq(Mux(second, self.affine.payload.beta, self.affine.payload.alpha)),
                beat.swap.eq(self.direction.payload.sweep_y),
            ]
