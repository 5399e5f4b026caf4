"""The errors of a skin by source: the steps of :mod:`tfra.study.errors.cascade`, contact by contact.

Every step finds contacts in whole frames and estimates the force in a window of each: in double precision on exact
stress, on stress with noise and offset, and on codes of the converter; then in the integers of the core.  The contacts
are found in codes at the last two steps alike, since finding is exact.  What is found is matched with what is there.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import polars as pl

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.choices import Adc
from tfra.model.converter import convert
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.model.metrics import rotation_deg
from tfra.model.sensor import SensorArray
from tfra.model.skin.matching import matched, seen_at
from tfra.model.skin.result import SkinResult, estimate
from tfra.model.skin.skin import Skin
from tfra.model.skin.smoothing import Number
from tfra.sim.compiled import quickest
from tfra.study.errors.cascade import Step, View, decision_column, error_column
from tfra.study.frames.block import Block, with_noise
from tfra.study.skins.crowds import contacts_of

SIGNED = {
    "force_difference_percent_of_true_force": False,
    "phi_deg": True,
    "mu": True,
    "place_pitches": False,
}
"""Every quantity of a contact, and whether its error has a sign; the place is that of the region's centroid."""


class Known(NamedTuple):
    """k contacts: ``resultant (k, 3)`` in N, ``mu``, ``phi_deg``, and ``place (k, 2)`` in pitches along x and y."""

    resultant: Floats
    mu: Floats
    phi_deg: Floats
    place: Floats

    @classmethod
    def found(cls, result: SkinResult, sensor: SensorArray) -> "Known":
        """All contacts of a ``result``."""
        windows = result.windows
        return cls(windows.resultant, windows.mu, windows.phi_deg, _places(result, sensor))

    def at(self, which: Ints) -> "Known":
        """The contacts ``which``."""
        return Known(*(values[which] for values in self))


class Truth:
    """The contacts that are there in a ``block``: their ``table``, their ``frame (k,)`` in it, and what is ``known``.

    ``seen (k, 2)`` is where their regions should be, in pitches.
    """

    def __init__(self, block: Block, sensor: SensorArray) -> None:
        self.table, self.frame = contacts_of(block)
        force, center = (
            self.table.select(names).to_numpy()
            for names in (("force_x_n", "force_y_n", "force_z_n"), ("center_x_m", "center_y_m"))
        )
        mu, phi = (self.table[name].to_numpy() for name in ("mu", "phi_deg"))
        self.known = Known(force, mu, phi, center / np.array([sensor.pitch_x, sensor.pitch_y]))
        self.seen = seen_at(center, force, sensor)


