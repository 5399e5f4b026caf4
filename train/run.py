"""A training from its budget to the weights and what is known of them."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from pydantic import JsonValue

from tfra.codegen.config.weights import Trained
from tfra.model.learned.network import Network
from tfra.model.sensor import SensorArray
from tfra.train import augment, pool, prior
from tfra.train.errors import held_out, threshold
from tfra.train.loop import BATCH, CHUNKS, COVERS, RATE, State, Trainer
from tfra.train.network import DOUBT, TANGENTIAL, UNEXPLAINED
from tfra.train.work import opened_work

STEPS = 120_000
"""Steps without a budget."""

SAVE_EVERY = 5.0
"""Seconds between two states in the working folder."""

TRIED = 100
"""Steps that are measured to make steps of minutes."""


class Advance(Protocol):
    """Counts finished ``pieces`` of a stage; the ``state`` is that of the training."""

    def __call__(self, pieces: int, state: State | None = None) -> None: ...


Reporter = Callable[[str, int, int], AbstractContextManager[Advance]]
"""Function of a stage's name, the number of its pieces, and of those that are there."""


@dataclass(frozen=True)
class Budget:
    """What the user has chosen: C1 and C2, the seed, and either steps or minutes, else ``STEPS``."""

    counts: tuple[int, int]
    seed: int
    steps: int | None = None
    minutes: float | None = None


def run(sensor: SensorArray, budget: Budget, folder: Path, reporter: Reporter) -> Trained:
    """Train the network of ``sensor``; the state is kept in ``folder``, where the same training goes on.

    Raises ``InputError`` for a folder that can't be used, and :class:`tfra.train.loop.DivergedError`.
    """
    key = repr((sensor, budget))
    with opened_work(folder) as work:
        kept = work.load(key)
        with reporter("simulating", COVERS, 0) as advance:
            trainer = Trainer(sensor, budget.counts, budget.seed, advance)
        steps, state = kept or (_steps(budget, trainer), trainer.first())
        with reporter("training", steps, state.step) as advance:
            saved = time.monotonic()

            def report(state: State) -> None:
                nonlocal saved
                advance(1, state)
                if time.monotonic() - saved > SAVE_EVERY:
                    work.save(key, steps, state)
                    saved = time.monotonic()

            trainer.run(steps, state, report)
        work.save(key, steps, state)
    weights = trainer.shape.weights(state.best)
    network = Network(sensor, weights)
    curve = np.array(state.curve, np.float64).reshape(-1, 3)
    known = described(budget, steps)
    return Trained(sensor, weights, threshold(sensor, network), known, held_out(sensor, network), curve)


def _steps(budget: Budget, trainer: Trainer) -> int:
    if budget.minutes is None:
        return budget.steps or STEPS
    return max(TRIED, round(60 * budget.minutes / trainer.seconds(TRIED)))


def described(budget: Budget, steps: int) -> dict[str, JsonValue]:
    """Return the distribution of the training's frames, and the numbers that repeat the training."""
    numbers: dict[str, JsonValue] = {
        f"{section}.{name.lower()}": list(value) if isinstance(value, tuple) else value
        for section, module in (("prior", prior), ("prior", pool), ("augment", augment))
        for name, value in vars(module).items()
        if name.isupper() and isinstance(value, float | int | tuple)
    }
    loss = {"tangential": TANGENTIAL, "doubt": DOUBT, "unexplained": UNEXPLAINED}
    training = {"steps": steps, "seed": budget.seed, "batch": BATCH, "rate": RATE, "covers": CHUNKS, **loss}
    return numbers | {f"training.{name}": value for name, value in training.items()}
