"""A core behind AXI in Verilator: scripts of frames and register accesses in, what the core says of them out."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.exactness.axi import CHECK_SEQUENCE, FORCES, RUN
from bench.scorecard.words.harness import Configuration, built, ran
from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.tfra import Status

REGISTERS = {
    "CONTROL": 0x40, "INTERRUPT_ENABLE": 0x4C, "FRAME_TIMEOUT": 0x54, "LOAD_DATA": 0x80, "LOAD_CHECKSUM": 0x88,
    "FRONT_END": 0xA0, "STUCK": 0xAC, "CALIBRATION_PLACE": 0xB4, "CALIBRATION_DATA": 0xB8, "CALIBRATION_CRC": 0xC0,
}  # fmt: skip
"""Addresses."""
SOFT_RESET = 1 << 1
"""Bit of CONTROL."""

ERRORS = (
    "short_frame", "long_frame", "saturation", "input_overflow", "stale",
    "sequence_gap", "load_checksum", "simulated", "out_of_range", "stuck",
)  # fmt: skip
"""Bits of ERRORS."""
SATURATION = 1 << ERRORS.index("saturation")
SATURATED = int(Status.INPUT_SATURATED | Status.OUTPUT_SATURATED)

WIDTH = 4
"""Numbers of an answer."""


def write(name: str, *values: int) -> Ints:
    """The script that writes ``values`` to a register, one after the other."""
    return np.array([[1, REGISTERS[name], value] for value in values], dtype=np.int64).ravel()


def read(name: str) -> Ints:
    """The script that reads a register."""
    return np.array([2, REGISTERS[name]], dtype=np.int64)


def wait(cycles: int) -> Ints:
    """The script of a time without a frame."""
    return np.array([0, cycles, 0, 0], dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Heard:
    """What the core said.

    ``alarms (n,)`` of each slot: bits of ERRORS, of the frame itself where its result has them.  ``errors`` and
    ``faulty``: the registers at the slot's end, 0 without an interrupt.  ``status (n,)`` of the result, −1 of a frame
    without one.  ``values``: what was read.
    """

    alarms: Ints
    errors: Ints
    faulty: Ints
    status: Ints
    values: Ints


class Player:
    """The program ``player.cpp`` around ``design`` in an empty ``folder``."""

    def __init__(self, design: Design, folder: Path, **how: Any) -> None:
        self.design, self.folder = design, folder
        loaded = microarchitecture(design).loaded
        self.coefficients = np.zeros(0, dtype=np.int64) if loaded is None else np.asarray(loaded).ravel()
        source = Path(__file__).with_name("player.cpp")
        self._program = built(Configuration(design.name, design, wrapped=True), folder, source=source, **how)

    def play(self, script: Ints) -> Heard:
        """Reset the core, play ``script``, and sort the answers; raises ``ToolError`` where the program fails."""
        (self.folder / "script").write_bytes(np.asarray(script & 0xFFFFFFFF).astype("<u4").tobytes())
        ran(self._program, "script", "answers")
        answers = np.fromfile(self.folder / "answers", "<u4").astype(np.int64).reshape(-1, WIDTH)
        return heard(answers, sent(script))


def sent(script: Ints) -> Ints:
    """The slots of ``script`` with a frame, by number; a frame of one taxel or more has a number in the core."""
    place, slot, found = 0, 0, []
    while place < len(script):
        if script[place] == 0:
            if script[place + 3]:
                found.append(slot)
            slot += 1
            place += 4 + int(script[place + 3])
        else:
            place += 3 if script[place] == 1 else 2
    return np.array(found, dtype=np.int64)


def heard(answers: Ints, frames: Ints) -> Heard:
    """Sort ``answers (k, 4)``; ``frames`` are the slots in which frames were sent."""
    results, slots, values = (answers[answers[:, 0] == kind, 1:] for kind in range(3))
    errors, faulty, _ = slots.T
    facts, head, status = results.T
    numbers = np.cumsum(np.diff(head & 0xFFFF, prepend=0) % (1 << 16))  # frames that came, in order
    alarms, found = errors & ~SATURATION, np.full(len(slots), -1)
    at = frames[numbers]
    found[at] = status
    alarms[at] |= facts & 0x3FF | SATURATION * (status & SATURATED != 0)
    return Heard(alarms, errors, faulty, found, values[:, 0])


def running(check_sequence: bool) -> Ints:
    """The script that lets a core take frames."""
    return write("CONTROL", RUN | FORCES | CHECK_SEQUENCE * check_sequence)


def settings(stuck: int, timeout: int, check_sequence: bool) -> Ints:
    """The script that starts a core: all errors raise the interrupt."""
    told = write("STUCK", stuck), write("FRAME_TIMEOUT", timeout), write("INTERRUPT_ENABLE", 1)
    return np.concatenate([*told, running(check_sequence)])
