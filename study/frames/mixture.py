"""Frames of a declared mixture of contacts on an elastic cover.

Frame i of a part depends only on the definition, the part and i: each block has its own generators, and draws its
frames one after the other.  Noise has another generator than contacts, so that both can be varied alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from tfra.codegen.config.cover import LayerSpec
from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contacts, ContactShape, cell_shares
from tfra.model.cover.layer import frames
from tfra.model.sensor import SensorArray
from tfra.runtime.errors import quoted
from tfra.study.frames.block import BLOCK, Block, Part, Stream, generator, with_noise
from tfra.study.frames.schema import ComponentSection, Range

LIMITS = {
    "half_x_pitches": (1e-3, 1e4),
    "half_y_pitches": (1e-3, 1e4),
    "center_x_share": (0.0, 1.0),
    "center_y_share": (0.0, 1.0),
    "force_n": (-1e6, -1e-6),
    "peak_kpa": (1e-6, 1e9),
    "mu": (0.0, 1.0),
    "phi_deg": (-360.0, 360.0),
    "noise_share_of_peak": (0.0, 1.0),
    "offset_share_of_peak": (-1.0, 1.0),
}
"""Every quantity of a component, in the order of the draws, and its limits."""

_OF_THE_CONTACT = tuple(LIMITS)[:8]


@dataclass(frozen=True)
class Mixture:
    """Contacts of several kinds on the cover of a sensor.

    Raises ``ValueError`` that starts with the key within ``[frames]`` for an impossible component.
    """

    sensor: SensorArray
    layer: LayerSpec
    components: Sequence[ComponentSection]
    seed: int

    def __post_init__(self) -> None:
        if self.layer.solver != "series":
            raise ValueError('mixture: contacts in such numbers need solver = "series" in [layer] of the configuration')
        for number, component in enumerate(self.components, 1):
            try:
                self._require_number(component)
                _check(self.sensor, component)
            except ValueError as error:
                raise ValueError(f"mixture#{number}.{error}") from None

    def _require_number(self, component: ComponentSection) -> None:
        """Raise ``ValueError`` for a number of contacts that a frame cannot have."""
        for key in ("contacts", "gap_pitches"):
            if getattr(component, key) is not None:
                raise ValueError(f"{key}: a frame has one contact, since CONFIG has no section window")

    def require_disjoint(self) -> None:
        """Raise ``ValueError`` for a component whose contacts repeat."""
        for number, component in enumerate(self.components, 1):
            if not any(isinstance(getattr(component, key), Range) for key in _OF_THE_CONTACT):
                raise ValueError(f"mixture#{number}: without a range the same contacts would be in both parts")

    def block(self, part: Part, number: int, count: int) -> Block:
        """Return the first ``count`` frames of block ``number``."""
        draws, noise = (generator(self.seed, part, number, stream) for stream in Stream)
        component, shape, values = self._draw(draws.random((count, 2 + len(LIMITS))))
        contacts = self._contacts(shape, values)
        unscaled = frames(self.sensor, contacts, self.layer.sampling, self.layer.poisson)
        factor = scale(unscaled, values["peak_kpa"])
        stress = (unscaled * factor[:, None, None]).astype(np.float32)
        contacts = replace(contacts, force=contacts.force * factor[:, None])
        spread, offset = (values[key] for key in ("noise_share_of_peak", "offset_share_of_peak"))
        noisy = with_noise(stress, spread, offset, noise.standard_normal(stress.shape))
        shares = cell_shares(self.sensor, contacts).astype(np.float32)
        return Block(number * BLOCK, stress, noisy, shares, truth(component, contacts, values))

    def _draw(self, u: Floats) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.str_], dict[str, Floats]]:
        """Component, shape and quantities of each row of ``u``, uniform in [0, 1)."""
        weights = np.cumsum([component.weight for component in self.components])
        component_of = np.searchsorted(weights / weights[-1], u[:, 0], side="right").astype(np.int32)
        shapes = np.empty(len(u), dtype=f"U{max(map(len, ContactShape))}")
        values = {key: np.empty(len(u)) for key in LIMITS}
        for number, component in enumerate(self.components):
            rows = np.flatnonzero(component_of == number)
            shapes[rows] = choose(as_list(component.shape), u[rows, 1])
            for column, key in enumerate(LIMITS, 2):
                given, at = getattr(component, key), u[rows, column]
                if given is None:  # one newton, or as large as the force makes it
                    values[key][rows] = -1.0 if key == "force_n" else np.nan
                    continue
                values[key][rows] = given.at(at) if isinstance(given, Range) else choose(as_list(given), at)
        return component_of, shapes, values

    def _contacts(self, shape: npt.NDArray[np.str_], values: dict[str, Floats]) -> Contacts:
        pitch = np.array([self.sensor.pitch_x, self.sensor.pitch_y])
        size = np.array([self.sensor.size_x, self.sensor.size_y])
        half = np.stack([values["half_x_pitches"], values["half_y_pitches"]], axis=1) * pitch
        share = np.stack([values["center_x_share"], values["center_y_share"]], axis=1)
        center = half - pitch / 2 + share * (size - 2 * half)
        phi, tangential = np.radians(values["phi_deg"]), values["mu"] * np.abs(values["force_n"])
        force = np.stack([tangential * np.cos(phi), tangential * np.sin(phi), values["force_n"]], axis=1)
        return Contacts(shape, center, half, force)


def scale(stress: Floats, peak_kpa: Floats) -> Floats:
    """Return the factor that scales a frame to the given largest magnitude; 1 where that is nan."""
    wanted = ~np.isnan(peak_kpa)
    return np.where(wanted, 1e3 * peak_kpa, 1.0) / np.where(wanted, np.abs(stress).max(axis=(1, 2)), 1.0)


def truth(component: npt.NDArray[np.int32], contacts: Contacts, values: dict[str, Floats]) -> pl.DataFrame:
    """Return a row each contact; components count from 1, as in the file."""
    f_x, f_y, f_z = contacts.force.T
    phi = np.where(values["mu"] > 0, values["phi_deg"] % 360.0, np.nan)
    return pl.DataFrame(
        {
            "force_x_n": f_x,
            "force_y_n": f_y,
            "force_z_n": f_z,
            "mu": values["mu"],
            "phi_deg": np.where(phi == 360.0, 0.0, phi),  # what % makes of the smallest negative angles
            "component": component + np.int32(1),
            "shape": contacts.shape,
            "center_x_m": contacts.center[:, 0],
            "center_y_m": contacts.center[:, 1],
            "half_x_m": contacts.half[:, 0],
            "half_y_m": contacts.half[:, 1],
            "noise_share_of_peak": values["noise_share_of_peak"],
            "offset_share_of_peak": values["offset_share_of_peak"],
        }
    )


def as_list(given: Any) -> list[Any]:
    """Return what may be chosen from."""
    return given if isinstance(given, list) else [given]


def choose(choices: list[Any], u: Floats) -> npt.NDArray[Any]:
    """Return the choice at each ``u`` in [0, 1)."""
    return np.array(choices)[(u * len(choices)).astype(np.int64)]


def _check(sensor: SensorArray, component: ComponentSection) -> None:
    if not component.weight > 0:
        raise ValueError(f"weight: a number above 0 is needed, got {component.weight:g}")
    for shape in as_list(component.shape):
        if shape not in list(ContactShape):
            raise ValueError(f"shape: one of {', '.join(ContactShape)} is needed, got {quoted(shape)}")
    if (component.force_n is None) == (component.peak_kpa is None):
        raise ValueError("force_n: either this or peak_kpa is needed")
    for key, (low, high) in LIMITS.items():
        if (given := getattr(component, key)) is None:
            continue
        if isinstance(given, Range):
            _check_range(key, given)
        for value in ends(given):
            if not low <= value <= high:
                raise ValueError(f"{key}: {low:g} to {high:g} is needed, got {value:g}")
    for axis, count in (("x", sensor.columns), ("y", sensor.rows)):
        widest = max(ends(getattr(component, f"half_{axis}_pitches")))
        if 2 * widest > count:
            reason = f"a footprint of 2 x {widest:g} pitches does not fit on the block of {count}"
            raise ValueError(f"half_{axis}_pitches: {reason}")


def _check_range(key: str, given: Range) -> None:
    if not given.low < given.high:
        raise ValueError(f"{key}: a range upwards is needed, got from {given.low:g} to {given.high:g}")
    if given.log and not given.low * given.high > 0:
        raise ValueError(f"{key}: a range with log needs ends of one sign, got from {given.low:g} to {given.high:g}")


def ends(given: Any) -> list[float]:
    """Return the numbers of a quantity as it is written."""
    return [given.low, given.high] if isinstance(given, Range) else as_list(given)
