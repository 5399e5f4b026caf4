"""Programs in the interpreter, compared with the model."""

import numpy as np

from tests.model.fixed.learned.cases import codes_of
from tfra.hdl.cores import program
from tfra.hdl.serial.isa import Dest
from tfra.hdl.serial.program.interpreter import Interpreter
from tfra.hdl.serial.program.memory import store_image
from tfra.model.arrays import Ints
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.design import Design


def scenes(design: Design, seed: int) -> Ints:
    """Contacts, corners of the input, noise, and frames of all sizes, many of which pull."""
    parts = contact_codes(design, 2, seed), directed_codes(design), wild_codes(design, 2, seed)
    return np.concatenate([*parts, codes_of(design, 5, seed)])


def interpret(design: Design, codes: Ints, store: Ints | None = None) -> tuple[Ints, Ints]:
    """Result words ``(n, words)``, and the cycle of each frame's last word."""
    code = program(design)
    image = store_image(design) if store is None else store
    machine = Interpreter(code.sizes, code.lengths, code.instructions, list(code.memory), image.tolist())
    words, ends = [], []
    for step in machine.steps(iter(codes.ravel().tolist())):
        if step.value is not None and step.instruction.written in (Dest.OUT, Dest.LAST):
            words.append(step.value)
            ends += [step.cycle] * (step.instruction.dest == Dest.LAST)
    return np.array(words).reshape(len(codes), -1), np.array(ends)


def check(design: Design, codes: Ints) -> None:
    """Every word is the model's, and every frame takes the stated cycles."""
    want = design.model(codes).words
    words, ends = interpret(design, codes)
    names = [f.name for f in design.layout for _ in range(f.count)]
    bad = np.argwhere(words != want)
    assert not len(bad), f"frame {bad[0][0]}, {names[bad[0][1]]}, word {bad[0][1]}"
    assert (np.diff(ends) == program(design).interval).all()
