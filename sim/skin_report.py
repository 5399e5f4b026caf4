"""What the verification of a skin found."""

from dataclasses import asdict, dataclass
from typing import Any

from tfra.report.table import Table


@dataclass(frozen=True)
class SkinReport:
    """What the verification of a skin found; ``cycles`` are those between the ends of two frames, without stalls."""

    name: str
    simulator: str
    seed: int
    kinds: dict[str, int]
    contacts: int
    words: int
    """Words that should have been compared."""
    compared: int
    mismatches: int
    first: str | None
    """The first word that differs."""
    violations: tuple[str, ...]
    cycles: tuple[float, int] | None
    """Median and most; None where fewer than two frames came."""
    marks: dict[str, int]
    """Contacts with each mark and status bit."""
    against_float: dict[str, float] | None
    """Differences of contacts that are regular, by what they are of."""
    recorded: int | None = None
    """The frame whose signals were written as waves."""

    @property
    def frames(self) -> int:
        """Frames simulated."""
        return sum(self.kinds.values())

    @property
    def passed(self) -> bool:
        """Every word was compared and equal, and the streams kept their rules."""
        return self.compared == self.words > 0 and not self.mismatches and not self.violations

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain JSON types."""
        return {"passed": self.passed, "frames": self.frames, **asdict(self)}

    def table(self) -> Table:
        """The numbers."""
        cycles = "–" if self.cycles is None else f"{self.cycles[0]:,.0f}, at most {self.cycles[1]:,}"
        rows = [
            ("frames", f"{self.frames} ({_counts(self.kinds)})"),
            ("contacts", self.contacts),
            ("words compared", f"{self.compared} of {self.words}"),
            ("mismatches", self.mismatches),
            ("cycles of a frame", cycles),
            ("marks and status", _counts(self.marks) or "none"),
        ]
        if self.against_float:
            rows += [(name, f"{value:.3g}") for name, value in self.against_float.items()]
        return Table(f"{self.name} on {self.simulator}, seed {self.seed}", ("", ""), rows, (0, 1))


def _counts(numbers: dict[str, int]) -> str:
    return ", ".join(f"{count} {name.replace('_', ' ').lower()}" for name, count in numbers.items() if count)
