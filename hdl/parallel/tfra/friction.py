"""mu of the chosen candidate (Eqs. 17, 18, 26, 27), see :mod:`tfra.model.fixed.tfra.friction`."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_or_subtract, once, saturate
from tfra.hdl.lib.pipeline import driver, lookahead, register
from tfra.hdl.lib.streams import one_at_a_time
from tfra.hdl.parallel import payloads
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import mu_grid, scalar_fraction
from tfra.model.rounding import Rounding

# Cycles of the schedule; a register is loaded at the end of its cycle.
_ADDRESS, _READ, _MASK, _MULTIPLY, _ADD, _CHOOSE = range(6)


class Friction(wiring.Component):
    """mu_ind = +-k / K and mu_dep = alpha + beta mu_ind, saturated; mu_ind is zero where nothing is swept.

    ::

        index ─▶ K - index? ─▶ grid of k / K ─▶ x beta ─▶ alpha +- ─▶ saturate ─▶ chosen
                                    └────────────────────▶ +- ──────────┘

    The sign of mu_ind joins at the addition, whose other operand holds alpha and the half that rounds the product.

    ============= ==================================================================================
    ``_ADDRESS``  ``number``: place of |mu_ind| in the grid; index 0 is the smallest mu
    ``_READ``     the memory answers
    ``_MASK``     ``grid``: k / K, or zero
    ``_MULTIPLY`` ``product``: beta k / K; ``mu_ind`` is beside it
    ``_ADD``      ``total``: alpha + beta mu_ind
    ``_CHOOSE``   ``chosen``
    ============= ==================================================================================

    Resources: one multiplier, scalar x (two bits less, unsigned); K + 1 words of memory.
    """

    def __init__(self, design: Design) -> None:
        self.design = design
        super().__init__({
            # The winner, one transfer a frame; the next one is taken when ``chosen`` has left.
            "index": In(stream.Signature(payloads.sweep_index(design))),
            "direction": In(stream.Signature(payloads.direction(design))),  # fact of the frame, waited for
            "affine": In(stream.Signature(payloads.affine(design))),  # fact of the frame, waited for
            "frame": In(stream.Signature(payloads.frame_facts(design))),  # fact of the frame, waited for
            "chosen": Out(stream.Signature(payloads.chosen(design))),  # the result, one transfer a frame
        })

    @property
    def latency(self) -> int:
        """Cycles from the transfer of ``index``, the facts being there, to that of ``chosen``."""
        return 1 + _CHOOSE + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        index, mirrored = self._control(m)
        regular = self.frame.payload.contact & self.frame.payload.traction
        bits = self.design.formats.bits("scalar")
        grid = Signal(unsigned(bits - 2), reset_less=True)
        number = register(m, Mux(self.direction.payload.negative, mirrored, index), "number")
        m.d.sync += grid.eq(Mux(regular, self._grid(m, number), 0))
        mu_ind = Signal(signed(bits), reset_less=True)
        m.d.sync += mu_ind.eq(Mux(self.direction.payload.negative, -grid, grid))
        exact = self._exact(m, grid)
        chosen = driver(m, self.chosen.payload)
        with m.If(self.frame.ready):
            m.d.sync += chosen.index.eq(Mux(regular, index, 0))
            self._choose(m, chosen, mu_ind, exact)
        return m

    def _control(self, m: Module) -> tuple[Value, Value]:
        """Wait for index and facts, which are taken in the last cycle; the index, and K minus the index."""
        facts = (self.direction, self.affine, self.frame)
        cycle, busy = one_at_a_time(m, self.index, facts, self.chosen, _CHOOSE)
        index = Signal(payloads.sweep_index(self.design), reset_less=True)
        mirrored = Signal.like(index, name="mirrored")
        m.d.comb += [fact.ready.eq(lookahead(m, cycle, once(_CHOOSE))) for fact in facts]
        with m.If(~busy):
            m.d.sync += index.eq(self.index.payload)
            m.d.sync += mirrored.eq(self.design.search.steps - self.index.payload)
        return index, mirrored

    def _grid(self, m: Module, number: Value) -> Value:
        """|mu_ind|: index 0 is the smallest mu, so the negative side counts down."""
        words = [int(word) for word in mu_grid(self.design)]
        shape = unsigned(self.design.formats.bits("scalar") - 2)
        m.submodules.grid = memory = Memory(shape=shape, depth=len(words), init=words)
        port = memory.read_port()
        m.d.comb += port.addr.eq(number)
        return port.data

    def _exact(self, m: Module, grid: Value) -> Value:
        """alpha + beta mu_ind, rounded to a scalar's fraction, not yet saturated."""
        bits, fraction = self.design.formats.bits("scalar"), scalar_fraction(self.design)
        affine = self.affine.payload
        product = Signal(signed(2 * bits - 2), reset_less=True)
        total = Signal(signed(2 * bits - 1), reset_less=True)
        base = Cat(Const(Rounding.HALF_UP.constant(fraction), fraction), affine.alpha).as_signed()
        m.d.sync += [
            product.eq(affine.beta * grid),
            total.eq(add_or_subtract(base, product, self.direction.payload.negative)),
        ]
        return total[fraction:].as_signed()

    def _choose(self, m: Module, chosen: data.View, mu_ind: Value, exact: Value) -> None:
        """Both mu in the order of the axes."""
        one = 1 << scalar_fraction(self.design)
        mu_dep = saturate(exact, self.design.formats.bits("scalar"))
        sweep_y = self.direction.payload.sweep_y
        m.d.sync += [
            chosen.mu_ind.eq(mu_ind),
            chosen.mu_x.eq(Mux(sweep_y, mu_dep, mu_ind)),
            chosen.mu_y.eq(Mux(sweep_y, mu_ind, mu_dep)),
            chosen.out_of_range.eq((exact > one) | (exact < -one)),
        ]
