"""What a verification found."""

import math
from dataclasses import asdict, dataclass
from typing import Any

NOT_RETURNED, UNKNOWN = "not_returned", "no_true_values"
"""Why a frame can be left out, beside a status bit: the core's words did not all come, or nobody knows the truth."""


@dataclass(frozen=True)
class Mismatch:
    """The first word that differs.  ``taxel`` is (row, column) for a force; ``stall`` the pattern of the run."""

    frame: int
    stall: str
    field: str
    taxel: tuple[int, int] | None
    word: int
    expected: int
    observed: int
    stage: str | None = None
    """First stage, in the order of the data, whose transfers differ; None if no probes were to be had."""
    transfer: int | None = None
    """The stage's first transfer that differs."""

    def __str__(self) -> str:
        taxel = "" if self.taxel is None else f", taxel {self.taxel}"
        stage = "" if self.stage is None else f", stage {self.stage}"
        stage += "" if self.transfer is None else f" (transfer {self.transfer})"
        return (
            f"frame {self.frame} (stalls: {self.stall}), field {self.field}{taxel}, word {self.word}{stage}: "
            f"{self.expected} expected, {self.observed} observed"
        )


@dataclass(frozen=True)
class Timing:
    """Cycles, measured without stalls, and as the design states them; None where not known."""

    latency: int | None
    interval: int | None
    design_latency: int | None
    design_interval: int | None

    @property
    def agrees(self) -> bool:
        """No measured number differs from a stated one."""
        pairs = ((self.latency, self.design_latency), (self.interval, self.design_interval))
        return all(a is None or b is None or a == b for a, b in pairs)


Largest = dict[str, float]
"""An error by each key of ``tfra.model.metrics.ERRORS``."""


@dataclass(frozen=True)
class FloatErrors:
    """The core against double precision on the same codes: the largest errors of ``frames`` frames."""

    frames: int
    equal_index: float | None
    """Share of equal sweep indices, 0 ... 1; None without a sweep, as the next one."""
    index_distance: int | None
    largest: Largest


@dataclass(frozen=True)
class ContactErrors:
    """Median and largest errors of the core against the contacts' true values."""

    frames: int
    median: Largest
    largest: Largest


@dataclass(frozen=True)
class Account:
    """Where the frames of one kind went in one comparison: ``frames`` is ``compared`` and all that was left out."""

    kind: str
    against: str
    """``"model"`` (every bit), ``"float"`` or ``"contact"`` (its true values)."""
    frames: int
    compared: int
    left_out: dict[str, int]
    """Frames by the first reason that holds: the name of a status bit, or one of this module's."""


@dataclass(frozen=True)
class Report:
    """What a verification found."""

    name: str
    simulator: str
    seed: int
    kinds: dict[str, int]
    words: int
    """Words that should have been compared."""
    compared: int
    mismatches: int
    first: Mismatch | None
    violations: tuple[str, ...]
    timing: Timing
    status: dict[str, int]
    against_float: dict[str, FloatErrors]
    against_contact: ContactErrors | None
    accounts: tuple[Account, ...]
    recorded: int | None = None
    """The frame whose signals were written as waves."""

    @property
    def frames(self) -> int:
        """Frames simulated."""
        return sum(self.kinds.values())

    @property
    def passed(self) -> bool:
        """Every word was compared and equal, the streams kept their rules, and the timing is as stated."""
        complete = self.compared == self.words > 0
        return complete and not self.mismatches and not self.violations and self.timing.agrees

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain JSON types."""
        content = _plain(asdict(self))
        timing = content["timing"] | {"agrees": self.timing.agrees}
        return {"passed": self.passed, "frames": self.frames, **content, "timing": timing}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
