"""Facts and results of a frame, or the records of its contacts, become an output frame of 32-bit words."""

from typing import Any

from amaranth import Cat, Const, Module, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.ports import FACTS
from tfra.hdl.interface import ports
from tfra.hdl.ip.output_stage import RESULT_BEAT
from tfra.hdl.lib.pipeline import register, wrapping_counter
from tfra.hdl.lib.streams import PerFrameFifo
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import COUNTER_BITS, Field
from tfra.model.skin.records import header_bits, result_layout, result_shape
from tfra.model.skin.skin import Skin
from tfra.model.tfra import Status

HEADER_WORDS = 2
"""Words of an output frame before those of the core."""
FORMAT, RECORDS_FORMAT = 1, 2
"""Version of the output frame: of a core's result, and of the records of a skin."""
FRAMES, SKIN_FRAMES = 8, 16
"""Frames whose facts wait: at least as many as a core or a skin holds, or facts of frames behind them would be lost."""
TINY = 8
"""Most taxels of arrays with so few codes that the way into a core holds those of one more frame."""

FAULTS = {"saturation": 2, "sequence_gap": 5, "simulated": 7, "out_of_range": 8, "stuck": 9}
"""Bits of the flags in the second word, which are those of ERRORS."""

FORMAT_PLACE = 24
"""Lowest bit of the version in the second word, to the highest one."""


def check(array: Design | Skin) -> None:
    """Raise ``ValueError`` for result words that don't fit an output frame."""
    _, bits = result_shape(array)
    if bits > BITS:
        raise ValueError(f"formats: result words of {BITS} bits at most fit behind AXI, got {bits}")


def forces(array: Design | Skin) -> Field | None:
    """The forces at the taxels in the result or the record, if there are any."""
    return next((field for field in result_layout(array) if field.name.rpartition(".")[2] == "forces"), None)


def frames(array: Design | Skin) -> int:
    """Frames whose facts wait behind ``array``."""
    if isinstance(array, Skin):
        return SKIN_FRAMES
    return FRAMES + (array.sensor.taxels <= TINY)


def version(array: Design | Skin) -> int:
    """Version of the output frame."""
    return RECORDS_FORMAT if isinstance(array, Skin) else FORMAT


class Framer(wiring.Component):
    """Two words of facts, then the words of the result, extended by their sign.

    =========  ==========================================================================================
    SEQUENCE   sends the frame's sequence, and its number; decides whether it has the forces at the taxels
    FAULTS     sends the flags and the format
    FRAME      sends the number of the frame among those that leave; the core's counts bad frames, too
    WORDS      sends the other words of the core, or drops those of forces, or of a bad frame
    =========  ==========================================================================================

    A frame of a skin has FRAME and WORDS for each of its records.

    Raises ``ValueError`` for result words that don't fit.
    """

    def __init__(self, array: Design | Skin) -> None:
        check(array)
        field = forces(array)
        self._format, self._frames = version(array), frames(array)
        self._words, _ = result_shape(array)
        self._last = list(header_bits(array)).index("last") if isinstance(array, Skin) else None
        self._forces = range(0) if field is None else range(field.start, field.start + field.count)
        super().__init__({
            "facts": In(stream.Signature(FACTS)),  # one transfer a frame
            "result": In(stream.Signature(ports.result(array))),
            "taxel_forces": In(1),  # setting: frames have the forces at the taxels
            "o": Out(stream.Signature(RESULT_BEAT)),  # combinational from ``result``
            "saturated": Out(1),  # pulse: a result that has ended reports it, or its frame was
            "busy": Out(1),  # a frame is there
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.fifo = fifo = PerFrameFifo(FACTS, (), self._frames)
        wiring.connect(m, wiring.flipped(self.facts), fifo.i)
        facts, result, o = fifo.o.p, self.result, self.o
        with_forces = Signal(init=1)
        frame = Signal(COUNTER_BITS)
        record_ends = result.valid & result.ready & result.p.last
        forces = self._inside(m, result.valid & result.ready) if self._forces else Const(0)
        drop = facts.bad | (forces & ~with_forces)
        limited = (result.p.data & int(Status.INPUT_SATURATED | Status.OUTPUT_SATURATED)).any()
        last, ends, limited = self._records(m, record_ends, limited)
        saturated = ends & ~facts.bad & (facts.flags.saturation | limited)
        m.d.comb += [
            self.busy.eq(fifo.o.valid),
            o.p.started.eq(facts.started),
            self.saturated.eq(register(m, saturated, "saturated", control=True)),
        ]
        with m.FSM():
            with m.State("SEQUENCE"):
                m.d.comb += [
                    o.valid.eq(fifo.o.valid & ~facts.bad),
                    o.p.data.eq(Cat(facts.sequence, facts.user)),
                ]
                with m.If(o.valid & o.ready):
                    m.d.sync += with_forces.eq(self.taxel_forces)
                    m.next = "FAULTS"
                with m.If(fifo.o.valid & facts.bad):
                    m.next = "WORDS"
            with m.State("FAULTS"):
                m.d.comb += o.valid.eq(1)
                m.d.comb += o.p.data.eq(self._format << FORMAT_PLACE)
                m.d.comb += [o.p.data[bit].eq(facts.flags[name]) for name, bit in FAULTS.items()]
                with m.If(o.ready):
                    m.next = "FRAME"
            with m.State("FRAME"):
                m.d.comb += [
                    o.valid.eq(result.valid),
                    o.p.data.eq(frame),
                    result.ready.eq(o.ready),
                ]
                with m.If(result.valid & o.ready):
                    if self._last is None:  # other records of a skin's frame repeat the number
                        m.d.sync += frame.eq(frame + 1)
                    m.next = "WORDS"
            with m.State("WORDS"):
                m.d.comb += [
                    o.valid.eq(result.valid & ~drop),
                    o.p.data.eq(result.p.data),
                    o.p.last.eq(last),
                    result.ready.eq(o.ready | drop),
                    fifo.o.ready.eq(ends),
                ]
                if self._last is not None:
                    with m.If(record_ends & ~facts.bad):
                        m.d.sync += frame.eq(frame + ends)
                        m.next = "FRAME"
                with m.If(ends):
                    m.next = "SEQUENCE"
        return m

    def _records(self, m: Module, ends: Value, limited: Value) -> tuple[Value, Value, Value]:
        """Whether a word is its frame's last one, and taken, and whether a record of the frame was ``limited``."""
        result = self.result
        if self._last is None:
            return result.p.last, ends, limited
        step = result.valid & result.ready
        number, _ = wrapping_counter(m, step, self._words, "record_word")
        last = Signal(reset_less=True)
        earlier = Signal()
        with m.If(step & (number == self._last)):
            m.d.sync += last.eq(result.p.data[0])
        with m.If(ends):
            m.d.sync += earlier.eq(~last & (earlier | limited))
        return result.p.last & last, ends & last, earlier | limited

    def _inside(self, m: Module, step: Value) -> Value:
        """Whether the word at ``result`` is one of forces; a register."""
        first, last = self._forces.start, self._forces.stop - 1
        number, ends = wrapping_counter(m, step, self._words, "number")
        inside = Signal(init=first == 0)
        with m.If(step & (ends if first == 0 else number == first - 1)):
            m.d.sync += inside.eq(1)
        with m.If(step & (number == last)):
            m.d.sync += inside.eq(0)
        return inside
