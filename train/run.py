"""A training from its budget to the weights, with their errors on held-out frames.

These are frames of the exact series, whose contacts, shapes and seeds no training sees.
"""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Protocol

import numpy as np
from pydantic import JsonValue

from tfra import codegen, model, runtime, train
from tfra.codegen.config.weights import Trained
from tfra.model.arrays import Floats
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import any_contacts
from tfra.model.learned.network import Network
from tfra.model.metrics import errors
from tfra.model.sensor import SensorArray
from tfra.model.tfra import direction_deg, friction
from tfra.runtime.digest import digest, sources
from tfra.runtime.store import Store, work_folder
from tfra.train import augment, pool, prior
from tfra.train.loop import BATCH, CHUNKS, COVERS, RATE, State, Trainer
from tfra.train.network import DOUBT, TANGENTIAL, UNEXPLAINED

STEPS = 120_000
"""Steps without a budget."""

SAVE_EVERY = 5.0
"""Seconds between two states in the working folder."""

TRIED = 100
"""Steps that are measured to make steps of minutes."""

NOISES = (0.0, 1e-3, 1e-2)
"""Standard deviations of the noise over each frame's peak."""

COUNT, SEED = 2000, 20_000
"""Held-out contacts and their seed."""

BITS, LEVELS = 14, (0.1, 0.95)
"""Of the converter; range of the peaks, as shares of its full scale."""

PERCENTILES = (50, 95)

TABLE = {"mu": "mu_abs", "phi_deg": "phi_deg", "force_percent": "force_percent_of_resultant"}
"""Names of the errors, and their keys in :data:`tfra.model.metrics.ERRORS`."""

FALSE_ALARMS, QUIET, LIMIT_SEED = 0.02, 1e-3, 10_000
"""Share of single contacts that may be over the threshold, the noise that they have, and their seed."""

Estimate = Callable[[Floats], Floats]
"""Function of normal forces ``(n, m)`` at every taxel that returns outputs ``(n, 4)`` of the network; all in N."""


class Advance(Protocol):
    """Counts finished ``pieces`` of a stage; the ``state`` is that of the training."""

    def __call__(self, pieces: int, state: State | None = None) -> None: ...


Reporter = Callable[[str, int, int], AbstractContextManager[Advance]]
"""Function of a stage's name, the number of its pieces, and of those that are finished."""


@dataclass(frozen=True)
class Budget:
    """The user's choices: C1 and C2, the seed, and either steps or minutes, else ``STEPS``."""

    counts: tuple[int, int]
    seed: int
    steps: int | None = None
    minutes: float | None = None


def run(sensor: SensorArray, budget: Budget, folder: Path, reporter: Reporter) -> Trained:
    """Train the network of ``sensor``; the state is stored in ``folder``, where the same training continues.

    Raises ``InputError`` for a folder that can't be used, and :class:`tfra.train.loop.DivergedError`.
    """
    store, name = Store(folder), f"{digest(repr((sensor, budget)))}.state"
    with work_folder(folder, "training", fingerprint()):
        stored = _load(store, name)
        with reporter("simulating", COVERS, 0) as advance:
            trainer = Trainer(sensor, budget.counts, budget.seed, advance)
        steps = budget.steps or STEPS
        if stored is None and budget.minutes is not None:
            steps = max(TRIED, round(60 * budget.minutes / trainer.seconds(TRIED)))
        steps, state = stored or (steps, trainer.first())
        with reporter("training", steps, state.step) as advance:
            saved = time.monotonic()

            def report(state: State) -> None:
                nonlocal saved
                advance(1, state)
                if time.monotonic() - saved > SAVE_EVERY:
                    _save(store, name, steps, state)
                    saved = time.monotonic()

            trainer.run(steps, state, report)
        _save(store, name, steps, state)
    weights = trainer.shape.weights(state.best)
    network = Network(sensor, weights)
    curve = np.array(state.curve, np.float64).reshape(-1, 3)
    facts = training_facts(budget, steps)
    return Trained(sensor, weights, threshold(sensor, network), facts, held_out(sensor, network), curve)


