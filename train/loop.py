"""The training: steps with a cosine decay of the rate, on batches that are drawn, augmented and forgotten.

Everything random in a step follows from the seed and the step's number, so a state between two steps is all that a
continuation needs.  A second thread prepares the next batch; matrix products take one thread each, since their sums
depend on the number of threads.

The update of a step is orthogonalised momentum for the layers (Muon, Jordan et al. 2024), Adam for the rest.  The
momentum of a layer's matrix is replaced by the nearest matrix with equal singular values.  So directions in which the
loss is flat are learned as fast as steep ones: the same loss takes a third of Adam's steps.
"""

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from threadpoolctl import threadpool_limits

from tfra.model.arrays import Floats, Singles
from tfra.model.fixed.repair import filled
from tfra.model.sensor import SensorArray
from tfra.train.augment import augmented, broken
from tfra.train.known import UNKNOWN, Known
from tfra.train.network import Shape, estimates, loss_and_gradient
from tfra.train.patches import Patches
from tfra.train.pool import Pool
from tfra.train.rounding import EXACT, Exact

BATCH = 512

RATE, WARM = 0.05, 500
"""Largest learning rate, relative to each parameter's typical size, and the steps until it is reached."""

CHUNKS, VALIDATION = 256, 8
"""Covers of the training's pool and of the validation set's."""

COVERS = CHUNKS + VALIDATION

CHECK = 500
"""Steps between two validations."""

PATIENCE = 0.3
"""The training stops when the best validation is older than this share of all steps."""

LAYERS = 2
"""The first arrays of ``Folded`` are matrices of layers."""

MOMENTUM = 0.95
"""Decay rate of the layers' momentum."""

GAIN = 0.3
"""Root mean square of an update of the layers, for a rate of 1: about that of Adam."""

MEAN, SQUARE = 0.9, 0.999
"""Decay rates of Adam's moments."""

_QUINTIC = 3.4445, -4.7750, 2.0315
"""Coefficients of a x + b x^3 + c x^5, which moves singular values in (0, 1] close to 1 in five turns."""

_LOADS, _CHECKS, _START, _STEP = range(4)
"""Second number of each seed."""

Simulate = Callable[[SensorArray, int, tuple[int, ...], Callable[[int], None]], Pool | Patches]
"""Makes the loads of a sensor, a number of covers and a seed; see ``Pool.simulate``."""

Batch = tuple[Singles, Singles, Singles]
"""Parities ``(4, k, Q)`` of frames, their resultants ``(k, 3)`` and the weight ``(k, 1)`` of each."""


class DivergedError(ArithmeticError):
    """The loss is no longer a finite number; the message says after how many steps."""


@dataclass
class State:
    """The training between two steps: parameters, running means of the gradient and its square, best parameters so far.

    ``curve`` has a row for each validation: steps done, mean loss since the last one, mean |dF|/|F| of its frames.
    """

    vector: Singles
    mean: Singles
    square: Singles
    best: Singles
    step: int = 0
    loss: float = 0.0
    curve: list[tuple[int, float, float]] = field(default_factory=list)

    def patient(self, steps: int) -> bool:
        """Whether the best validation is recent."""
        return not self.curve or self.step - min(self.curve, key=lambda row: row[2])[0] <= PATIENCE * steps


