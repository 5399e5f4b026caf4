"""A memory of sums: adds a value at an address in every cycle; later reads all sums in order and clears them."""

from itertools import pairwise
from typing import Any, NamedTuple

from amaranth import Module, Mux, Signal, Value, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.ram import Ram

_STAGES = ("port", "read", "word", "stored", "sum")
"""Stages of an addition, one a cycle: the register that holds its word."""

DRAIN = len(_STAGES) - 1
"""Cycles from ``drain`` to the first read: the sum of an addition in the cycle before has been written then."""


class _Addition(NamedTuple):
    """Address of the addition in a stage, and whether there is one."""

    address: Value
    valid: Value


class Accumulator(wiring.Component):
    """``sum[address] += value`` in every cycle, back to back to the same address too; later all sums in order.

    ::

        address ─▶ memory ─▶ word ──▶ stored ─▶ + ─▶ sum ─▶ memory
                               ▲         ▲      ▲     │
                               └─ passed ┴──────┴─────┘

    A sum is in the memory for additions five cycles later.  An earlier addition to the same address takes it from a
    register (forwarding), the latest of several sums:

    ====== ==================== =====================================================
    cycle  an addition          takes the sum of another one, to the same address
    ====== ==================== =====================================================
    0      reads the memory
    1      gets an answer       4 cycles before, from ``written``, or 3 cycles before,
                                from ``sum``: both into ``passed``
    2      is in ``word``       2 cycles before, from ``sum``: into ``stored``
    3      is in ``stored``     1 cycle before, from ``sum``: into the adder
    4      is in ``sum``, and
           writes the memory
    5      is in ``written``
    ====== ==================== =====================================================

    ``drain`` reads all sums, a row of ``banks`` sums a cycle, and clears each row in the cycle after its read.  A reset
    does the same, since a memory has no reset.

    Arguments:
        value: layout of the addends: unsigned fields, each with its own sum.
        total: layout of the sums: the same fields, long enough for every sum.
        entries: number of addresses.
        banks: 1, or 2 for even and odd addresses, which are read together.

    Resources: a memory of ``entries`` sums, an adder for each field, four comparators of addresses.
    """

    def __init__(self, value: data.StructLayout, total: data.StructLayout, entries: int, banks: int) -> None:
        self._total, self._banks, self._depth = total, banks, -(-entries // banks)
        super().__init__({
            "address": In(counter_shape(entries - 1)),  # of the addition, 0 ... ``entries - 1``
            "value": In(value),  # the addend
            "valid": In(1),  # there is an addition in this cycle
            # A pulse, after the last addition; the next one may come two cycles after the last row's read.
            "drain": In(1),
            "draining": Out(1, init=1),  # rows are read, from ``DRAIN`` cycles after ``drain`` on
            # The sums of a row, ``READ`` cycles after its read; the lower address first.
            "rows": Out(total).array(banks),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        row = self._drain(m)
        flight = self._flight(m)
        total = Signal(self._total, name="sum", reset_less=True)
        word = self._memories(m, row, flight, total.as_value())
        before = data.View(self._total, self._before(m, flight, word, total.as_value()))
        for field, _ in self._total:
            value = delayed(m, self.value[field], _STAGES.index("stored"), f"value_{field}")
            m.d.sync += total[field].eq(before[field] + value)
        with m.If(self.draining):  # the zero that clears the row which is read now
            m.d.sync += total.as_value().eq(0)
        return m

    def _drain(self, m: Module) -> Signal:
        """The row that is read while ``draining``."""
        last = self._depth - 1
        row = Signal(counter_shape(last))
        begin = delayed(m, self.drain, DRAIN - 1, "drain_waits", control=True)
        with m.If(self.draining):
            m.d.sync += self.draining.eq(row != last)
            m.d.sync += row.eq(Mux(row == last, 0, row + 1))
        with m.If(begin):
            m.d.sync += self.draining.eq(1)
        return row

    def _flight(self, m: Module) -> dict[str, _Addition]:
        """The addition in each stage."""
        flight = {"port": _Addition(self.address, self.valid)}
        for before, stage in pairwise(_STAGES):
            address, valid = flight[before]
            flight[stage] = _Addition(
                register(m, address, f"{stage}_address"), register(m, valid, f"{stage}_valid", control=True)
            )
        return flight

    def _memories(self, m: Module, row: Value, flight: dict[str, _Addition], total: Value) -> Value:
        """Read and write every bank; what the addition in stage ``word`` has read in its own."""
        bank_bits = self._banks - 1
        clear = register(m, self.draining, "clear", control=True)
        cleared = register(m, row, "cleared")
        written, words = flight["sum"], []
        address = Mux(clear, cleared, written.address >> bank_bits)
        for bank in range(self._banks):
            memory = Ram(m, f"bank{bank}", unsigned(len(total)), max(2, self._depth))  # ports need an address
            in_bank = written.valid & (written.address[0] == bank) if bank_bits else written.valid
            memory.write(clear | in_bank, address, total)
            read = memory.read(Mux(self.draining, row, self.address >> bank_bits))
            words.append(register(m, read, f"word{bank}"))
            m.d.comb += self.rows[bank].as_value().eq(words[bank])
        return Mux(flight["word"].address[0], words[1], words[0]) if bank_bits else words[0]

    def _before(self, m: Module, flight: dict[str, _Addition], word: Value, total: Value) -> Value:
        """The sum that the addition in stage ``stored`` adds to: from the memory, or forwarded."""
        same = {}  # registers, in stage ``read``: the addition that far before went to the same address
        address, valid = flight["port"]
        for distance, stage in enumerate(_STAGES[1:], 1):
            other = flight[stage]
            same[distance] = register(m, valid & other.valid & (other.address == address), f"same{distance}")
        written = register(m, total, "written")
        passed = register(m, Mux(same[3], total, written), "passed")
        use_passed = register(m, same[3] | same[4], "use_passed")
        use_sum = delayed(m, same[2], 1, "use_sum")
        stored = register(m, Mux(use_sum, total, Mux(use_passed, passed, word)), "stored")
        return Mux(delayed(m, same[1], 2, "use_latest"), total, stored)
