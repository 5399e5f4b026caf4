"""Loads the results of products into the stores of the vector updates: n, and b + g, d1 and d2."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, quad
from tfra.hdl.lib.pipeline import delayed, register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.beats import beat_in_quad, beat_number, select_beat, vector_beats
from tfra.hdl.parallel.payloads import vector_beat, vector_quad
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE, place, store_write
from tfra.model.fixed.design import Design


class WeightLoader(wiring.Component):
    """Writes n into its store, each beat a cycle after its arrival."""

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "n": In(always_ready_stream(vector_quad(design))),  # Q quads a frame, folded weights
            "write": Out(store_write(design)),  # beats to be written
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        valid, number, ends = vector_beats(m, self._design, self.n.valid)
        frame_place, _ = wrapping_counter(m, ends, FRAMES, "place")
        m.d.sync += self.write.valid.eq(valid)
        m.d.comb += [
            self.write.place.eq(register(m, frame_place, "write_place")),
            self.write.number.eq(register(m, number, "write_number")),
            self.write.words.eq(register(m, select_beat(self._design, self.n.payload, number), "write_words")),
        ]
        return m


class ResidualLoader(wiring.Component):
    """d0 = b + g, d1 and d2 into the stores: d1 and d2 into both, since each is an x or a z.

    b waits for its g in a memory with one place more than frames with a token, for the frame whose b is still an
    operand.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            # Q quads a frame, folded stress in converter codes.
            "b": In(always_ready_stream(quad(design.adc.bits + 2))),
            "residual": In(always_ready_stream(vector_quad(design))),  # 3 Q quads a frame, after its b: g, d1, d2
            "x": Out(store_write(design, 2)),  # beats to be written where x is read: d1 as vector 0, d2 as vector 1
            "z": Out(store_write(design, 3)),  # beats to be written where z is read: d0, d1, d2 as vectors 0, 1, 2
            "stored": Out(1),  # pulse, all vectors of a frame and their headroom can be read
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design = self._design
        valid, number, ends = vector_beats(m, design, self.residual.valid)
        vector, last_vector = wrapping_counter(m, ends, 3, "vector")
        frame_place, _ = wrapping_counter(m, ends & last_vector, FRAMES, "place")
        m.d.comb += self.stored.eq(delayed(m, ends & last_vector, MEASURE - 1, "stored", control=True))
        layout = {"words": vector_beat(design), "vector": 2, "place": place, "number": beat_number(design)}
        arrived = Signal(data.StructLayout(layout), reset_less=True)
        m.d.sync += [
            arrived.words.eq(select_beat(design, self.residual.payload, number)),
            arrived.vector.eq(vector),
            arrived.place.eq(frame_place),
            arrived.number.eq(number),
        ]
        m.d.comb += [
            self.x.valid.eq(register(m, valid & (vector != 0), "arrived_x", control=True)),
            self.x.place.eq(arrived.place),
            self.x.vector.eq(arrived.vector == 2),
            self.x.number.eq(arrived.number),
            self.x.words.eq(arrived.words),
        ]
        arrived_valid = register(m, valid, "arrived_valid", control=True)
        b = self._read_b(m, number, ends & (vector == 0))
        self._write_z(m, arrived_valid, arrived, b)
        return m

    def _read_b(self, m: Module, number: Value, ends: Value) -> Any:
        """Quad of b for beat ``number`` of g, two cycles after it; ``ends`` is high with g's last beat."""
        design, quads = self._design, self._design.quads
        depth = (FRAMES + 1) << counter_shape(quads - 1).width
        codes = Ram(m, "b", self.b.payload.shape(), depth)
        b_number, b_last = wrapping_counter(m, self.b.valid, quads, "b_number")
        write_place, _ = wrapping_counter(m, self.b.valid & b_last, FRAMES + 1, "b_write_place")
        # In time for the next frame's g, which comes after d1 and d2.
        ended = register(m, ends, "g_ended", control=True)
        read_place, _ = wrapping_counter(m, ended, FRAMES + 1, "b_read_place")
        g_number = (number >> len(beat_in_quad(design, number)))[: len(b_number)]
        codes.write(self.b.valid, Cat(b_number, write_place), self.b.payload)
        return register(m, codes.read(Cat(g_number, read_place)), "b_of_g")

    def _write_z(self, m: Module, arrived_valid: Value, arrived: Any, b: Any) -> None:
        """g meets its b a cycle after its arrival; the sum is a register."""
        design = self._design
        beside_b = register(m, arrived, "beside_b")
        codes = select_beat(design, b, beside_b.number)
        m.d.sync += self.z.valid.eq(register(m, arrived_valid, "beside_b_valid", control=True))
        m.d.comb += [
            self.z.place.eq(register(m, beside_b.place, "z_place")),
            self.z.vector.eq(register(m, beside_b.vector, "z_vector")),
            self.z.number.eq(register(m, beside_b.number, "z_number")),
        ]
        for k in range(design.architecture.vector_words):
            code = codes.word_select(k, len(b[k])).as_signed()
            added = Mux(beside_b.vector == 0, code << design.formats.vector_fraction, 0)
            total = (beside_b.words[k] + added)[: len(beside_b.words[k])]
            m.d.comb += self.z.words[k].eq(register(m, total, f"z_word{k}"))
