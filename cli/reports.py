"""What ``tfra estimate`` says of its results."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tfra.model.arrays import Floats, Ints
    from tfra.model.skin.result import SkinResult
    from tfra.model.tfra import Result
    from tfra.recordings.frames import Recording
    from tfra.recordings.results import Estimate, SkinEstimate
    from tfra.report.table import Table

SHOWN = 12
"""Rows of a table on a terminal."""


@dataclass(frozen=True, eq=False)
class ArrayReport:
    """What is said of the results of an array's frames."""

    stresses: Floats
    result: Result

    @property
    def status(self) -> Ints:
        """Of each frame."""
        return self.result.status

    def estimate(self, recording: Recording, engine: str, config: str) -> Estimate:
        """The content of a file."""
        from tfra.recordings.results import Estimate

        return Estimate(recording, self.result, engine, config)

    def values(self) -> dict[str, Any]:
        """For JSON."""
        from tfra.model.tfra import Status
        from tfra.recordings.facts import as_dict, facts

        return {
            **_values(self.result),
            "status": {flag.name: int((self.status & flag != 0).sum()) for flag in Status},
            "summary": as_dict(facts(self.stresses, self.result)),
            "friction": self._friction(),
        }

    def lines(self) -> list[str]:
        """For readers."""
        from tfra.recordings.facts import facts, lines

        friction = self._friction()
        return [*lines(facts(self.stresses, self.result)), *([friction] if friction else [])]

    def table(self) -> Table:
        """The first frames."""
        return _table({"frame": range(len(self.status))}, self.result)

    def _friction(self) -> str | None:
        """Where the friction can be found; the learned estimator finds it in another way."""
        from tfra.model.truth import sentence

        return sentence() if self.result.uncertainty is None else None


@dataclass(frozen=True, eq=False)
class SkinReport:
    """The same for the contacts of a skin."""

    result: SkinResult

    @property
    def status(self) -> Ints:
        """Of each frame."""
        return self.result.frame_status

    def estimate(self, recording: Recording, engine: str, config: str) -> SkinEstimate:
        """The content of a file."""
        from tfra.recordings.results import SkinEstimate

        return SkinEstimate(recording, self.result, engine, config)

    def values(self) -> dict[str, Any]:
        """For JSON."""
        from tfra.recordings.skin_facts import skin_facts

        places = {"frame": self.result.frame, "x_mm": 1e3 * self.result.x, "y_mm": 1e3 * self.result.y}
        return {
            "contacts": {**{key: values.tolist() for key, values in places.items()}, **_values(self.result.windows)},
            "summary": asdict(skin_facts(self.result)),
        }

    def lines(self) -> list[str]:
        """For readers."""
        from tfra.recordings.skin_facts import skin_facts, skin_lines

        return skin_lines(skin_facts(self.result))

    def table(self) -> Table:
        """The first contacts."""
        found = self.result
        places = {"x/mm": [f"{1e3 * x:.1f}" for x in found.x], "y/mm": [f"{1e3 * y:.1f}" for y in found.y]}
        return _table({"frame": found.frame, "contact": found.contact, **places}, found.windows)


def _values(result: Result) -> dict[str, list[Any]]:
    return {
        "phi_deg": result.phi_deg.tolist(),
        "mu": result.mu.tolist(),
        "resultant_n": result.resultant.tolist(),
    }


def _table(places: Mapping[str, Iterable[Any]], result: Result) -> Table:
    """The first rows of ``result``, each with its values of the columns ``places``."""
    from tfra.report.table import Table

    columns = (*places.values(), result.phi_deg, result.mu, result.resultant, result.status)
    rows = [
        (*place, f"{phi:.1f}", f"{mu:.3f}", *(f"{f:.3f}" for f in force), _labels(int(status)))
        for *place, phi, mu, force, status in islice(zip(*columns, strict=True), SHOWN)
    ]
    header = (*places, "phi/°", "mu", "F_x/N", "F_y/N", "F_z/N", "status")
    return Table("", header, rows, words=(len(header) - 1,))


def _labels(status: int) -> str:
    """Names of the bits of a status, those of marks among them."""
    from tfra.model.skin.finding import Mark
    from tfra.model.tfra import Status

    return "|".join(str(flag.name) for flag in (*Status, *Mark) if status & flag)
