"""All choices that determine the model, the gateware and the reports, in one frozen object.

:class:`tfra.model.fixed.design.Design` derives everything else from them.
"""

import math
from dataclasses import dataclass, field
from typing import Literal

from tfra.families import FAMILIES
from tfra.model.rounding import Rounding
from tfra.model.sensor import SensorArray
from tfra.runtime.errors import quoted

Images = Literal["inline", "readmemh", "load"]
"""Source of the initial contents of memories: the Verilog itself, or files that it reads by ``$readmemh``; or the
Verilog itself, except for the coefficients, which are loaded after a reset."""


def _require(condition: bool, name: str, reason: str) -> None:
    if not condition:
        raise ValueError(f"{name}: {reason}")


def _require_between(name: str, bits: int, fewest: int, most: int) -> None:
    _require(fewest <= bits <= most, name, f"{fewest} to {most} bits are supported, got {bits}")


@dataclass(frozen=True, slots=True)
class Adc:
    """The converter behind every taxel: signed codes of ``bits``, +-``full_scale`` in Pa.

    ``contact_threshold`` in codes; ``None`` leaves it to :attr:`threshold`.
    """

    bits: int = 14
    full_scale: float = 200e3
    contact_threshold: int | None = None

    def __post_init__(self) -> None:
        _require(6 <= self.bits <= 20, "bits", f"6 to 20 is supported, got {self.bits}")
        good = math.isfinite(self.full_scale) and self.full_scale > 0
        _require(good, "full_scale", f"a positive, finite stress is needed, got {self.full_scale}")
        top = (1 << (self.bits - 1)) - 1
        fits = 0 <= self.threshold <= top
        _require(fits, "contact_threshold", f"0 to {top}, the largest code, is needed, got {self.threshold}")

    @property
    def threshold(self) -> int:
        """T in codes: a frame within -T ... T - 1 is no contact; 0 switches this off.

        By default 1/128 of full scale, but at least four codes: eight times the rms of noise of 0.1 % of full scale, or
        of half a code.
        """
        if self.contact_threshold is not None:
            return self.contact_threshold
        return max(4, (1 << (self.bits - 1)) // 128)

    @property
    def lsb(self) -> float:
        """Stress of one code, in Pa."""
        return math.ldexp(self.full_scale, 1 - self.bits)


@dataclass(frozen=True, slots=True)
class Search:
    """The sweep of mu_ind: ``steps`` + 1 candidates; a plateau reaches ``tolerance`` LSB over the minimum.

    The tolerance is a B^z, a sum over taxels, in units of one converter code.
    """

    steps: int = 100
    tolerance: float = 0.0

    def __post_init__(self) -> None:
        _require(1 <= self.steps <= 4096, "steps", f"1 to 4096 is supported, got {self.steps}")
        good = math.isfinite(self.tolerance) and self.tolerance >= 0
        _require(good, "plateau_tolerance", f"zero or more is needed, got {self.tolerance}")


SCALARS = {
    "scalar": "friction (alpha, beta, mu) and the mantissa of the gain: quotients of one divider",
    "direction": "cos and sin of the tangential force",
    "sums": "the sums A_pq of Eq. 12",
    "cordic": "rotations of the CORDIC, and the angle",
    "division": "operands of quotients, and words of the CORDIC",
}
"""Signals with one value a frame, and their meaning."""

DIVISION_GUARD = 4
"""Bits of a quotient's operands beyond those of a multiplier operand, unless given."""

_ORDERED = (("division", "direction", 0), ("division", "cordic", 1), ("cordic", "scalar", 0))
"""Least number of bits by which one signal is longer than another: words enter the CORDIC shifted left, a rotation
keeps bits of its operand, and a quotient takes no longer than a run of the CORDIC."""

_LIMITS = {
    "coefficient": (6, 27),
    "operand": (10, 27),
    "vector_fraction": (0, 16),
    "force_fraction": (0, 16),
    "lane": (6, 27),
    **dict.fromkeys(SCALARS, (10, 27)),
    "division": (10, 27 + DIVISION_GUARD),
}
"""Fewest and most bits; ``"lane"`` holds for single operators and products."""


@dataclass(frozen=True, slots=True)
class Formats:
    """Word lengths of the arithmetic; integer bits of every vector follow by proof from the coefficients.

    ``coefficient`` x ``operand`` is the multiplier of a lane, and the length of every other signal follows one of the
    two. ``vector_fraction`` are the bits that vectors keep below one converter code of the normalised frame;
    ``force_fraction`` those of the forces below one code times the taxel's area.  ``signals`` gives signals of an
    estimator a word length of their own, sorted by their names.  ``rounding`` is that of the results of products, the
    only one that leaves the hardware a choice.
    """

    name: str
    coefficient: int
    operand: int
    vector_fraction: int
    force_fraction: int
    signals: tuple[tuple[str, int], ...] = ()
    rounding: Rounding = Rounding.HALF_UP

    def __post_init__(self) -> None:
        object.__setattr__(self, "signals", tuple(sorted(self.signals)))
        for key in ("coefficient", "operand", "vector_fraction", "force_fraction"):
            _require_between(key, getattr(self, key), *_LIMITS[key])
        for name, bits in self.signals:
            _require_between(f"signals.{name}", bits, *_LIMITS[name if name in _LIMITS else "lane"])
        for longer, shorter, more in _ORDERED:
            bits, least = self.bits(longer), self.bits(shorter) + more
            reason = f"at least {least} bits are needed beside the {least - more} of {shorter}, got {bits}"
            _require(bits >= least, f"signals.{longer}", reason)
        most = self.bits("sums") + self.bits("direction") - 1
        bits = self.bits("division")
        reason = f"at most {most} bits, those of sums and direction less one, are supported, got {bits}"
        _require(bits <= most, "signals.division", reason)

    def bits(self, signal: str) -> int:
        """Word length of ``signal``: its own, or that of the length that it follows."""
        own = dict(self.signals)
        if signal in own:
            return own[signal]
        if signal.startswith("coefficient."):
            return self.coefficient
        return self.operand + (DIVISION_GUARD if signal == "division" else 0)


FORMATS = {
    "standard": Formats("standard", coefficient=18, operand=18, vector_fraction=9, force_fraction=4),
    "wide": Formats("wide", coefficient=24, operand=24, vector_fraction=14, force_fraction=8),
}
"""Named format sets; their measured exactness is stated in the README."""

KINDS = ("parallel", "serial")
"""Microarchitectures: blocks that stream to each other, or one instruction of a program a cycle (docs/serial.md)."""

TARGETS = ("portable", *(name for name, family in FAMILIES.items() if family.gateware))
"""Device families whose cells a core may be made of; ``"portable"`` is Verilog without instances, for any of them."""

VECTOR_WORDS = (1, 2, 4)
"""Words of a vector that may move in a cycle: the divisors of a quad."""


@dataclass(frozen=True, slots=True)
class Architecture:
    """One of ``KINDS``, and the parallelism of the parallel core.

    ``mac_lanes`` multiply-accumulate lanes; ``vector_words`` words of a vector a cycle after them.  A serial core's
    follow from its word lengths: both are 0, as in ``SERIAL``.
    """

    mac_lanes: int = 16
    vector_words: int = 4
    kind: str = "parallel"


TAXELS_PER_BEAT = (1, 2, 4)
"""Taxels that a beat of the input stream may have, 16 bits each."""


@dataclass(frozen=True, slots=True)
class Bus:
    """The streams around the core: ``taxels_per_beat`` of the input, one of ``TAXELS_PER_BEAT``."""

    taxels_per_beat: int = 1

    def __post_init__(self) -> None:
        reason = f"1, 2 or 4 is needed, got {self.taxels_per_beat}"
        _require(self.taxels_per_beat in TAXELS_PER_BEAT, "taxels_per_beat", reason)


SERIAL = Architecture(mac_lanes=0, vector_words=0, kind="serial")
"""The serial core."""


@dataclass(frozen=True, slots=True)
class Choices:
    """One core: sensor, converter, search, formats, architecture and bus.

    ``images`` is the source of the memories' initial contents, or states that coefficients are loaded after a reset.
    ``target``, one of ``TARGETS``, chooses cells, never a result or a cycle.

    Raises ``ValueError`` that starts with ``section.key:`` when the parts do not fit together.
    """

    sensor: SensorArray
    name: str = "tfra"
    adc: Adc = field(default_factory=Adc)
    search: Search = field(default_factory=Search)
    formats: Formats = FORMATS["standard"]
    architecture: Architecture = field(default_factory=Architecture)
    images: Images = "inline"
    target: str = "portable"
    bus: Bus = field(default_factory=Bus)

    def __post_init__(self) -> None:
        reason = f"one of {', '.join(TARGETS)} is needed, got {quoted(self.target)}"
        _require(self.target in TARGETS, "target.name", reason)
        self._check_architecture()
        reason = f"the {self.adc.bits}-bit converter needs an operand of {self.adc.bits} bits or more"
        _require(self.formats.operand >= self.adc.bits, "formats.operand", reason)

    def _check_architecture(self) -> None:
        kind, lanes, most = self.architecture.kind, self.architecture.mac_lanes, 4 * self.quads
        _require(kind in KINDS, "architecture.kind", f"one of {', '.join(KINDS)} is needed, got {quoted(kind)}")
        if kind == "serial":
            own = "".join(name for name, _ in self.formats.signals[:1])
            reason = "a serial core has one multiplier and one memory for all signals: kind = parallel is needed"
            _require(not own, f"formats.signals.{own}", reason)
            half_up = self.formats.rounding is Rounding.HALF_UP
            _require(half_up, "formats.rounding", "the adder of a serial core rounds half up")
            for key in ("mac_lanes", "vector_words"):
                given = getattr(self.architecture, key)
                _require(given == 0, f"architecture.{key}", f"the serial core leaves nothing to choose, got {given}")
            reason = "a serial core is always loaded: inline or readmemh, for its program, is needed"
            _require(self.images != "load", "target.images", reason)
            return
        allowed = lanes % 4 == 0 and 4 <= lanes <= most
        reason = f"a multiple of 4 up to {most} (4 parities x {self.quads} quads) is needed, got {lanes}"
        _require(allowed, "architecture.mac_lanes", reason)
        words = self.architecture.vector_words
        _require(words in VECTOR_WORDS, "architecture.vector_words", f"1, 2 or 4 is needed, got {words}")

    @property
    def quad_rows(self) -> int:
        """Rows of the folded array."""
        return (self.sensor.rows + 1) // 2

    @property
    def quad_columns(self) -> int:
        """Columns of the folded array."""
        return (self.sensor.columns + 1) // 2

    @property
    def quads(self) -> int:
        """Q: a vector is Q quads of four words, either four mirror taxels or four parities."""
        return self.quad_rows * self.quad_columns

    @property
    def cycles_per_quad(self) -> int:
        """Cycles that a quad takes after the lanes."""
        return 4 // self.architecture.vector_words

    @property
    def candidates(self) -> int:
        """K + 1 points of the sweep."""
        return self.search.steps + 1
