"""What the core is asked for and set to."""

from dataclasses import dataclass


@dataclass(frozen=True)
class FrontEnd:
    """Settings of the front end; see the registers FRONT_END, THRESHOLDS and STUCK."""

    word_bits: int
    is_unsigned: bool = False
    invert: bool = False
    log2_average: int = 0
    dead_band: int = 0
    contact: int = 0
    stuck_frames: int = 0


@dataclass(frozen=True)
class Counters:
    """Counters, which wrap; ``consistent``: no frame came or went while they were read."""

    frames_in: int
    frames_out: int
    frames_dropped: int
    frames_saturated: int
    frame_cycles: int
    consistent: bool


@dataclass(frozen=True)
class Load:
    """Progress of the load: coefficients taken since the reset, their CRC-32, and whether it is the expected one."""

    count: int
    crc: int
    match: bool
    loaded: bool


@dataclass(frozen=True)
class FaultyTaxel:
    """The last taxel with a fault; ``index`` row by row, from 0."""

    index: int
    saturated: bool
    out_of_range: bool
    stuck: bool
