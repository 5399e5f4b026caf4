"""Generations of designs: a sampler chooses them, workers measure them, a table keeps them.

All designs of a generation are chosen before any of them is measured, from those of the generations before and from a
seed of (search, generation).  So the trials are the same, bit for bit, for any number of workers and after any
interruption; a trial in the table is not measured again.
"""

import hashlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import optuna
import polars as pl
from optuna.distributions import BaseDistribution, IntDistribution
from optuna.samplers import BaseSampler, NSGAIISampler, RandomSampler
from optuna.trial import TrialState, create_trial

from tfra.study.search.space import Point, Space
from tfra.study.search.trials import COMPLETE, UNFIT, Trial, Trials
from tfra.study.workers import Workers

optuna.logging.set_verbosity(optuna.logging.WARNING)

SAMPLERS: Mapping[str, Callable[[int, int], BaseSampler]] = {
    "nsga2": lambda size, seed: NSGAIISampler(population_size=size, seed=seed),
    "random": lambda size, seed: RandomSampler(seed=seed),
}
"""From the size of a generation and a seed: what chooses; ``"random"`` is the baseline."""


@dataclass(frozen=True)
class Measured:
    """Objectives of a point by name; ``state`` is COMPLETE, or STOPPED with those of few frames, or UNFIT."""

    state: str
    values: Mapping[str, float]
    reason: str = ""


Measure = Callable[[Point], Measured]
"""The job of a worker; it and its result can be pickled."""


@dataclass(frozen=True)
class Search:
    """Definition of a search: ``objectives`` are names of values to minimise.

    ``generations`` of ``size`` points; ``sampler`` is one of SAMPLERS.
    """

    space: Space
    objectives: tuple[str, ...]
    generations: int
    size: int
    seed: int
    sampler: str = "nsga2"

    def run(self, measure: Measure, trials: Trials, workers: Workers) -> Iterator[Trial]:
        """Every trial in order of completion, those of the table first; each is in the table before it is yielded.

        Other processes may work on the same table; trials that they have finished before a generation begins are not
        measured again.
        Raises :class:`EmptySpaceError` if no point of the first generation fits together.
        """
        known: dict[int, Trial] = {}
        for generation in range(self.generations):
            known |= {trial.number: trial for trial in trials()}
            before = [known[number] for number in range(generation * self.size)]
            chosen = self._choose(generation, before)
            yield from (known[trial.number] for trial in chosen if trial.number in known)
            for trial in self._measure(chosen, known, measure, trials, workers):
                known[trial.number] = trial
                yield trial
            if generation == 0:
                first = [known[trial.number] for trial in chosen]
                if all(trial.state == UNFIT for trial in first):  # then more points would not fit together, either
                    raise EmptySpaceError(f"none of {len(first)} points fits together; of the last, {first[-1].reason}")

    def _choose(self, generation: int, before: Sequence[Trial]) -> list[Trial]:
        """The points of a generation, not measured yet."""
        sampler = SAMPLERS[self.sampler](self.size, self._seed(generation))
        study = optuna.create_study(directions=["minimize"] * len(self.objectives), sampler=sampler)
        distributions = {name: IntDistribution(0, len(o) - 1) for name, o in self.space.options.items()}
        study.add_trials([self._as_optuna(trial, distributions) for trial in before])
        chosen = []
        for number in range(generation * self.size, (generation + 1) * self.size):
            asked = study.ask(dict(distributions))
            attributes = dict(study.get_trials(deepcopy=False)[-1].system_attrs)
            chosen.append(Trial(number, "", dict(asked.params), attributes=attributes))
        return chosen

    def _seed(self, generation: int) -> int:
        text = f"{self.seed} {generation} {sorted(self.space.options.items())} {self.objectives} {self.size}"
        return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=4).digest(), "little")

    def _as_optuna(self, trial: Trial, distributions: Mapping[str, BaseDistribution]) -> Any:
        """A trial of the table for the sampler; only complete ones count as parents."""
        complete = trial.state == COMPLETE
        return create_trial(
            params=dict(trial.indices),
            distributions=dict(distributions),
            values=[trial.values[name] for name in self.objectives] if complete else None,
            state=TrialState.COMPLETE if complete else TrialState.FAIL,
            system_attrs=dict(trial.attributes),
        )

    def _measure(
        self, chosen: Sequence[Trial], known: Mapping[int, Trial], measure: Measure, trials: Trials, workers: Workers
    ) -> Iterator[Trial]:
        """The points that are not in the table yet; no point is measured twice."""
        done = {_key(trial): trial for trial in known.values()}
        waiting: dict[tuple[tuple[str, int], ...], list[Trial]] = {}
        for trial in chosen:
            if trial.number not in known:
                waiting.setdefault(_key(trial), []).append(trial)
        again = [key for key in waiting if key in done]
        for key in again:
            yield from _store(waiting.pop(key), done[key], trials, 0.0)
        groups, start = list(waiting.values()), time.perf_counter()
        for position, measured in workers(measure, [self.space.point(group[0].indices) for group in groups]):
            yield from _store(groups[position], measured, trials, time.perf_counter() - start)


def _key(trial: Trial) -> tuple[tuple[str, int], ...]:
    return tuple(sorted(trial.indices.items()))


def _store(same: Sequence[Trial], measured: Measured | Trial, trials: Trials, seconds: float) -> Iterator[Trial]:
    """Trials of one point, each in the table before it is yielded."""
    for trial in same:
        finished = replace(trial, state=measured.state, values=dict(measured.values), reason=measured.reason)
        trials.add(finished, seconds)
        yield finished


class EmptySpaceError(ValueError):
    """No point of a space that was tried fits together."""


def front(trials: Iterable[Trial], objectives: Sequence[str]) -> list[Trial]:
    """Complete trials that no other is at least as good as in every objective; of equal ones, the first."""
    complete = [trial for trial in trials if trial.state == COMPLETE]
    values = {trial.number: tuple(trial.values[name] for name in objectives) for trial in complete}
    best: list[Trial] = []
    for trial in sorted(complete, key=lambda trial: (values[trial.number], trial.number)):
        own = values[trial.number]
        if not any(all(a <= b for a, b in zip(values[other.number], own, strict=True)) for other in best):
            best.append(trial)
    return sorted(best, key=lambda trial: trial.number)


def trial_table(trials: Sequence[Trial], search: Search, quantities: Sequence[str]) -> pl.DataFrame:
    """A row each trial: its choices, objectives, errors of the ``quantities``, and whether it is on the front."""
    best = {trial.number for trial in front(trials, search.objectives)}
    rows = [
        {
            "number": trial.number,
            "generation": trial.number // search.size,
            "state": trial.state,
            **search.space.point(trial.indices),
            **{name: trial.values.get(name) for name in (*search.objectives, *quantities)},
            "front": trial.number in best,
            "reason": trial.reason,
        }
        for trial in trials
    ]
    return pl.DataFrame(rows, infer_schema_length=None)
