"""Ports of the front end: words of the converters in, codes of the core and facts of a frame out."""

from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.model.fixed.front_end import WORD

NUMBER = 16
"""Bits of a frame's number."""

TAXEL = data.StructLayout({"word": WORD, "user": NUMBER, "last": 1})
"""A taxel of the sensor's stream; ``last`` ends a frame, and ``user`` counts then as its number."""

FLAGS = data.StructLayout({name: 1 for name in ("saturation", "sequence_gap", "simulated", "out_of_range", "stuck")})
"""Faults of a frame; those of the frames that it is the mean of, too."""

FACTS = data.StructLayout({"sequence": NUMBER, "user": NUMBER, "flags": FLAGS, "started": BITS, "bad": 1})
"""What goes with a frame around the core.

``sequence`` counts all frames that arrived since the reset, bad ones, too, from 0; ``user`` is the number that came
with the frame; ``started`` is the time of its first taxel.  Of a mean of frames, it is the last one.  The result of a
``bad`` frame, which was cut through, is to be dropped; its other facts mean nothing.
"""

SETTINGS = wiring.Signature({
    "run": Out(1),
    "drop_late": Out(1),
    "check_sequence": Out(1),
    "cut_through": Out(1),
    "word_bits": Out(5),
    "is_unsigned": Out(1),
    "invert": Out(1),
    "log2_average": Out(3),
    "log2_tare": Out(3),
    "dead_band": Out(16),
    "contact": Out(16),
    "stuck_frames": Out(8),
    "repair_words": Out(16),
})
"""Settings, as software drives them: see the registers of the same names."""

TABLES = wiring.Signature({
    "index": Out(16),  # a place in the table ...
    "kind": Out(2),  # ... of this kind
    "data_written": Out(1),  # pulse: there is a word for the place
    "data": Out(BITS),
    "value": In(BITS),  # the word at the place, extended by its sign
})
"""The way of software to the tables of offsets, gains and repairs: registers ``CALIBRATION_...``."""

EVENTS = wiring.Signature({
    name: Out(1)
    for name in (
        "accepted",
        "dropped",
        "short_frame",
        "long_frame",
        "input_overflow",
        "saturation",
        "sequence_gap",
        "out_of_range",
        "stuck",
    )
})
"""Pulses of a cycle; ``accepted`` for every complete frame, ``dropped`` for every other, the rest as in ERRORS."""

FAULTY = data.StructLayout({"index": 16, "saturated": 1, "out_of_range": 1, "stuck": 1})
"""A taxel with a fault, as in FAULTY_TAXEL."""
