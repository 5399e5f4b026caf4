"""Verify the core of a skin: every word of its records against the bit-accurate model, contacts in double precision.

A third of the frames runs without stalls, a third with each of the other patterns.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.converter import quantise
from tfra.model.cover.scenes import wild_codes
from tfra.model.fixed.layout import Field
from tfra.model.skin.finding import Mark
from tfra.model.skin.records import decode_records, ends, record_layout, records
from tfra.model.skin.result import SkinResult, estimate
from tfra.model.skin.scenes import recorded
from tfra.model.skin.skin import Skin
from tfra.model.tfra import Status
from tfra.sim import tools
from tfra.sim.pattern_run import PATTERNS
from tfra.sim.run import ProtocolError, Run, simulate
from tfra.sim.skin_report import SkinReport
from tfra.sim.verify import SPECIAL


def verify_skin(
    skin: Skin,
    frames: npt.ArrayLike | None = None,
    simulator: str | None = None,
    seed: int = 0,
    random: int = 200,
    progress: Callable[[int, int], None] | None = None,
    waves: Path | None = None,
) -> SkinReport:
    """Simulate the core of ``skin`` and compare every word of its records with the bit-accurate model.

    Args:
        frames: Stresses ``(n, rows, columns)`` in Pa, before the made-up frames.
        simulator: As for :func:`tfra.sim.run.simulate`.
        seed: Of random frames and of stalls.
        random: Random frames to add.
        progress: Called with numbers of frames that have finished, and of all.
        waves: A VCD file to write: the signals of the first frame, up to the one that differs.

    Raises as :func:`tfra.sim.verify.verify`.
    """
    given = np.empty((0, skin.sensor.rows, skin.sensor.columns)) if frames is None else np.asarray(frames)
    parts = {"given": quantise(skin, given), "random": wild_codes(skin, random, seed), "directed": recorded(skin)}
    codes = np.concatenate(list(parts.values()))
    chosen = tools.choose(simulator)
    runs = [
        _Run.of(skin, codes, number, chosen, seed, (lambda done: progress(done, len(codes))) if progress else None)
        for number in range(min(len(codes), len(PATTERNS)))
    ]
    wrong = next((run for run in runs if run.first is not None), None)
    shown = (wrong or runs[0]).record(waves) if waves else None
    found = [decode_records(skin, run.run.words) for run in runs if run.run is not None]
    interval = runs[0].run.interval if runs[0].run is not None else np.empty(0)
    return SkinReport(
        name=skin.name,
        simulator=chosen,
        seed=seed,
        kinds={kind: len(part) for kind, part in parts.items() if len(part)},
        contacts=sum(len(each.frame) for each in found),
        words=sum(run.expected.size for run in runs),
        compared=sum(run.compared for run in runs),
        mismatches=sum(run.mismatches for run in runs),
        first=str(wrong) if wrong else None,
        violations=tuple(f"stalls {run.pattern}: {note}" for run in runs for note in run.violations),
        cycles=(float(np.median(interval)), int(interval.max())) if len(interval) else None,
        marks=_marks(found),
        against_float=_against_float(skin, [run for run in runs if run.first is None and run.run is not None]),
        recorded=shown,
    )


@dataclass
class _Run:
    """Every third frame, from frame ``number`` on, with the stalls ``PATTERNS[number]``."""

    skin: Skin
    codes: Ints
    number: int
    simulator: str
    seed: int
    expected: Ints
    run: Run | None = None
    """None where the core broke a rule of its streams."""
    violations: tuple[str, ...] = ()
    compared: int = 0
    mismatches: int = 0
    first: tuple[int, int] | None = None
    """Record and word of the first mismatch."""

    @classmethod
    def of(
        cls, skin: Skin, codes: Ints, number: int, simulator: str, seed: int, progress: Callable[[int], None] | None
    ) -> "_Run":
        part = codes[number :: len(PATTERNS)]
        expected = records(skin, part, skin.window.model.words)
        made = cls(skin, part, number, simulator, seed, expected)
        try:
            made.run = made.simulate(progress=progress)
        except ProtocolError as error:
            made.violations = tuple(error.outcome.violations)
            made.compared, made.mismatches = error.outcome.compared, error.outcome.mismatches
            return made
        different = np.argwhere(made.run.words != expected)
        made.compared, made.mismatches = made.run.compared, len(different)
        if len(different):
            made.first = (int(different[0, 0]), int(different[0, 1]))
        return made

    @property
    def pattern(self) -> str:
        """Name of the pattern of stalls."""
        return PATTERNS[self.number]

    def simulate(self, count: int | None = None, **options: Any) -> Run:
        """Run the first ``count`` frames, by default all."""
        last = np.flatnonzero(ends(self.skin, self.expected))
        expected = self.expected if count is None else self.expected[: last[count - 1] + 1]
        options |= {"expected": expected}
        stalls = self.pattern, self.pattern
        return simulate(self.skin, self.codes[:count], self.simulator, self.seed + self.number, *stalls, **options)

    def record(self, waves: Path) -> int:
        """Write the signals of the frames up to the wrong one, or of the first one; return its number."""
        frame = self._frame() if self.first else 0
        with suppress(ProtocolError):  # which has been told
            self.simulate(frame + 1, waves=waves)
        return self._original(frame)

    def _original(self, frame: int) -> int:
        """Number among all frames of a frame of this run."""
        return self.number + frame * len(PATTERNS)

    def _frame(self) -> int:
        """The frame of the first mismatch, among those of this run."""
        assert self.first
        return int(ends(self.skin, self.expected[: self.first[0]]).sum())

    def __str__(self) -> str:
        assert self.first
        assert self.run
        record, word = self.first
        field = _field(self.skin, word)
        frame, contact = self._original(self._frame()), int(self.expected[record, 1])
        return (
            f"frame {frame} (stalls: {self.pattern}), contact {contact}, field {field.name}, word {word}: "
            f"{self.expected[record, word]} expected, {self.run.words[record, word]} observed"
        )


def _field(skin: Skin, word: int) -> Field:
    return next(field for field in record_layout(skin) if field.start <= word < field.start + field.count)


def _marks(found: list[SkinResult]) -> dict[str, int]:
    """Contacts with each mark and status bit that any has."""
    every = np.concatenate([each.windows.status for each in found]) if found else np.empty(0, dtype=np.int64)
    counts = {str(flag.name): int((every & flag != 0).sum()) for flag in (*Mark, *Status)}
    return {name: count for name, count in counts.items() if count}


def _against_float(skin: Skin, runs: list[_Run]) -> dict[str, float] | None:
    """The core against double precision on the same codes, contact by contact of frames that have the same ones."""
    far: dict[str, list[Floats]] = {"mu": [], "force": []}
    for run in runs:
        assert run.run
        core = decode_records(skin, run.run.words)
        exact = estimate(skin, run.codes * skin.adc.lsb, skin.window.float_model)
        same = (core.found == exact.found)[core.frame]
        pair = (exact.found == core.found)[exact.frame]
        regular = _regular(core)[same] & _regular(exact)[pair]
        ours, theirs = core.windows, exact.windows
        far["mu"].append(np.abs(ours.mu[same] - theirs.mu[pair])[regular])
        size = np.linalg.norm(theirs.resultant[pair], axis=1)[regular]
        gap = np.linalg.norm(ours.resultant[same] - theirs.resultant[pair], axis=1)[regular]
        far["force"].append(100 * gap / size)
    every = {name: np.concatenate(parts) for name, parts in far.items() if parts}
    if not every or not len(every["mu"]):
        return None
    names = {"mu": "mu against double precision", "force": "F against double precision / %"}
    return {
        f"{names[name]}, {word}": float(of(values))
        for name, values in every.items()
        for word, of in (("median", np.median), ("largest", np.max))
    }


def _regular(found: SkinResult) -> Bools:
    """Contacts whose words were not limited, and that have something to find."""
    return np.asarray(found.windows.status & sum(SPECIAL) == 0)