class Trainer:
    """The frames of a training of C1, C2 = ``counts``; ``advance(1)`` is called for each of ``COVERS`` covers.

    ``simulate`` makes their loads: of a whole array, or of the windows of a skin.  ``known``: what a calibration
    says of the array.
    """

    def __init__(
        self,
        sensor: SensorArray,
        counts: tuple[int, int],
        seed: int,
        advance: Callable[[int], None],
        simulate: Simulate = Pool.simulate,
        known: Known = UNKNOWN,
        rounding: Exact = EXACT,
    ) -> None:
        self.shape = Shape(sensor, counts)
        self._rounding = rounding
        self._scale = self.shape.scale
        self._seed = seed
        self._known = known
        with threadpool_limits(1):
            self._pool = simulate(sensor, CHUNKS, (seed, _LOADS), advance)
            checks = simulate(sensor, VALIDATION, (seed, _CHECKS), advance)
        self._validation = self._batch(checks, len(checks.responses), np.random.default_rng((seed, _CHECKS)))

    def first(self) -> State:
        """The state before the first step."""
        start = self._rounding.start
        vector = self.shape.start(np.random.default_rng((self._seed, _START))) if start is None else start.copy()
        return State(vector, np.zeros_like(vector), np.zeros_like(vector), vector.copy())

    def outputs(self, vector: Singles, n: Floats) -> Floats:
        """Outputs ``(k, 4)`` of the rounded network for the normal forces ``n (k, m)``."""
        inputs = self._rounding.operand("first", self.shape.folded(n.astype(np.float32)))
        return estimates(self.shape.split(vector), inputs, self._rounding).astype(np.float64)

    def run(self, steps: int, state: State, report: Callable[[State], None]) -> None:
        """Train ``state`` until it has done ``steps``, or the validation set has shown no progress for long, if
        they began at random.

        ``report`` sees the state after every step.  Raises ``DivergedError``.
        """
        begun = self._rounding.counts is not None  # such weights get worse before they get better
        with threadpool_limits(1), ThreadPoolExecutor(1) as thread:
            following = thread.submit(self._draw, state.step)
            while state.step < steps and (begun or state.patient(steps)):
                batch, following = following.result(), thread.submit(self._draw, state.step + 1)
                self._advance(steps, state, batch)
                if state.step % CHECK == 0 or state.step == steps:
                    self._validate(state)
                report(state)

    def seconds(self, steps: int) -> float:
        """Seconds of a step, measured over the first ``steps`` of a training that is thrown away."""
        start = time.perf_counter()
        self.run(steps, self.first(), lambda state: None)
        return (time.perf_counter() - start) / steps

    def _draw(self, step: int) -> Batch:
        return self._batch(self._pool, BATCH, np.random.default_rng((self._seed, _STEP, step)))

    def _batch(self, pool: Pool | Patches, count: int, rng: np.random.Generator) -> Batch:
        """Parities of augmented frames, and their resultants, both over the sum of the frame's magnitudes."""
        n, forces, weight, peak, there = pool.draw(count, rng)
        known = self._known
        n = augmented(n, peak, rng, known.gain_error) * there
        n[:, known.dead] = 0.0
        weight[broken(n, rng, known.dead)] = 0.0
        n = filled(n, known.repairs)
        scale = 1 / np.abs(n).sum(axis=1, keepdims=True)
        return self._rounding.operand("first", self.shape.folded(n * scale)), forces * scale, weight

    def _advance(self, steps: int, state: State, batch: Batch) -> None:
        with np.errstate(all="ignore"):  # values that are not finite are refused below
            loss, parts = loss_and_gradient(self.shape.split(state.vector), *batch, self._rounding)
        gradient: Singles = np.concatenate([part.ravel() for part in parts])
        gradient /= np.float32(BATCH)
        if not (math.isfinite(loss) and np.isfinite(gradient).all()):
            raise DivergedError(f"the loss is not a number after {state.step} steps")
        state.step += 1
        state.loss += loss / BATCH
        change = update(self.shape, gradient, state.mean, state.square, state.step)
        state.vector -= np.float32(self._rounding.pace * _rate(state.step, steps)) * self._scale * change

    def _validate(self, state: State) -> None:
        inputs, forces, weight = self._validation
        found = estimates(self.shape.split(state.vector), inputs, self._rounding)[:, :3]
        each = np.linalg.norm(found - forces, axis=1) / np.linalg.norm(forces, axis=1)
        error = np.average(each, weights=weight[:, 0])
        since = state.step - (state.curve[-1][0] if state.curve else 0)
        if all(error < row[2] for row in state.curve):
            state.best[:] = state.vector
        state.curve.append((state.step, state.loss / since, float(error)))
        state.loss = 0.0


def _rate(step: int, steps: int) -> float:
    return RATE * min(1.0, step / WARM) * 0.5 * (1 + math.cos(math.pi * step / (steps + 1)))


def update(shape: Shape, gradient: Singles, mean: Singles, square: Singles, step: int) -> Singles:
    """Update of all parameters for a learning rate of 1, over each parameter's typical size.

    In: the ``gradient``, its running ``mean`` and the running mean of its ``square``, all vectors of parameters, and
    the number of the ``step``, from 1.  Both means are brought up to date in place.
    """
    size = sum(part.size for part in shape.split(gradient)[:LAYERS])
    layers, rest = slice(size), slice(size, None)
    for part, decay in ((layers, MOMENTUM), (rest, MEAN)):
        mean[part] += np.float32(1 - decay) * (gradient[part] - mean[part])
    square[rest] += np.float32(1 - SQUARE) * (gradient[rest] ** 2 - square[rest])
    change = np.empty_like(gradient)
    nesterov = np.float32(MOMENTUM) * mean + np.float32(1 - MOMENTUM) * gradient
    for matrices, momentum in zip(shape.split(change)[:LAYERS], shape.split(nesterov), strict=False):
        matrices[:] = np.float32(GAIN * math.sqrt(max(matrices.shape[1:]))) * orthogonal(momentum)
    first, second = mean[rest] / (1 - MEAN**step), square[rest] / (1 - SQUARE**step)
    change[rest] = first / (np.sqrt(second) + np.float32(1e-8))
    return change


def orthogonal(matrices: Singles) -> Singles:
    """Matrices ``(4, a, b)`` with their singular values moved close to 1, by five turns of Newton and Schulz."""
    a, b, c = (np.float32(each) for each in _QUINTIC)
    wide = matrices if matrices.shape[1] <= matrices.shape[2] else matrices.swapaxes(1, 2)
    x = wide / (np.linalg.norm(wide, axis=(1, 2), keepdims=True) + np.float32(1e-12))
    for _ in range(5):
        gram = x @ x.swapaxes(1, 2)
        x = a * x + (b * gram + c * (gram @ gram)) @ x
    return np.asarray(x if wide is matrices else x.swapaxes(1, 2))
