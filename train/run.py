"""A training from its budget to the weights, with their errors on held-out frames."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from functools import cache, partial
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Protocol

import numpy as np
from pydantic import JsonValue

from tfra import codegen, model, runtime, train
from tfra.codegen.config.weights import Trained
from tfra.model.arrays import Floats
from tfra.model.learned.network import Network
from tfra.model.sensor import SensorArray
from tfra.runtime.digest import digest, sources
from tfra.runtime.store import Store, work_folder
from tfra.train import augment, heldout, patches, pool, prior, skins
from tfra.train.known import UNKNOWN, Known
from tfra.train.loop import BATCH, CHUNKS, COVERS, RATE, State, Trainer
from tfra.train.network import DOUBT, TANGENTIAL, UNEXPLAINED
from tfra.train.patches import Patches
from tfra.train.pool import Pool
from tfra.train.rounding import EXACT, Exact

SAVE_EVERY = 5.0
"""Seconds between two states in the working folder."""

TRIED = 100
"""Steps that are measured to make steps of minutes."""


CALIBRATION, ROUNDING = "training.calibration", "training.rounding"
"""The facts that only trainings for one sensor, or for the word lengths of a core, have."""


class Advance(Protocol):
    """Counts finished ``pieces`` of a stage; the ``state`` is that of the training."""

    def __call__(self, pieces: int, state: State | None = None) -> None: ...


Reporter = Callable[[str, int, int], AbstractContextManager[Advance]]
"""Function of a stage's name, the number of its pieces, and of those that are finished."""


@dataclass(frozen=True)
class Budget:
    """The user's choices: C1 and C2, the seed, and either steps or minutes, else those of the rounding.

    ``window``: the array is the window of a skin.
    """

    counts: tuple[int, int]
    seed: int
    steps: int | None = None
    minutes: float | None = None
    window: bool = False


def run(
    sensor: SensorArray,
    budget: Budget,
    folder: Path,
    reporter: Reporter,
    known: Known = UNKNOWN,
    rounding: Exact = EXACT,
) -> Trained:
    """Train the network of ``sensor``; the state is stored in ``folder``, where the same training continues.

    Its frames, and those of the errors, are of the array that is ``known``, which is no window.  The errors are those
    after ``rounding``, which has the counts of the ``budget``.

    Raises ``InputError`` for a folder that can't be used, and :class:`tfra.train.loop.DivergedError`.
    """
    facts = (sensor, budget, known.facts, *([rounding.facts] if rounding.facts else []))
    store, name = Store(folder), f"{digest(repr(facts))}.state"
    acting = known.under_cover(sensor)
    simulate = Patches.simulate if budget.window else partial(Pool.simulate, known=known.cover)
    with work_folder(folder, "training", fingerprint()):
        stored = _load(store, name)
        with reporter("simulating", COVERS, 0) as advance:
            trainer = Trainer(acting, budget.counts, budget.seed, advance, simulate, known, rounding)
        steps = budget.steps or rounding.steps
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
    network = partial(trainer.outputs, state.best) if rounding.facts else Network(sensor, weights)
    curve = np.array(state.curve, np.float64).reshape(-1, 3)
    tests = skins if budget.window else heldout

    def estimate(n: Floats) -> Floats:
        return network(known.delivered(n))

    return Trained(
        sensor,
        weights,
        tests.threshold(acting, estimate),
        training_facts(budget, steps, known, rounding),
        tests.held_out(acting, estimate),
        curve,
        budget.window,
    )


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


def training_facts(budget: Budget, steps: int, known: Known, rounding: Exact = EXACT) -> dict[str, JsonValue]:
    """Return the distribution of the training's frames, and the numbers that repeat the training.

    What is known of a sensor, ``CALIBRATION``, is there only if it is, and in the place of thickness, nu and gains;
    ``ROUNDING`` only if there is one.
    """
    numbers: dict[str, JsonValue] = {
        f"{section}.{name.lower()}": list(value) if isinstance(value, tuple) else value
        for section, module in (("prior", prior), ("prior", patches if budget.window else pool), ("augment", augment))
        for name, value in vars(module).items()
        if name.isupper() and isinstance(value, float | int | tuple)
    }
    loss = {"tangential": TANGENTIAL, "doubt": DOUBT, "unexplained": UNEXPLAINED}
    training = {
        "steps": steps,
        "seed": budget.seed,
        "batch": BATCH,
        "rate": RATE * rounding.pace,
        "covers": CHUNKS,
        **loss,
    }
    if known.facts:
        numbers[CALIBRATION] = known.facts
    if rounding.facts:
        numbers[ROUNDING] = dict(rounding.facts)
    return numbers | {f"training.{name}": value for name, value in training.items()}
