"""From arrays to what a page's script reads: numbers of few bytes, in base64, with their type, of the frames chosen.

These are those requested, thinned evenly if there is no room for all.
"""

import base64
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats
from tfra.model.learned.field import residual, unexplained
from tfra.model.tfra import Tfra
from tfra.view.resultfile import Recorded, References

Packed = dict[str, str]
"""An array: the name of its type and its bytes in base64, little-endian, the last axis first."""

MOST_BYTES = 15_000_000
"""Bytes of frames in a page; as text they are 20 MB."""

MOST_SWEEP_BYTES = 8_000_000
"""Bytes of sweeps, B^z and B^xy of all candidates."""

_TOP = 32767

_BLOCK = 512
"""Frames that the model sweeps at a time."""


@dataclass(frozen=True)
class Chosen:
    """Frames ``shown`` of ``total``; every ``sweeps``-th has its sweep.  ``full``: there is no room for more."""

    shown: range
    total: int
    sweeps: int
    full: bool

    @classmethod
    def of(cls, results: list[Recorded], wanted: range) -> "Chosen":
        """The frames ``wanted``, or every second, third … of them where the results are too large."""
        total, taxels = len(results[0].stress), results[0].design.sensor.taxels
        frame = sum(frame_bytes(taxels, result.found.resultant_alone) for result in results)
        sweep = sum(sweep_bytes(result.design.search.steps) for result in results if result.swept)
        return cls.fitting(total, wanted, frame, sweep)

    @classmethod
    def fitting(cls, total: int, wanted: range, frame: int, sweep: int = 0) -> "Chosen":
        """The same of ``total`` frames, each of which takes ``frame`` bytes, and its sweep as many more."""
        thinned = _step(len(wanted), frame, MOST_BYTES)
        shown = wanted[::thinned]
        return cls(shown, total, _step(len(shown), sweep, MOST_SWEEP_BYTES), thinned > 1)

    @classmethod
    def all(cls, total: int) -> "Chosen":
        """All of ``total`` frames."""
        return cls(range(total), total, 1, False)

    def __str__(self) -> str:
        """The sentence on the page."""
        first, last, step = self.shown.start, self.shown[-1], self.shown.step
        if len(self.shown) == self.total:
            sentence = f"All {self.total:,} frames are shown"
        else:
            which = (
                f"frames {first:,} to {last:,}" if step == 1 else f"every {_nth(step)} frame from {first:,} to {last:,}"
            )
            sentence = f"{len(self.shown):,} of {self.total:,} frames are shown: {which}"
            sentence += ", since there is no room for more (--frames A:B selects a part)" if self.full else ""
        return sentence + (f"; every {_nth(self.sweeps)} of them has its sweep." if self.sweeps > 1 else ".")


def frame_bytes(taxels: int, resultant_alone: bool = False) -> int:
    """Bytes of a frame: scales, values, stress and, unless ``resultant_alone``, forces and what they don't explain."""
    planes = 1 if resultant_alone else 5
    return planes * (2 * taxels + 4) + 9 * 4 + 2 + 1 + 8


def sweep_bytes(steps: int) -> int:
    """Bytes of a sweep: two values and a bit a candidate, and where it starts."""
    return 8 * (steps + 1) + (steps + 8) // 8 + 4


