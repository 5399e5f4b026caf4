"""A memory of sums: adds a value at an address in every cycle; later reads all sums in order and clears them."""

from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

from amaranth import Module, Mux, Signal, Value, unsigned
from amaranth.lib import data

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


class Accumulator:
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
        m: the module that it is a part of.
        total: layout of the sums: fields long enough for every sum.
        entries: number of addresses.
        banks: 1, or 2 for even and odd addresses, which are read together.
        address: of the addition, 0 ... ``entries - 1``.
        value: the addend: unsigned fields, each with its own sum.
        valid: there is an addition in this cycle.
        drain: a pulse, after the last addition; the next one may come two cycles after the last row's read.

    Resources: a memory of ``entries`` sums, an adder for each field, four comparators of addresses.
    """

    def __init__(
        self,
        m: Module,
        total: data.StructLayout,
        entries: int,
        banks: int,
        *,
        address: Value,
        value: Mapping[str, Value],
        valid: Value,
        drain: Value,
    ) -> None:
        self._total, self._banks, self._depth = total, banks, -(-entries // banks)
        self._address, self._valid = address, valid
        self.draining = Signal(init=1)
        """Rows are read, from ``DRAIN`` cycles after ``drain`` on."""
        self.rows: list[data.View] = []
        """The sums of a row, ``READ`` cycles after its read; the lower address first."""
        row = self._drain(m, drain)
        flight = self._flight(m)
        total_sum = Signal(total, name="sum", reset_less=True)
        word = self._memories(m, row, flight, total_sum.as_value())
        before = data.View(total, self._before(m, flight, word, total_sum.as_value()))
        for field, _ in total:
            late = delayed(m, value[field], _STAGES.index("stored"), f"value_{field}")
            m.d.sync += total_sum[field].eq(before[field] + late)
        with m.If(self.draining):  # the zero that clears the row which is read now
            m.d.sync += total_sum.as_value().eq(0)

    def _drain(self, m: Module, drain: Value) -> Signal:
        """The row that is read while ``draining``."""
        last = self._depth - 1
        row = Signal(counter_shape(last))
        begin = delayed(m, drain, DRAIN - 1, "drain_waits", control=True)
        with m.If(self.draining):
            m.d.sync += self.draining.eq(row != last)
            m.d.sync += row.eq(Mux(row == last, 0, row + 1))
        with m.If(begin):
            m.d.sync += self.draining.eq(1)
        return row

    def _flight(self, m: Module) -> dict[str, _Addition]:
        """The addition in each stage."""
        flight = {"port": _Addition(self._address, self._valid)}
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
            read = memory.read(Mux(self.draining, row, self._address >> bank_bits))
            words.append(register(m, read, f"word{bank}"))
            self.rows.append(data.View(self._total, words[bank]))
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
