"""Driver of a TFRA core with registers, for Python 3.9 or later, with nothing but the standard library.

``Core`` needs a bus (an object with ``read32`` and ``write32``) and the core's sidecar ``NAME.json``;
``parse_frame`` takes its output frames apart.
"""

from .bus import Bus, Mapped
from .core import Core, read_coefficients, repair_words
from .frame import Frame, frame_bytes, parse_frame
from .states import Counters, FaultyTaxel, FrontEnd, Load
from .words import ERRORS, EVENTS, OPTIONS, UNITY_GAIN, DeviceError, crc32, design_hash

__all__ = [
    "ERRORS",
    "EVENTS",
    "OPTIONS",
    "UNITY_GAIN",
    "Bus",
    "Core",
    "Counters",
    "DeviceError",
    "FaultyTaxel",
    "Frame",
    "FrontEnd",
    "Load",
    "Mapped",
    "crc32",
    "design_hash",
    "frame_bytes",
    "parse_frame",
    "read_coefficients",
    "repair_words",
]
