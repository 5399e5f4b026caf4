"""From the numbers of a recording to stress in Pa: what the front end before the core does, in its words for codes."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.choices import Adc
from tfra.model.fixed import front_end as fixed
from tfra.model.fixed.dead_taxels import repairs
from tfra.model.fixed.repair import filled
from tfra.model.sensor import SensorArray
from tfra.recordings.calibration import Calibration, marked
from tfra.recordings.input import PASCALS, Input, codes_of

_FIRST = 16
"""Frames that are looked at for the next contact, twice as many each time there is none."""


@dataclass(frozen=True, slots=True)
class Array:
    """All taxels, and the converter of each."""

    sensor: SensorArray
    adc: Adc


class FrontEnd:
    """Makes stress of frames one after the other, as ``given`` says; its state are the offsets that it follows.

    ``rest (k, rows, columns)``, in the recording's unit, shows the array at rest; ``known`` is of each taxel.  Codes
    become codes of the core by :class:`tfra.model.fixed.front_end.FrontEnd`, word by word, wherever that can be built;
    other numbers are doubles.

    Raises ``ValueError`` that starts with a key of ``given`` for one that does not fit the array.
    """

    def __init__(
        self, array: Array, given: Input, rest: Floats | None = None, known: Calibration | None = None
    ) -> None:
        self._array, self._given, self._pascals = array, given, pascals_per(given, array.adc)
        first, last = codes_of(given.coding, array.adc.bits)
        if given.rest_code is not None and not first <= given.rest_code <= last:
            reason = f"{given.coding} codes of {array.adc.bits} bits are from {first} to {last}"
            raise ValueError(f"rest_code: {reason}, got {given.rest_code:g}")
        known, shape = known or Calibration.none(array.sensor), (array.sensor.rows, array.sensor.columns)
        levels = known.rest if given.rest_code is None else None
        usual = np.full(shape, given.level_at_rest(array.adc.bits)) if levels is None else levels
        self._offset = usual
        if rest is not None:
            self.tare(rest)
        self._dead = marked(given.dead, shape) | known.dead
        if self._dead.all():
            raise ValueError("dead: at least one taxel has to be alive")
        self._gain = known.gain
        self._repairs = repairs(array.sensor, self._dead)
        self._core = None
        if given.unit == "codes" and fixed.supported(array):
            if (largest := self._gains.max()) > fixed.LARGEST_GAIN:
                most, found = (array.adc.lsb * gain / fixed.UNITY for gain in (fixed.LARGEST_GAIN, largest))
                raise ValueError(f"pa_per_code: with the gains, up to {most:.6g} is supported, got {found:.6g}")
            # its offsets are 0: they are subtracted before, since they may move
            self._core = fixed.FrontEnd(array, self.settings, self._tables(np.zeros(shape)))

    def tare(self, rest: Floats) -> None:
        """Take the mean of frames ``rest (k, rows, columns)`` at rest, in the recording's unit, for the offset."""
        self._offset = rest.mean(axis=0)

    @property
    def alive(self) -> Bools:
        """Taxels whose numbers count, ``(rows, columns)``."""
        return ~self._dead

    @property
    def is_of_a_core(self) -> bool:
        """Whether a core can do the same: with codes of 8 to 16 bits."""
        return self._core is not None

    @property
    def tables(self) -> fixed.Tables:
        """Those of the core for the same recording; raises ``ValueError`` if it has other numbers than codes."""
        if not self.is_of_a_core:
            raise ValueError("unit: only codes of 8 to 16 bits go to the front end of a core")
        return self._tables(self._offset)

    def _tables(self, offset: Floats) -> fixed.Tables:
        return fixed.Tables(self._words(offset).ravel(), self._gains.ravel(), self._repairs)

    @property
    def settings(self) -> fixed.Settings:
        """Registers of the core for the same recording."""
        bits, given = self._array.adc.bits, self._given
        log2 = given.average.bit_length() - 1
        return fixed.Settings(bits, given.coding != "signed", given.compression == "positive", log2)

    def noise(self, rest: Floats) -> float:
        """The usual standard deviation of a taxel in Pa, in frames ``rest (k, rows, columns)`` at rest, k > 1."""
        factor = self._pascals * self._gain
        return float(np.median((rest.std(axis=0, ddof=1) * factor)[self.alive]))

    def __call__(self, levels: Floats) -> Floats:
        """Stress ``(n, rows, columns)`` in Pa, compression negative, of ``levels`` in the recording's unit.

        In doubles, a tare is a sum over its count, the subtraction and the product with the unit's factor each round
        once, and so does a repair; nothing is rounded if there is neither a tare nor a factor.
        """
        offset = self._followed(levels) if self._given.drift_frames else self._offset[None]
        if self._core:
            deviation = (self._words(levels) - self._words(offset)).reshape(len(levels), -1)
            return np.asarray(self._core.codes(deviation).reshape(levels.shape) * self._array.adc.lsb)
        stress = levels - offset if offset.any() else levels
        factor = self._pascals * self._gain
        if (factor != 1).any():
            stress = stress * factor
        stress = -stress if self._given.compression == "positive" else stress
        return self._repaired(stress) if self._dead.any() else stress

    @property
    def _gains(self) -> Ints:
        """Words of the taxels' gains in the core, ``(rows, columns)``."""
        gains = np.rint(fixed.UNITY * self._pascals / self._array.adc.lsb * self._gain).astype(np.int64)
        return np.where(self._dead, 0, gains)

    def _words(self, levels: Floats) -> Ints:
        """Means or offsets in 1/2^17 of the range, as the core's front end has them."""
        return np.floor(levels * 2.0 ** (fixed.DEVIATION - 1 - self._array.adc.bits) + 0.5).astype(np.int64)

    def _repaired(self, stress: Floats) -> Floats:
        return filled(stress.reshape(len(stress), -1), self._repairs).reshape(stress.shape)

    def _followed(self, levels: Floats) -> Floats:
        """The offset of each frame, ``(n, rows, columns)``: it moves in frames without contact, and waits in others."""
        offsets = np.empty_like(levels)
        at = 0
        for count, quiet in self._stretches(levels):
            part = slice(at, at + count)
            offsets[part] = self._offset
            if quiet:
                offsets[part], self._offset = _filtered(levels[part], self._offset, 1 / self._given.drift_frames)
            at += count
        return offsets

    def _stretches(self, levels: Floats) -> Iterator[tuple[int, bool]]:
        """Lengths of stretches of frames, and whether nothing presses in them, as the offset that was followed says."""
        adc = self._array.adc
        least = adc.threshold * adc.lsb / self._pascals
        at, size = 0, _FIRST
        while at < len(levels):
            part = levels[at : at + size]
            offsets, _ = _filtered(part, self._offset, 1 / self._given.drift_frames)
            moving = _pressed(part, offsets, self._dead, least)
            if not moving[0]:
                count = int(np.argmax(moving)) if moving.any() else len(part)
                size = 2 * size if count == len(part) else _FIRST
                yield count, True
            else:
                frozen = _pressed(part, self._offset[None], self._dead, least)
                count = len(part) if frozen.all() else int(np.argmin(frozen))
                size = 2 * size if count == len(part) else _FIRST
                yield count, False
            at += count


def pascals_per(given: Input, adc: Adc) -> float:
    """Stress of 1 in the unit of a recording, Pa.

    By default a code has that of the converter ``adc``, of a unipolar one half, since all of its bits are for one sign.
    """
    if given.unit != "codes":
        return PASCALS[given.unit]
    if given.pa_per_code is not None:
        return given.pa_per_code
    return adc.lsb / (2 if given.coding == "unipolar" else 1)


def _filtered(levels: Floats, offset: Floats, rate: float) -> tuple[Floats, Floats]:
    """The offset in front of each frame, ``(n, rows, columns)``, and after the last one: o + rate (level - o)."""
    from scipy.signal import lfilter

    start = ((1 - rate) * offset)[None]
    after, _ = lfilter([rate], [1, rate - 1], levels, axis=0, zi=start)
    return np.concatenate([offset[None], after[:-1]]), after[-1]


def _pressed(levels: Floats, offsets: Floats, dead: Bools, least: float) -> Bools:
    """Whether any taxel that is alive deviates by ``least`` or more, ``(n,)``."""
    return np.asarray((np.where(dead, 0.0, np.abs(levels - offsets)) >= least).any(axis=(1, 2)))