class SkinCascade:
    """The steps of ``skin`` on one ``block``, for any designs of its windows that estimate alike in float.

    ``normal`` returns the noise of the block at unit deviation, for other noise than the frames' own.
    """

    def __init__(self, skin: Skin, block: Block, normal: Callable[[], Floats]) -> None:
        self._skin, self._exact, self._normal = skin, block, normal
        self._truth = Truth(block, skin.sensor)
        self._in_float: dict[tuple[Adc, float | None], dict[Step, _Found]] = {}  # the last one alone

    def __call__(
        self, design: Design, compared: Sequence[Step] = tuple(Step), noise: float | None = None
    ) -> pl.DataFrame:
        """A row each contact that is there, with windows of ``design``.

        ``frame``, ``contacts`` in it, ``gap_pitches`` to the nearest, whether all steps find it, ``everywhere``.  Of
        each of the steps ``compared``, whether it is ``missed``, and ``merged``: another one takes its place; the
        ``status`` where it is found; errors by :func:`error_column` of those found everywhere.  The first contact of a
        frame has the numbers of those ``seen`` there, and of those ``invented``.  ``noise`` is a deviation as a share
        of the peak instead of the frame's own.
        """
        truth, skin = self._truth, replace(self._skin, window=design)
        steps = self._steps(skin, noise)
        everywhere = np.logical_and.reduce([found.at >= 0 for found in steps.values()])
        both = np.flatnonzero(everywhere)
        columns: dict[str, npt.NDArray[Any]] = {
            "frame": self._exact.start + truth.frame,
            "contacts": np.bincount(truth.frame)[truth.frame],
            "gap_pitches": truth.table["gap_pitches"].to_numpy(),
            "everywhere": everywhere,
        }
        there = before = truth.known.at(both)
        for step, found in steps.items():
            own = found.known.at(found.at[both])
            if step in compared:
                columns |= {decision_column(name, step): values for name, values in self._decisions(found).items()}
                for view, start in ((View.TOTAL, there), (View.OWN, before)):
                    for key, error in differences(there, start, own).items():
                        values = np.full(len(everywhere), np.nan, dtype=np.float32)
                        values[both] = error
                        columns[error_column(key, step, view)] = values
            before = own
        return pl.DataFrame(columns)

    def _steps(self, skin: Skin, noise: float | None) -> "dict[Step, _Found]":
        key = skin.adc, noise
        if key not in self._in_float:
            self._in_float = {key: self._make(skin, noise)}
        steps = self._in_float[key]
        last = steps[Step.CONVERTER]
        found, cut = skin.find(last.frames)
        windows = decode(skin.window, quickest(skin.window)(cut))
        known = last.known._replace(resultant=windows.resultant, mu=windows.mu, phi_deg=windows.phi_deg)
        status = windows.status | found.marks
        return {**steps, Step.ARITHMETIC: last._replace(known=known, status=status)}

    def _make(self, skin: Skin, noise: float | None) -> "dict[Step, _Found]":
        """The steps in float."""
        noisy, lsb, in_float = self._noisy(noise), skin.adc.lsb, skin.window.float_model
        return {
            Step.METHOD: self._found(skin, self._exact.stress, in_float),
            Step.NOISE: self._found(skin, noisy, in_float),
            Step.CONVERTER: self._found(skin, convert(skin, noisy), lambda cut: in_float(cut * lsb)),
        }

    def _noisy(self, noise: float | None) -> npt.NDArray[np.float32]:
        if noise is None:
            return self._exact.noisy
        offset = self._exact.truth["offset_share_of_peak"].to_numpy()
        return with_noise(self._exact.stress, noise, offset, self._normal())

    def _found(self, skin: Skin, frames: npt.NDArray[Number], windows: Callable[[Any], Any]) -> "_Found":
        result, truth = estimate(skin, frames, windows), self._truth
        true, seen = matched((truth.frame, result.frame), (truth.seen, _places(result, skin.sensor)))
        at = np.full(len(truth.frame), -1)
        at[true] = seen
        merged = np.zeros(len(at), dtype=np.bool_)
        missed = np.flatnonzero(at < 0)
        if len(missed):
            which, row = np.unique(truth.frame[missed], return_inverse=True)
            size = np.array([skin.sensor.columns, skin.sensor.rows])
            column, line = np.clip(np.rint(truth.seen[missed]).astype(np.int64), 0, size - 1).T
            merged[missed] = skin.taken(frames[which])[row, line, column]
        return _Found(frames, Known.found(result, skin.sensor), result.windows.status, result.frame, at, merged)

    def _decisions(self, found: "_Found") -> dict[str, npt.NDArray[Any]]:
        frame = self._truth.frame
        first = np.diff(frame, prepend=-1) > 0
        count = len(self._exact)
        seen = np.bincount(found.frame, minlength=count)
        matches = np.bincount(frame[found.at >= 0], minlength=count)
        return {
            "missed": found.at < 0,
            "merged": found.merged,
            "status": np.where(found.at >= 0, found.status[found.at] if len(found.status) else 0, 0),
            "seen": np.where(first, seen[frame], 0),
            "invented": np.where(first, (seen - matches)[frame], 0),
        }


class _Found(NamedTuple):
    """The contacts that a step finds in its ``frames``: what is ``known`` of them, ``status`` and ``frame`` of each.

    ``at (k,)``: the one that belongs to each contact that is there, or -1; ``merged (k,)``: others take its place.
    """

    frames: npt.NDArray[Any]
    known: Known
    status: Ints
    frame: Ints
    at: Ints
    merged: Bools


def differences(truth: Known, start: Known, end: Known) -> dict[str, Floats]:
    """Return the differences between two estimates of the same contacts, by the keys of ``SIGNED``, ``(k,)`` each.

    Percentages are of the ``truth``; those of undefined directions are nan.
    """
    length, modulus = (np.linalg.norm(v, axis=1) for v in (end.resultant - start.resultant, truth.resultant))
    values = (
        100 * length / modulus,
        rotation_deg(start.phi_deg, end.phi_deg),
        end.mu - start.mu,
        np.linalg.norm(end.place - start.place, axis=1),
    )
    return dict(zip(SIGNED, values, strict=True))


def _places(result: SkinResult, sensor: SensorArray) -> Floats:
    """Centroids of regions in pitches, ``(k, 2)``."""
    return np.stack([result.x / sensor.pitch_x, result.y / sensor.pitch_y], axis=1)
