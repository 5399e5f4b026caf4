"""Speed of the products of a frame in fixed-point libraries and in our integers, with the same words.

``python -m bench.speed.libraries`` lets :mod:`tfra.model.fixed.matvec`, apytypes and fxpmath do all products of the
same 10x10 frames in turn, on one core.  It compares every word, and writes ``bench/results/libraries.json`` and the
table in docs/numerics.md.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from apytypes import APyFixedArray, QuantizationMode
from fxpmath import Fxp

from bench.publish import insert, store
from tfra.model.arrays import Ints
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.coefficients import Operator
from tfra.model.fixed.matvec import matvec, operand
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.stages import Stage
from tfra.model.sensor import SensorArray

PAGE = "docs/numerics.md"
DESIGN = TfraDesign(SensorArray(10, 10, 4e-3, 2e-3, 3e-3))
THREADS = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
"""Environment variables that keep NumPy on one core; they must be set before it is loaded."""

FRAMES = {"model.fixed": 2000, "apytypes": 200, "fxpmath": 4}
REPEATS = 5

Round = Callable[[Operator, int, Ints, int], Ints]
"""Words ``(quads,)`` of a parity of an operator from operand words ``(Q,)``: the sums of products, shifted right."""


def vectors(frames: int) -> dict[str, list[Ints]]:
    """Operands ``(n, Q, 4)`` of every product by the name of its stack."""
    stages = DESIGN.model(contact_codes(DESIGN, frames, seed=1)).stages
    b = butterfly(stages[Stage.NORMALISER]) << DESIGN.formats.vector_fraction
    e0, e1, d = np.split(stages[Stage.COMBINE], 3, axis=1)
    return {"contact": [b], "residual": [stages[Stage.WEIGHTS]], "normal": [e0, e1], "force": [d]}


def in_apytypes() -> Round:
    """Sums in as many bits as they need; a shift moves the point alone, the cast rounds half up."""
    rows: dict[tuple[str, int], Any] = {}

    def rounded(op: Operator, parity: int, words: Ints, shift: int) -> Ints:
        if (op.name, parity) not in rows:
            bits = DESIGN.formats.bits(f"coefficient.{op.name}")
            rows[op.name, parity] = APyFixedArray(op.rows[:, parity], int_bits=bits, frac_bits=0)
        sums = rows[op.name, parity] @ APyFixedArray(words, int_bits=DESIGN.operand_word, frac_bits=0)
        cast = (sums >> shift).cast(DESIGN.widths.vector, 0, quantization=QuantizationMode.RND)
        return cast.to_numpy().astype(np.int64)

    return rounded


def in_fxpmath() -> Round:
    """A number with as many fraction bits as it is moved; half up is down from half a step higher."""
    rows: dict[tuple[str, int], Any] = {}

    def rounded(op: Operator, parity: int, words: Ints, shift: int) -> Ints:
        if (op.name, parity) not in rows:
            bits = DESIGN.formats.bits(f"coefficient.{op.name}")
            rows[op.name, parity] = Fxp(op.rows[:, parity], True, bits, 0)
        sums = rows[op.name, parity].dot(Fxp(words, True, DESIGN.operand_word, 0))
        moved = Fxp((sums.val + (1 << shift >> 1)) / 2**shift, True, DESIGN.widths.vector, 0, rounding="floor")
        return np.asarray(moved.val, dtype=np.int64)

    return rounded


def products(rounded: Round, operands: dict[str, list[Ints]]) -> list[Ints]:
    """Result quads of all products, frame by frame: each has a shift of its own."""
    found = []
    for stack, each in operands.items():
        bits = DESIGN.formats.bits(f"operand.{stack}")
        for vector in each:
            words, significant = operand(vector, bits)
            result = np.empty((len(words), DESIGN.stacks[stack].quads, 4), dtype=np.int64)
            for frame in range(len(words)):
                start = 0
                for op in DESIGN.stacks[stack].operators:
                    for parity in range(4):
                        source = parity ^ op.flip
                        shift = op.fraction + bits - 1 - int(significant[frame, source])
                        into = result[frame, start : start + op.quads, parity]
                        into[:] = rounded(op, parity, words[frame, :, source], shift)
                    start += op.quads
            found.append(result)
    return found


def in_model(operands: dict[str, list[Ints]]) -> list[Ints]:
    """The same by the bit-accurate model, all frames at once."""
    return [matvec(DESIGN, stack, vector) for stack, each in operands.items() for vector in each]


def main() -> None:
    """Measure in turn, compare, publish."""
    every = vectors(max(FRAMES.values()))
    apytypes, fxpmath = in_apytypes(), in_fxpmath()
    engines: dict[str, Callable[[dict[str, list[Ints]]], list[Ints]]] = {
        "model.fixed": in_model,
        "apytypes": lambda operands: products(apytypes, operands),
        "fxpmath": lambda operands: products(fxpmath, operands),
    }
    rates: dict[str, list[float]] = {name: [] for name in engines}
    for _ in range(REPEATS):
        for name, engine in engines.items():
            operands = {stack: [vector[: FRAMES[name]] for vector in each] for stack, each in every.items()}
            start = time.perf_counter()
            found = engine(operands)
            rates[name].append(FRAMES[name] / (time.perf_counter() - start))
            for words, expected in zip(found, in_model(operands), strict=True):
                assert (words == expected).all(), name
    middle = {name: statistics.median(found) for name, found in rates.items()}
    lines = ["| products of a frame in | frames/s, one core | model.fixed is faster by |", "|---|---:|---:|"]
    lines += [f"| {name} | {rate:,.0f} | {middle['model.fixed'] / rate:,.0f} |" for name, rate in middle.items()]
    store("libraries", {"frames": FRAMES, "repeats": REPEATS, "frames_per_second": rates})
    insert("libraries", "\n".join(lines), PAGE)


if __name__ == "__main__":
    if not os.environ.items() >= THREADS.items():
        os.execve(sys.executable, [sys.executable, "-m", "bench.speed.libraries"], os.environ | THREADS)
    main()
