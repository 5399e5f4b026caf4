"""Loads the results of products into the stores of the vector updates: n, and b + g, d1 and d2."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import data

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import delayed, register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.parallel.beats import beat_in_quad, beat_number, select_beat, vector_beats
from tfra.hdl.parallel.payloads import vector_beat
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE, place
from tfra.model.fixed.design import Design


def load_weights(m: Module, design: Design, n: Any, write: Any) -> None:
    """The stream ``n``, Q quads a frame, into its store, each beat a cycle after its arrival."""
    valid, number, ends = vector_beats(m, design, n.valid)
    frame_place, _ = wrapping_counter(m, ends, FRAMES, "place")
    m.d.comb += [
        write.valid.eq(register(m, valid, "write_valid", control=True)),
        write.place.eq(register(m, frame_place, "write_place")),
        write.number.eq(register(m, number, "write_number")),
        write.words.eq(register(m, select_beat(design, n.payload, number), "write_words")),
    ]


def load_residuals(m: Module, design: Design, b: Any, residual: Any, x: Any, z: Any) -> Value:
    """d0 = b + g, d1 and d2 into the stores: d1 and d2 into both, since each is an x or a z.

    ``b``: a stream of Q quads a frame, which wait for their g; ``residual``: one of 3 Q quads a frame: g, d1, d2;
    ``x``, ``z``: writes of the stores.  Returns a pulse: all vectors of a frame and their headroom can be read.
    """
    valid, number, ends = vector_beats(m, design, residual.valid)
    vector, last_vector = wrapping_counter(m, ends, 3, "vector")
    frame_place, _ = wrapping_counter(m, ends & last_vector, FRAMES, "place")
    layout = {"words": vector_beat(design), "vector": 2, "place": place, "number": beat_number(design)}
    arrived = Signal(data.StructLayout(layout), reset_less=True)
    m.d.sync += [
        arrived.words.eq(select_beat(design, residual.payload, number)),
        arrived.vector.eq(vector),
        arrived.place.eq(frame_place),
        arrived.number.eq(number),
    ]
    m.d.comb += [
        x.valid.eq(register(m, valid & (vector != 0), "arrived_x", control=True)),
        x.place.eq(arrived.place),
        x.vector.eq(arrived.vector == 2),
        x.number.eq(arrived.number),
        x.words.eq(arrived.words),
        z.valid.eq(delayed(m, valid, 3, "arrived_valid", control=True)),
    ]
    _write_z(m, design, arrived, _read_b(m, design, b, number, ends & (vector == 0)), z)
    return delayed(m, ends & last_vector, MEASURE - 1, "stored", control=True)


def _read_b(m: Module, design: Design, b: Any, number: Value, ends: Value) -> Any:
    """Quad of b for beat ``number`` of g, two cycles after it; ``ends`` is high with g's last beat.

    The memory has one place more than frames with a token, for the frame whose b is still an operand.
    """
    codes = Ram(m, "b", b.payload.shape(), (FRAMES + 1) << counter_shape(design.quads - 1).width)
    b_number, b_last = wrapping_counter(m, b.valid, design.quads, "b_number")
    write_place, _ = wrapping_counter(m, b.valid & b_last, FRAMES + 1, "b_write_place")
    # In time for the next frame's g, which comes after d1 and d2.
    ended = register(m, ends, "g_ended", control=True)
    read_place, _ = wrapping_counter(m, ended, FRAMES + 1, "b_read_place")
    g_number = (number >> len(beat_in_quad(design, number)))[: len(b_number)]
    codes.write(b.valid, Cat(b_number, write_place), b.payload)
    return register(m, codes.read(Cat(g_number, read_place)), "b_of_g")


def _write_z(m: Module, design: Design, arrived: Any, b: Any, z: Any) -> None:
    """g meets its b a cycle after its arrival; the sum is a register."""
    beside_b = register(m, arrived, "beside_b")
    codes = select_beat(design, b, beside_b.number)
    m.d.comb += [
        z.place.eq(register(m, beside_b.place, "z_place")),
        z.vector.eq(register(m, beside_b.vector, "z_vector")),
        z.number.eq(register(m, beside_b.number, "z_number")),
    ]
    for k in range(design.architecture.vector_words):
        code = codes.word_select(k, len(b[k])).as_signed()
        added = Mux(beside_b.vector == 0, code << design.formats.vector_fraction, 0)
        total = (beside_b.words[k] + added)[: len(beside_b.words[k])]
        m.d.comb += z.words[k].eq(register(m, total, f"z_word{k}"))