def _step(count: int, each: int, most: int) -> int:
    return max(1, math.ceil(count / max(1, most // max(1, each))))


def _nth(number: int) -> str:
    ending = "th" if number % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number:,}{ending}"


def packed(array: npt.NDArray[Any], kind: str) -> Packed:
    """``array`` as numbers of ``kind``: float32, float64, int16 or uint8."""
    data = np.ascontiguousarray(array, dtype=np.dtype(kind).newbyteorder("<"))
    return {"type": kind, "data": base64.b64encode(data.tobytes()).decode("ascii")}


def scaled(planes: Floats) -> dict[str, Packed]:
    """``planes (n, m)`` as 16-bit ``codes`` and a ``scale`` each, which are off by 2e-5 of its largest value."""
    scale = (np.abs(planes).max(axis=1) / _TOP).astype(np.float32)
    codes = np.divide(planes, scale[:, None], out=np.zeros_like(planes), where=scale[:, None] > 0)
    return {"codes": packed(np.clip(np.rint(codes), -_TOP, _TOP), "int16"), "scale": packed(scale, "float32")}


def result(recorded: Recorded, chosen: Chosen) -> dict[str, Any]:
    """The chosen frames of a result; ``sweep`` only beside results of TFRA, ``forces`` only if a core gave them.

    ``left`` is the stress that the forces leave unexplained under the elastic layer, ``residual`` its share in percent.
    Under a half-space TFRA explains every frame, but for the factor of Eq. 31.
    """
    shown, found = slice(chosen.shown.start, chosen.shown.stop, chosen.shown.step), recorded.found
    stress = recorded.stress[shown]
    flat = stress.reshape(len(stress), -1)
    planes: dict[str, Any] = {"stress": scaled(flat)}
    values = {"phi": found.phi_deg, "mu": found.mu, "mu_x": found.mu_x, "mu_y": found.mu_y}
    values |= dict(zip(("f_x", "f_y", "f_z"), found.resultant.T, strict=True))
    if (share := found.uncertainty_share) is not None:
        values["uncertainty"] = 100 * share  # in percent of |F_z|
    if found.residual is not None:
        values["residual"] = 100 * found.residual
    values = {key: value[shown] for key, value in values.items()}
    if not found.resultant_alone:
        forces = found.forces[shown].reshape(len(stress), 3, -1)
        sensor = recorded.design.sensor
        left = scaled(unexplained(sensor, flat, forces))
        planes |= {"forces": [scaled(axis) for axis in forces.swapaxes(0, 1)], "left": left}
        if found.residual is None:
            values["residual"] = 100 * residual(sensor, flat, forces)
    return {
        "values": {key: packed(value, "float32") for key, value in values.items()},
        "status": packed(found.status[shown], "uint8"),
        "index": packed(found.sweep_index[shown], "int16"),
        **planes,
        **({} if found.threshold is None else {"threshold": 100 * found.threshold}),
        **({"sweep": _sweep(recorded, stress[:: chosen.sweeps])} if recorded.swept else {}),
    }


def times(recorded: list[Recorded], chosen: Chosen) -> Packed | None:
    """The time of each chosen frame in seconds, by the first result that knows it."""
    known = [result.time for result in recorded if result.time is not None]
    return packed(known[0][chosen.shown], "float64") if known else None


def references(true: References, chosen: Chosen) -> dict[str, Packed]:
    """What is known of the chosen frames, named as the values of a result."""
    values = {
        name: true.values[key] for key, name in {"phi_ref_deg": "phi", "mu_ref": "mu"}.items() if key in true.values
    }
    if "resultant_ref" in true.values:
        values |= dict(zip(("f_x", "f_y", "f_z"), true.values["resultant_ref"].T, strict=True))
    return {name: packed(value[chosen.shown], "float32") for name, value in values.items()}


def _sweep(recorded: Recorded, stress: Floats) -> dict[str, Any]:
    """B^z and B^xy of every candidate, as double precision has them of the ``stress``; ``start`` is the first mu."""
    model = Tfra.of(recorded.design)
    blocks = [model(stress[at : at + _BLOCK], keep_sweep=True) for at in range(0, len(stress), _BLOCK)]
    sweeps = [block.sweep for block in blocks if block.sweep]
    return {
        "start": packed(np.concatenate([sweep.mu[:, 0] for sweep in sweeps]), "float32"),
        "b_z": packed(np.concatenate([sweep.b_z for sweep in sweeps]), "float32"),
        "b_xy": packed(np.concatenate([sweep.b_xy for sweep in sweeps]), "float32"),
        "plateau": packed(np.packbits(np.concatenate([sweep.plateau for sweep in sweeps]), axis=1), "uint8"),
    }
