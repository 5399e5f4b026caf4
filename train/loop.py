"""The training: Adam with cosine decay on batches that are drawn, augmented and forgotten.

Everything random in a step follows from the seed and the step's number, so a state between two steps is all that a
continuation needs.  A second thread prepares the next batch; matrix products take one thread each, since their sums
depend on the number of threads.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from threadpoolctl import threadpool_limits

from tfra.model.sensor import SensorArray
from tfra.train.augment import augmented
from tfra.train.network import Shape, loss_and_gradient, outputs
from tfra.train.pool import Pool
from tfra.train.simulator import Singles

BATCH = 512

RATE, WARM = 3e-3, 500
"""Largest learning rate, and the steps until it is reached."""

MEAN, SQUARE = 0.9, 0.999
"""Decay rates of Adam's moments."""

CHUNKS, VALIDATION = 256, 8
"""Covers of the training's pool and of the validation set's."""

CHECK = 500
"""Steps between two looks at the validation set."""

PATIENCE = 0.3
"""The training stops when the best look is older than this share of all steps."""

_LOADS, _CHECKS, _START, _STEP = range(4)
"""Second number of each seed."""


class DivergedError(ArithmeticError):
    """The loss is not a finite number."""


@dataclass(frozen=True)
class Plan:
    """What determines the weights: the sensor, C1 and C2, the steps, and the seed."""

    sensor: SensorArray
    counts: tuple[int, int]
    steps: int
    seed: int


@dataclass
class State:
    """The training between two steps: parameters and Adam's moments, and the parameters of the best look so far.

    ``curve`` has a row for each look: steps done, mean loss since the last look, mean |dF|/|F| of the validation set.
    """

    vector: Singles
    mean: Singles
    square: Singles
    best: Singles
    step: int = 0
    loss: float = 0.0
    curve: list[tuple[int, float, float]] = field(default_factory=list)

    @classmethod
    def first(cls, plan: Plan) -> State:
        """The state before the first step."""
        vector = Shape.of(plan.sensor, plan.counts).start(np.random.default_rng((plan.seed, _START)))
        return cls(vector, np.zeros_like(vector), np.zeros_like(vector), vector.copy())

    def patient(self, steps: int) -> bool:
        """Whether the best look is recent."""
        return not self.curve or self.step - min(self.curve, key=lambda row: row[2])[0] <= PATIENCE * steps


class Trainer:
    """A training with its frames; ``advance(k)`` is called when k of ``CHUNKS + VALIDATION`` covers are finished."""

    def __init__(self, plan: Plan, advance: Callable[[int], None]) -> None:
        self.plan = plan
        self._shape = Shape.of(plan.sensor, plan.counts)
        with threadpool_limits(1):
            self._pool = Pool.made(plan.sensor, CHUNKS, (plan.seed, _LOADS), advance)
            checks = Pool.made(plan.sensor, VALIDATION, (plan.seed, _CHECKS), advance)
        self._validation = _batch(checks, len(checks.responses), np.random.default_rng((plan.seed, _CHECKS)))

    def run(self, state: State, report: Callable[[State], None]) -> None:
        """Train ``state`` to the plan's end, or until the validation set shows no progress for long.

        ``report`` sees the state after every step.  Raises ``DivergedError``.
        """
        with threadpool_limits(1), ThreadPoolExecutor(1) as thread:
            following = thread.submit(self._draw, state.step)
            while state.step < self.plan.steps and state.patient(self.plan.steps):
                batch, following = following.result(), thread.submit(self._draw, state.step + 1)
                self._advance(state, *batch)
                if state.step % CHECK == 0 or state.step == self.plan.steps:
                    self._check(state)
                report(state)

    def seconds(self, steps: int) -> float:
        """Measure what a step takes, from some ``steps`` of a training that is thrown away."""
        state, timed = State.first(self.plan), Trainer.__new__(Trainer)
        timed.__dict__.update(vars(self), plan=Plan(self.plan.sensor, self.plan.counts, steps, self.plan.seed))
        start = time.perf_counter()
        timed.run(state, lambda state: None)
        return (time.perf_counter() - start) / steps

    def _draw(self, step: int) -> tuple[Singles, Singles]:
        return _batch(self._pool, BATCH, np.random.default_rng((self.plan.seed, _STEP, step)))

    def _advance(self, state: State, n: Singles, forces: Singles) -> None:
        loss, dense = loss_and_gradient(self._shape.spread(state.vector), n, forces)
        gradient = self._shape.gather(dense) / np.float32(BATCH)
        if not (math.isfinite(loss) and np.isfinite(gradient).all()):
            raise DivergedError(f"the loss is not a number after {state.step} steps")
        state.step += 1
        state.loss += loss / BATCH
        state.mean += np.float32(1 - MEAN) * (gradient - state.mean)
        state.square += np.float32(1 - SQUARE) * (gradient * gradient - state.square)
        mean, square = state.mean / (1 - MEAN**state.step), state.square / (1 - SQUARE**state.step)
        state.vector -= np.float32(_rate(state.step, self.plan.steps)) * mean / (np.sqrt(square) + np.float32(1e-8))

    def _check(self, state: State) -> None:
        n, forces = self._validation
        found = outputs(self._shape.spread(state.vector), n)
        error = np.linalg.norm(found - forces, axis=1) / np.linalg.norm(forces, axis=1)
        since = state.step - (state.curve[-1][0] if state.curve else 0)
        if all(error.mean() < row[2] for row in state.curve):
            state.best[:] = state.vector
        state.curve.append((state.step, state.loss / since, float(error.mean())))
        state.loss = 0.0


def _rate(step: int, steps: int) -> float:
    return RATE * min(1.0, step / WARM) * 0.5 * (1 + math.cos(math.pi * step / (steps + 1)))


def _batch(pool: Pool, count: int, rng: np.random.Generator) -> tuple[Singles, Singles]:
    """Augmented frames and their resultants, both over the sum of the frame's magnitudes."""
    frames, forces = pool.draw(count, rng)
    frames = augmented(frames, rng)
    scale = 1 / np.abs(frames).sum(axis=1, keepdims=True)
    return frames * scale, forces * scale
