"""The device that a package describes its core for."""

from collections.abc import Mapping
from dataclasses import dataclass

from tfra.families import Target


@dataclass(frozen=True)
class Part:
    """A target, and what the core takes of it.

    ``resources``: by name, how many the core takes, and how many the part has; ``basis``: what these numbers are.
    """

    target: Target
    resources: Mapping[str, tuple[int, int]]
    basis: str

    @property
    def name(self) -> str:
        """Name of the target."""
        return self.target.name

    @property
    def clock_mhz(self) -> float:
        """The target's default clock."""
        return self.target.clock_mhz

    def microseconds(self, cycles: int) -> float:
        """Time of ``cycles`` at the part's clock."""
        return cycles / self.clock_mhz
