"""The device that a package describes its core for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """A part at a clock, and what the core takes of it.

    ``resources``: by name, how many the core takes, and how many the part has; ``basis``: what these numbers are.
    """

    name: str
    clock_mhz: float
    resources: Mapping[str, tuple[int, int]]
    basis: str

    def microseconds(self, cycles: int) -> float:
        """Time of ``cycles`` at the part's clock."""
        return cycles / self.clock_mhz
