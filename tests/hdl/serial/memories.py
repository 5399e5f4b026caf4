"""What the stages of a frame leave in the data memory."""

import numpy as np

from tfra.hdl.cores import as_serial, program
from tfra.hdl.serial.isa import Dest
from tfra.hdl.serial.trace import trace
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design


def memories(design: Design, codes: Ints) -> dict[str, list[int]]:
    """Words of the memory at the end of every stage of the frame ``codes (1, rows, columns)``, by the stage's name."""
    found, words, running = {}, list(program(design).memory), ""
    for traced in trace(as_serial(design), codes):
        stage = traced.stage.partition(",")[0]
        if stage != running:
            found[running], running = list(words), stage
        step = traced.step
        if step.instruction.written == Dest.M and step.value is not None:
            words[step.address] = step.value
    return found


def vector(words: list[int], start: int, quads: int) -> Ints:
    """Quads ``(quads, 4)`` of the vector at ``start``."""
    return np.array(words[start : start + 4 * quads]).reshape(4, quads).T


def scalars(design: Design, words: list[int], *names: str) -> list[int]:
    """The words with these names."""
    places = {name: address for address, name in program(design).names.items()}
    return [words[places[name]] for name in names]


def three(design: Design, words: list[int], name: str) -> list[int]:
    """The three words from ``name`` on."""
    (start,) = (address for address, each in program(design).names.items() if each == name)
    return words[start : start + 3]
