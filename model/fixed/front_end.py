"""The front end between the converters and the core: words of 16 bits become codes, exactly as in the gateware."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Ints
from tfra.model.converter import Measured
from tfra.model.fixed.numbers import round_shift, saturate
from tfra.model.fixed.repair import HEADER, PLACE, repaired

WORD = 16
"""Bits of a converter's word, of which the low ones are used."""
LEAST_WORD = 8
"""Fewest bits of a word that are used."""
DEVIATION = 18
"""Bits of a mean less its offset, signed, in 1/2^17 of the converter's range; also those of an offset."""
GAIN = 17
"""Bits of a gain, unsigned."""
LARGEST_GAIN = (1 << GAIN) - 1
UNITY = 1 << 15
"""The gain 1."""
WEIGHT = 18
"""Bits of a weight of a repair, signed, in 1/65536."""
PRODUCT_POINT = 32
"""Of a product of deviation and gain, this less the bits of a code are below the code's point."""
MOST_AVERAGED = 6
"""Largest log2 of the frames of a mean."""
OLDEST = 255
"""A taxel's word is counted for so many frames at most."""

MOST_TAXELS = HEADER >> PLACE
"""A word of a repair can name no more."""

FAULTS = ("saturation", "out_of_range", "stuck")
"""Faults of a taxel."""


