"""Driver of a TFRA core with registers, for Python 3.9 or later, with nothing but the standard library.

``Core`` needs a bus (an object with ``read32`` and ``write32``) and the core's sidecar ``NAME.json``;
``parse_frame`` takes its output frames apart, ``parse_contacts`` those of a skin.
"""
# ruff: noqa: F401  # names of the package

from .contacts import Contact, SkinFrame, parse_contacts, read_contacts
from .core import Core, read_coefficients, repair_words
from .frame import Frame, frame_bytes, parse_frame
from .registers import (
    ERRORS,
    EVENTS,
    OPTIONS,
    UNITY_GAIN,
    Bus,
    ContactSettings,
    Counters,
    DeviceError,
    FaultyTaxel,
    FrontEnd,
    Load,
    Mapped,
    crc32,
    design_hash,
)