def _load(store: Store, name: str) -> tuple[int, State] | None:
    """Return the steps and the state of the training in the file ``name``, if there is one; raises ``InputError``."""
    if name not in store.names():
        return None
    with np.load(BytesIO(store.get(name)), allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in ("vector", "mean", "square", "best")}
        curve = [(int(step), loss, error) for step, loss, error in stored["curve"].tolist()]
        return int(stored["steps"]), State(**arrays, step=int(stored["step"]), loss=float(stored["loss"]), curve=curve)


def _save(store: Store, name: str, steps: int, state: State) -> None:
    """Replace the state of a training of ``steps`` in the file ``name``; raises ``InputError``."""
    curve = np.array(state.curve, np.float64).reshape(-1, 3)
    stream = BytesIO()
    np.savez(stream, allow_pickle=False, **asdict(state) | {"curve": curve, "steps": steps})
    store.put(name, stream.getvalue())


@cache
def fingerprint() -> str:
    """Version and sources of everything that determines the weights."""
    return digest(version("tfra"), *sources(codegen, model, runtime, train))


def training_facts(budget: Budget, steps: int) -> dict[str, JsonValue]:
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


@dataclass(frozen=True, eq=False)
class Resultants:
    """Forces ``(n, 3)`` in N with their friction and direction, as :mod:`tfra.model.metrics` reads them."""

    resultant: Floats

    @property
    def mu(self) -> Floats:
        """Friction (Eq. 15), ``(n,)``."""
        return friction(self.resultant)

    @property
    def phi_deg(self) -> Floats:
        """Direction of the tangential force in [0, 360), ``(n,)``."""
        return direction_deg(self.resultant)[0]


@dataclass(frozen=True, eq=False)
class Series:
    """Exact frames ``(n, m)`` in N of contacts with resultants ``force (n, 3)``.

    ``noise (n, m)`` has the size of each frame's peak, ``step (n, 1)`` is that of the converter, both in N.
    """

    force: Floats
    exact: Floats
    noise: Floats
    step: Floats

    @classmethod
    def of(cls, sensor: SensorArray, count: int, seed: int) -> "Series":
        """Random contacts anywhere on ``sensor``."""
        rng = np.random.default_rng(seed)
        contacts = any_contacts(sensor, count, rng)
        exact = frames(sensor, contacts).reshape(count, -1) * sensor.taxel_area
        peak = np.abs(exact).max(axis=1, keepdims=True)
        step = peak / (rng.uniform(*LEVELS, (count, 1)) * 2 ** (BITS - 1))
        return cls(contacts.force, exact, peak * rng.normal(size=exact.shape), step)

    def read(self, level: float) -> Floats:
        """Frames with noise of ``level``, as the converter reads them."""
        return np.asarray(np.rint((self.exact + level * self.noise) / self.step) * self.step)


def held_out(sensor: SensorArray, estimate: Estimate, count: int = COUNT) -> dict[str, float]:
    """Return median and 95th percentile of every error of ``TABLE`` at every noise, named like ``mu_95_at_0.001``."""
    series, summary = Series.of(sensor, count, SEED), {}
    for level in NOISES:
        every = errors(Resultants(series.force), Resultants(estimate(series.read(level))[:, :3]))
        for key, name in TABLE.items():
            for share in PERCENTILES:
                summary[f"{key}_{share}_at_{level:g}"] = float(np.percentile(every[name], share))
    return summary


def threshold(sensor: SensorArray, estimate: Estimate, count: int = COUNT) -> float:
    """Return the uncertainty over |F_z| that ``FALSE_ALARMS`` of quiet single contacts exceed."""
    outputs = estimate(Series.of(sensor, count, LIMIT_SEED).read(QUIET))
    return float(np.quantile(outputs[:, 3] / np.abs(outputs[:, 2]), 1 - FALSE_ALARMS))
