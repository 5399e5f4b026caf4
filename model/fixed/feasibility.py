"""Before a design is built: whether its words fit, what helps if they could overflow, and how exact it will be."""

from bisect import bisect_left
from dataclasses import dataclass, replace

import numpy as np

from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode

DOUBTFUL = 0.95
"""Share of equal frames below which longer words are advised; all format sets and sensors of the README are above."""

NEAR = 0.002
"""Largest difference of frictions that counts as equal where there is no sweep index."""

_WORK = 50_000
"""Taxels of all contacts that are tried, at most 500 contacts."""

THINNER = tuple(1 - percent / 50 for percent in range(1, 26))
"""Shares of the cover's thickness to try: in steps of two per cent, down to half."""


def fits(design: Design) -> bool:
    """Whether all words hold their proven range."""
    try:
        _ = design.widths
    except ValueError:
        return False
    return True


def advice(design: Design) -> str:
    """Keys of CONFIG with the nearest value that fits when changed alone, as text; empty where none fits.

    Fewer bits and a thinner cover never make words longer, so few designs have to be tried.
    """
    formats, sensor = design.formats, design.sensor
    fewer = range(formats.vector_fraction)[::-1]
    thinner = [float(f"{1000 * share * sensor.thickness:.3g}") for share in THINNER]
    tried: dict[str, list[tuple[float, Design]]] = {
        "formats.vector_fraction_bits": [
            (bits, replace(design, formats=replace(formats, name="custom", vector_fraction=bits))) for bits in fewer
        ],
        "sensor.thickness_mm": [(mm, replace(design, sensor=replace(sensor, thickness=mm / 1000))) for mm in thinner],
    }
    first = {key: bisect_left(each, True, key=lambda one: fits(one[1])) for key, each in tried.items()}
    return " or ".join(f"{key} = {tried[key][at][0]:g}" for key, at in first.items() if at < len(tried[key]))


@dataclass(frozen=True)
class AccuracyEstimate:
    """``equal``: share of the ``contacts`` that end at float's sweep index, or without a sweep ``near`` its friction.

    ``condition`` is that of C33; None for large arrays, and for an estimator that does not invert it.
    """

    condition: float | None
    contacts: int
    equal: float
    near: float | None = None

    @property
    def doubtful(self) -> bool:
        """Whether the words are too short for such a sensor."""
        return bool(self.contacts) and self.equal < DOUBTFUL

    def __str__(self) -> str:
        known = "" if self.condition is None else f"cond(C33) is {self.condition:,.3g}; "
        end = "at float's sweep index" if self.near is None else f"within {self.near:g} of float's friction"
        return f"{known}{100 * self.equal:.1f} % of {self.contacts} random contacts end {end}"


def accuracy_estimate(design: Design, seed: int = 0) -> AccuracyEstimate:
    """Compare the bit-accurate model with float on the codes of random contacts, at 10 to 95 % of full scale."""
    codes = contact_codes(design, min(500, max(20, _WORK // design.sensor.taxels)), seed)
    exact = design.float_model(codes * design.adc.lsb)
    fixed = decode(design, design.model(codes).words)
    clear = exact.status == 0
    same = exact.sweep_index == fixed.sweep_index if design.sweeps else np.abs(exact.mu - fixed.mu) <= NEAR
    equal = float(same[clear].mean()) if clear.any() else 1.0
    return AccuracyEstimate(design.condition, int(clear.sum()), equal, None if design.sweeps else NEAR)
