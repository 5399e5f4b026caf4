"""The elastic cover of a CONFIG file: the solver of simulated frames, and its limits of memory and time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import ElasticLayer, Sampling
from tfra.model.cover.layer import frames as layer_frames
from tfra.model.sensor import SensorArray

MOST_MODES = 50_000_000
"""Of the series: 400 MB for each of its arrays."""

MOST_ELEMENTS = 50_000
"""Of a mesh: some 6 GB and two minutes for each footprint."""


@dataclass(frozen=True, slots=True)
class LayerSpec:
    """The elastic cover for simulated frames: Poisson's ratio, and sampling ``"point"`` or ``"area"``.

    ``solver`` is ``"series"`` (exact) or ``"fem"``, with finite elements of ``element`` metres.
    """

    poisson: float
    sampling: Sampling
    solver: str = "series"
    element: float = 0.5e-3

    def frames(self, sensor: SensorArray, contacts: Sequence[Contact]) -> Floats:
        """Stress ``(n, rows, columns)`` in Pa under ``contacts``.

        Raises ``ValueError`` for contacts or meshes that do not fit, and with the install line where scikit-fem is
        missing.
        """
        if self.solver == "series":
            return layer_frames(sensor, contacts, self.sampling, self.poisson)
        if find_spec("skfem") is None:
            raise ValueError("solver: scikit-fem is not installed: pip install 'tfra[fem]'")
        from tfra.model.cover.fem import Mesh, fem_frames

        for footprint in dict.fromkeys(replace(each, normal_force=-1.0, mu=0.0, phi=0.0) for each in contacts):
            _require_few_elements(sensor, footprint, self.element)
        return fem_frames(sensor, contacts, Mesh(self.element), self.poisson)


def require_few_modes(layer: ElasticLayer) -> None:
    """Raise ``ValueError`` (``thickness_mm: ...``) for a cover so thin that its series has too many terms."""
    if (modes := layer.modes) > MOST_MODES:
        reason = (
            f"a cover this thin takes {modes:,} modes of its series, at most {MOST_MODES:,} are supported: is it in mm?"
        )
        raise ValueError(f"thickness_mm: {reason}")


def _require_few_elements(sensor: SensorArray, footprint: Contact, element: float) -> None:
    """Raise ``ValueError`` (``layer.element_mm: ...``) for a mesh that is too large, with a length that works."""
    from tfra.model.cover.fem import Mesh

    count = Mesh(element).elements(sensor, footprint)
    if count <= MOST_ELEMENTS:
        return
    coarsest, enough = min(footprint.half_x, footprint.half_y, sensor.thickness) / 2, element
    while enough <= coarsest and Mesh(enough).elements(sensor, footprint) > MOST_ELEMENTS:
        enough *= 1.02
    enough = math.ceil(enough * 1e6) / 1e6  # whole micrometres
    way = f"{enough * 1e3:g} mm works" if enough <= coarsest else 'solver = "series" works'
    reason = f"would take {count:,} elements, at most {MOST_ELEMENTS:,} are supported: {way}"
    raise ValueError(f"layer.element_mm: {element * 1e3:g} mm {reason}")
