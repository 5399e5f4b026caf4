"""Frames that bring signals as near to their proven bounds as possible: built from the operators, then searched."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.cover.scenes import directed_codes, wild_codes
from tfra.model.fixed.butterfly import butterfly, to_taxels
from tfra.model.fixed.coefficients import Operator
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra, Stage
from tfra.sim.run import simulate
from tfra.study.signals.tfra.observation import catalogue, observe

ENOUGH = 0.5
"""The share of its bound that a signal should reach."""


@dataclass(frozen=True)
class Attained:
    """The largest ``magnitude`` of a signal, and the ``frame (rows, columns)`` of codes that has it."""

    magnitude: int
    frame: Ints


@dataclass
class Extremes:
    """The best frame of every proven signal of ``design`` so far."""

    design: TfraDesign
    best: dict[str, Attained] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.words = {signal: word for signal, word in catalogue(self.design).items() if word.proven}

    def share(self, signal: str) -> float:
        """The share of its bound that ``signal`` has reached."""
        return self.best[signal].magnitude / self.words[signal].bound

    def try_all(self, frames: Ints) -> None:
        """Evaluate codes ``(n, m)``, one or more, and keep larger values than before."""
        shape = self.design.sensor.rows, self.design.sensor.columns
        for trace in FixedTfra(self.design).traces(frames):
            observed = observe(self.design, trace)
            for signal in self.words:
                peaks = np.abs(observed[signal].values.reshape(len(trace.codes), -1)).max(axis=1)
                frame = int(peaks.argmax())
                if signal not in self.best or peaks[frame] > self.best[signal].magnitude:
                    self.best[signal] = Attained(int(peaks[frame]), trace.codes[frame].reshape(shape))

    def climb(self, signal: str, rounds: int) -> None:
        """Set one taxel at a time to an end of its range, or to zero: the one that raises ``signal`` the most."""
        low, high = ends(self.design)
        taxels = np.arange(self.design.sensor.taxels)
        for _ in range(rounds):
            before = self.best[signal]
            frames = np.repeat(before.frame.reshape(1, -1), 3 * len(taxels), axis=0)
            frames[np.arange(len(frames)), np.tile(taxels, 3)] = np.repeat([low, 0, high], len(taxels))
            self.try_all(frames)
            if self.best[signal].magnitude == before.magnitude:
                return


def attaining(design: TfraDesign, seed: int = 0, rounds: int = 16) -> Extremes:
    """The largest magnitudes that patterns give, and up to ``rounds`` of climbing where they stay small."""
    extremes = Extremes(design)
    for frames in patterns(design, seed):
        extremes.try_all(frames)
    for signal in extremes.words:
        if extremes.share(signal) < ENOUGH:
            extremes.climb(signal, rounds)
    return extremes


def replay(
    design: TfraDesign, frames: Ints, simulator: str | None = None, build_dir: str | Path | None = None
) -> list[tuple[int, str]]:
    """Frame and stage of each difference of the core from the model on codes ``(n, rows, columns)``.

    Result words are those of all frames in a row; stages, where ``simulator`` can watch them, those of a frame alone.
    See :func:`tfra.sim.run.simulate`.
    """
    model = FixedTfra(design)
    run = simulate(design, frames, simulator, build_dir=build_dir)
    wrong = (run.words != model(frames).words).any(axis=1)
    found = [(int(frame), str(Stage.SCALING)) for frame in np.flatnonzero(wrong)]
    for number, frame in enumerate(frames[:, None]) if run.simulator != "amaranth" else ():
        stages = model(frame).stages
        probes = simulate(design, frame, run.simulator, build_dir=build_dir, probes=True).probes
        found += [
            (number, name) for name, words in probes.items() if not np.array_equal(words, stages[name].reshape(1, -1))
        ]
    return found


def ends(design: TfraDesign) -> tuple[int, int]:
    """The smallest and the largest converter code."""
    return -(1 << (design.adc.bits - 1)), (1 << (design.adc.bits - 1)) - 1


def patterns(design: TfraDesign, seed: int) -> Iterator[Ints]:
    """Frames of codes ``(n, m)``: corners of the input, signs of rows, through C33, and noise."""
    m = design.sensor.taxels
    yield directed_codes(design).reshape(-1, m)
    c33 = design.exact_operators.c33
    for stack in design.stacks.values():
        for op in stack.operators:
            signs = rows_as_taxels(design, op)
            yield full_scale(design, signs)
            for lifted in (signs, signs + 1):  # n >= 0 is what is left of a vector in a frame that is swept
                yield scaled(design, lifted @ c33.T)
    rng = np.random.default_rng(seed)
    yield full_scale(design, rng.choice([-1.0, 1.0], size=(500, m)))
    yield wild_codes(design, 500, rng).reshape(-1, m)


def rows_as_taxels(design: TfraDesign, op: Operator) -> Floats:
    """Signs of every row of the folded ``op`` as a vector of taxels of the parity that it multiplies, ``(n, m)``."""
    folded = np.zeros((op.quads, 4, design.quads, 4), dtype=np.int64)
    parity = np.arange(4)
    folded[:, parity, :, parity ^ op.flip] = np.moveaxis(np.where(op.rows < 0, -1, 1), 1, 0)
    return to_taxels(design, butterfly(folded.reshape(-1, design.quads, 4))).astype(np.float64)


def full_scale(design: TfraDesign, vectors: Floats) -> Ints:
    """Codes at the ends of their range by the signs of ``vectors (n, m)``, and the reverse."""
    low, high = ends(design)
    up = np.where(vectors < 0, low, high)
    return np.concatenate([up, ~up])


def scaled(design: TfraDesign, vectors: Floats) -> Ints:
    """Codes in proportion to ``vectors (n, m)``, the largest of each at the end of its range, and the reverse."""
    low, _ = ends(design)
    vectors = vectors[vectors.any(axis=1)]
    codes = np.rint(vectors / np.abs(vectors).max(axis=1, keepdims=True) * low).astype(np.int64)
    return np.asarray(np.clip(np.concatenate([codes, -codes]), *ends(design)))