def repair_places(taxels: int) -> int:
    """Words of the table of repairs: enough for a tenth of the ``taxels``, each with twelve neighbours; a power of two.

    A block memory has 512 places at least.
    """
    return max(512, 1 << (13 * -(-taxels // 10) - 1).bit_length())


def supported(array: Measured) -> bool:
    """Whether the front end can be built for a design or a skin."""
    return LEAST_WORD <= array.adc.bits <= WORD and array.sensor.taxels <= MOST_TAXELS


def check(array: Measured) -> None:
    """Raise ``ValueError`` for a design or a skin that it can't be built for."""
    bits, taxels = array.adc.bits, array.sensor.taxels
    if not LEAST_WORD <= bits <= WORD:
        raise ValueError(f"adc.bits: {LEAST_WORD} to {WORD} are supported with the front end, got {bits}")
    if not supported(array):
        raise ValueError(f"sensor: up to {MOST_TAXELS} taxels are supported with the front end, got {taxels}")


@dataclass(frozen=True, slots=True)
class Settings:
    """Registers of the front end (docs/registers.md); all but ``word_bits`` are those after a reset.

    Raises ``ValueError`` that names a setting outside its range.
    """

    word_bits: int
    is_unsigned: bool = False
    invert: bool = False
    log2_average: int = 0
    log2_tare: int = 0
    dead_band: int = 0
    contact: int = 0
    stuck_frames: int = 0
    check_sequence: bool = False

    def __post_init__(self) -> None:
        ranges = {
            "word_bits": (LEAST_WORD, WORD),
            **dict.fromkeys(("log2_average", "log2_tare"), (0, MOST_AVERAGED)),
            **dict.fromkeys(("dead_band", "contact"), (0, (1 << 16) - 1)),
            "stuck_frames": (0, OLDEST),
        }
        for name, (least, most) in ranges.items():
            if not least <= getattr(self, name) <= most:
                raise ValueError(f"{name}: {least} to {most} is supported, got {getattr(self, name)}")


@dataclass(frozen=True, eq=False)
class Tables:
    """``offsets (m,)`` and ``gains (m,)`` of the taxels, row by row, and ``repairs (k,)``, words of that table.

    Raises ``ValueError`` for a number that its table can't hold.
    """

    offsets: Ints
    gains: Ints
    repairs: Ints

    def __post_init__(self) -> None:
        half = 1 << (DEVIATION - 1)
        for name, least, most in (("offsets", -half, half - 1), ("gains", 0, LARGEST_GAIN)):
            wrong = (getattr(self, name) < least) | (getattr(self, name) > most)
            if wrong.any():
                taxel = int(np.argmax(wrong))
                given = getattr(self, name)[taxel]
                raise ValueError(f"{name}: {least} to {most} is supported, taxel {taxel} has {given}")
        if len(self.repairs) > repair_places(len(self.gains)):
            places = repair_places(len(self.gains))
            raise ValueError(f"repairs: the table has {places} places, got {len(self.repairs)} words")

    @classmethod
    def of(cls, taxels: int) -> "Tables":
        """The tables at power-up."""
        none = np.zeros(0, dtype=np.int64)
        return cls(np.zeros(taxels, dtype=np.int64), np.full(taxels, UNITY, dtype=np.int64), none)


@dataclass(frozen=True, eq=False)
class Cleaned:
    """Frames for the core, and the faults of all frames that came.

    ``codes (k, rows, columns)``; ``last (k,)`` is the frame that each is the mean up to; ``flags`` by name, ``(k,)``;
    ``faults (n, m, 3)`` of all frames in the order of ``FAULTS``, none in frames that are not whole; ``gap (n,)``.
    """

    codes: Ints
    last: Ints
    flags: dict[str, Bools]
    faults: Bools
    gap: Bools


class FrontEnd:
    """The bit-accurate model, with its state from call to call; ``tables`` may be exchanged at any time."""

    def __init__(self, design: Measured, settings: Settings | None = None, tables: Tables | None = None) -> None:
        check(design)
        self.design = design
        self.settings = settings or Settings(design.adc.bits)
        self.tables = tables or Tables.of(design.sensor.taxels)
        self.taring = False
        self.reset()

    def reset(self) -> None:
        """A soft reset: means, a tare and what is known of words before start anew; settings and tables stay."""
        taxels = self.design.sensor.taxels
        self.taring = False
        self._word, self._age = np.full(taxels, -1, dtype=np.int64), np.zeros(taxels, dtype=np.int64)
        self._user: int | None = None
        self._start_mean()

    def tare(self) -> None:
        """Average the next frames for the offsets."""
        self.taring = True
        self._start_mean()

    def _start_mean(self) -> None:
        self._sum = np.zeros(self.design.sensor.taxels, dtype=np.int64)
        self._seen = np.zeros(len(FAULTS) + 1, dtype=np.int64)
        self._number = 0

    def __call__(self, frames: Ints, users: npt.ArrayLike | None = None, whole: Bools | None = None) -> Cleaned:
        """Codes of ``frames (n, rows, columns)``, words of 16 bits, 0 to 65535.

        ``users (n,)`` are the frames' numbers, 0, 1, ... by default.  Of frames that are not ``whole (n,)``, only the
        number counts.
        """
        raw = np.asarray(frames, dtype=np.int64).reshape(-1, self.design.sensor.taxels)
        whole = np.ones(len(raw), dtype=bool) if whole is None else whole
        gap = self._gaps(np.arange(len(raw)) if users is None else np.asarray(users, dtype=np.int64))
        faults = np.zeros((*raw.shape, len(FAULTS)), dtype=bool)
        value, faults[whole, :, 0], faults[whole, :, 1] = self.read(raw[whole])
        faults[whole, :, 2] = self._stuck(raw[whole])
        faults &= (self.tables.gains > 0)[:, None]
        seen = np.concatenate([faults.any(axis=1), gap[:, None]], axis=1)[whole]
        begin = self._tare(value, seen) if self.taring else 0
        totals, some, last = self._mean(value[begin:], seen[begin:], self.settings.log2_average)
        codes = self.codes(self.mean(totals, self.settings.log2_average))
        flags = dict(zip((*FAULTS, "sequence_gap"), some.T > 0, strict=True))
        shape = (-1, self.design.sensor.rows, self.design.sensor.columns)
        return Cleaned(codes.reshape(shape), np.flatnonzero(whole)[begin:][last], flags, faults, gap)

    def read(self, raw: Ints) -> tuple[Ints, Bools, Bools]:
        """Values ``(n, m)`` of words, times 2^(16 - word_bits); whether saturated; whether out of range."""
        bits, half = self.settings.word_bits, 1 << (self.settings.word_bits - 1)
        value = raw & ((1 << bits) - 1)
        if not self.settings.is_unsigned:
            value = (value ^ half) - half
        lowest = 0 if self.settings.is_unsigned else -half
        saturated = (value == lowest) | (value == lowest + 2 * half - 1)
        return value << (WORD - bits), saturated, (value & 0xFFFF) != raw

    def _stuck(self, raw: Ints) -> Bools:
        """Whether each word of ``raw (n, m)`` has been the same for the stated number of frames."""
        if not len(raw):
            return np.zeros(raw.shape, dtype=bool)
        before = np.concatenate([self._word[None], raw[:-1]])
        number = np.arange(len(raw))[:, None]
        changed = np.maximum.accumulate(np.where(raw != before, number, -1), axis=0)
        age = np.where(changed < 0, number + 1 + self._age, number - changed + 1)
        age = np.minimum(age, OLDEST)
        self._word, self._age = raw[-1], age[-1]
        frames = self.settings.stuck_frames
        return (age >= frames) & (frames > 0)

    def _gaps(self, users: Ints) -> Bools:
        """Whether the number of each frame does not follow that of the frame before."""
        if not self.settings.check_sequence or not len(users):
            self._user = None
            return np.zeros(len(users), dtype=bool)
        first = users[0] - 1 if self._user is None else self._user
        before = np.concatenate([[first], users[:-1]])
        self._user = int(users[-1])
        return np.asarray((users - before) % (1 << 16) != 1)

    def _tare(self, value: Ints, seen: Bools) -> int:
        """Take the frames of a tare; return how many."""
        left = (1 << self.settings.log2_tare) - self._number
        totals, _, last = self._mean(value[:left], seen[:left], self.settings.log2_tare)
        if len(last):
            offsets = self.mean(totals[0], self.settings.log2_tare)
            self.tables = Tables(offsets, self.tables.gains, self.tables.repairs)
            self.taring = False
            self._start_mean()
        return min(left, len(value))

    def _mean(self, value: Ints, seen: Bools, log2: int) -> tuple[Ints, Ints, Ints]:
        """Sums ``(k, m)`` of 2^log2 frames each, how many had each fault ``(k, 4)``, and the last of each ``(k,)``."""
        ends = np.flatnonzero((self._number + 1 + np.arange(len(value))) % (1 << log2) == 0)
        sums, self._sum = _grouped(value, self._sum, ends)
        counts, self._seen = _grouped(seen.astype(np.int64), self._seen, ends)
        self._number = len(value) - 1 - int(ends[-1]) if len(ends) else self._number + len(value)
        return sums, counts, ends

    @staticmethod
    def mean(sums: Ints, log2: int) -> Ints:
        """Means in 1/2^17 of the range; 18 bits, since a value has 17 and an unsigned one is not negative."""
        return round_shift(2 * sums, log2)

    def codes(self, means: Ints) -> Ints:
        """Codes ``(n, m)`` of ``means (n, m)``, which are below 2^17; products are below 2^34."""
        bits, settings = self.design.adc.bits, self.settings
        gains = -self.tables.gains if settings.invert else self.tables.gains
        deviation = saturate(means - self.tables.offsets, DEVIATION)
        codes = saturate(round_shift(deviation * gains, PRODUCT_POINT - bits), bits)
        largest = np.abs(codes).max(axis=1)
        codes, written = repaired(codes, self.tables.repairs, bits)
        silent = np.maximum(largest, written) < settings.contact
        return np.where(silent[:, None] | (np.abs(codes) < settings.dead_band), 0, codes)


def _grouped(values: Ints, before: Ints, ends: Ints) -> tuple[Ints, Ints]:
    """Sums of ``values (n, ...)`` up to each of ``ends`` from the one before, the first with ``before``; the rest."""
    running = np.concatenate([np.zeros((1, *values.shape[1:]), dtype=np.int64), np.cumsum(values, axis=0)]) + before
    at = np.concatenate([np.zeros((1, *values.shape[1:]), dtype=np.int64), running[ends + 1]])
    return np.diff(at, axis=0), running[-1] - at[-1]
