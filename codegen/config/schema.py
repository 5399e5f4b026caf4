"""Schema of a CONFIG file: one pydantic model per TOML section.

It checks only the form (keys, types, finite numbers).  The objects that :mod:`tfra.codegen.config.read` builds from the
values check whether they fit together.
"""

import math
from dataclasses import fields
from fractions import Fraction
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, create_model

from tfra.model.choices import Adc, Architecture, Bus, Images, Search
from tfra.model.cover.layer import Sampling
from tfra.model.estimators import DEFAULT, ESTIMATORS
from tfra.model.sensor import sensor_keys
from tfra.model.skin.finding import Finding
from tfra.recordings.input import Input

MOST_DIRECTIONS = 100_000
"""Contacts that one ``phi_deg`` may expand to."""

IDENTIFIER = r"^[A-Za-z][A-Za-z0-9_]{0,62}$"

Length = Annotated[float, Field(ge=1e-3, le=1e3)]
"""Millimetres; a larger value is a mistaken unit, and its square would lose digits."""

Stress = Annotated[float, Field(ge=1e-3, le=1e12)]
"""Pascals that a converter may reach."""


def exact(value: float) -> Fraction:
    """Return the decimal number that ``value`` is written as, so that 4.1 mm is 41/10 mm."""
    return Fraction(repr(value))


def metres(millimetres: Fraction) -> float:
    """Return the double nearest to ``millimetres`` in metres."""
    return float(millimetres / 1000)


class Section(BaseModel):
    """Immutable, no unknown keys, no conversions except int to float, no nan or inf."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


_SENSOR: dict[str, Any] = {key.config: Length if key.is_length else float if key.unit else int for key in sensor_keys()}


class SensorSection(create_model("_", __base__=Section, **_SENSOR)):  # type: ignore[misc]  # its fields are those of a table
    """``[sensor]``: the array; the cover block reaches half a pitch beyond the outer taxels."""


class WindowSection(Section):
    """``[window]``: the taxels that the estimator of one contact sees; with it, the array is a skin."""

    rows: int
    columns: int


class ContactsSection(Section):
    """``[contacts]``: how the contacts of a skin are told apart."""

    most: int = Finding().most
    threshold: float = Finding().threshold
    gap: int = Finding().gap


class AdcSection(Section):
    """``[adc]``: the converter."""

    bits: int = Adc().bits
    full_scale_pa: Stress = Adc().full_scale
    contact_threshold_codes: int | None = None


_LIMITED: dict[str, Any] = {
    "tare_frames": Annotated[int, Field(ge=0, le=1_000_000)],
    "tare": Annotated[str, Field(min_length=1)],
    "calibration": Annotated[str, Field(min_length=1)],
    "pa_per_code": Annotated[float, Field(gt=0, le=1e9)],
    "rest_code": Annotated[float, Field(ge=-(2**20), lt=2**20)],
    "drift_frames": Annotated[int, Field(ge=0, le=1_000_000_000)],
    "average": Annotated[int, Field(ge=1, le=64)],
    "dead": list[Annotated[list[int], Field(min_length=2, max_length=2)]],
    "columns": Annotated[str, Field(min_length=3, max_length=200)],
    "skip_columns": Annotated[int, Field(ge=0, le=1000)],
}
_INPUT: dict[str, Any] = {key.name: (_LIMITED.get(key.name, key.type) | None, None) for key in fields(Input)}


class InputSection(create_model("_", __base__=Section, **_INPUT)):  # type: ignore[misc]  # its fields are those of a table
    """``[input]``: how a recording is to be read; :class:`tfra.recordings.input.Input` has the defaults."""


class SearchSection(Section):
    """``[search]``: the sweep of the independent friction coefficient."""

    steps: int = Search().steps
    plateau_tolerance: Annotated[float, Field(le=1e12)] = Search().tolerance


class SignalsSection(Section):
    """``[formats.signals]``: word lengths of single signals; those of operators and of products by their names."""

    coefficient: dict[str, int] = {}
    operand: dict[str, int] = {}
    scalar: int | None = None
    direction: int | None = None
    sums: int | None = None
    cordic: int | None = None
    division: int | None = None

    def pairs(self) -> tuple[tuple[str, int], ...]:
        """Names and lengths as :class:`tfra.model.choices.Formats` has them."""
        given = self.model_dump(exclude_none=True)
        named = {kind: given.pop(kind) for kind in ("coefficient", "operand")}
        return (*((f"{kind}.{name}", bits) for kind in named for name, bits in named[kind].items()), *given.items())


class FormatsSection(Section):
    """``[formats]``: a named set of word lengths, and changes to it."""

    name: str = "standard"
    coefficient_bits: int | None = None
    operand_bits: int | None = None
    vector_fraction_bits: int | None = None
    force_fraction_bits: int | None = None
    signals: SignalsSection = SignalsSection()


class ArchitectureSection(Section):
    """``[architecture]``: the kind of core, and its parallelism, whose default follows from the sensor."""

    kind: str = Architecture().kind
    mac_lanes: int | None = None
    vector_words: int | None = None


class TargetSection(Section):
    """``[target]``: the device family of the Verilog, and the source of its memories' contents."""

    name: str = "portable"
    images: Images = "inline"


class BusSection(Section):
    """``[bus]``: the streams around the core."""

    taxels_per_beat: int = Bus().taxels_per_beat


class EstimatorSection(Section):
    """``[estimator]``: the algorithm; of the learned one the file of its weights, and what its core gives."""

    kind: Literal[tuple(ESTIMATORS)] = DEFAULT  # type: ignore[valid-type]  # the names of the registry
    weights: Annotated[str, Field(min_length=1)] | None = None
    taxel_forces: bool | None = None


class LayerSection(Section):
    """``[layer]``: the elastic cover of simulated frames."""

    poisson: float = 0.48
    sampling: Sampling = "point"
    solver: Literal["series", "fem"] = "series"
    element_mm: float = Field(default=0.5, ge=1e-9, le=1000)


class Directions(Section):
    """``{start, stop, step}``: evenly spaced directions, ``stop`` excluded."""

    start: float
    stop: float
    step: float

    def values(self) -> list[float]:
        """Return the directions, free of accumulated rounding.

        Raises ``ValueError`` (``phi_deg: ...``) when there are none or more than ``MOST_DIRECTIONS``.
        """
        start, stop, step = exact(self.start), exact(self.stop), exact(self.step)
        count = math.ceil((stop - start) / step) if step else 0
        if count < 1:
            way = f"from {self.start:g} to {self.stop:g}"
            raise ValueError(f"phi_deg: a step of {self.step:g} does not lead {way}")
        if count > MOST_DIRECTIONS:
            raise ValueError(f"phi_deg: at most {MOST_DIRECTIONS} directions are supported, got {count}")
        return [float(start + i * step) for i in range(count)]


def form(value: object) -> str:
    """Return the form of a value that may be a single one, a list or a table: a tag of ``FORMS``."""
    return "list" if isinstance(value, list) else "table" if isinstance(value, dict | BaseModel) else "one"


FORMS = ("one", "list", "table")
"""Tags of :func:`form`; they are in pydantic's locations but not in the file."""


class ContactSection(Section):
    """``[[contact]]``: one load, once per direction in ``phi_deg``; the centre defaults to the block's.

    Those of a skin act together: each has as many directions, or one that stays.
    """

    shape: str
    center_x_mm: float | None = None
    center_y_mm: float | None = None
    half_x_mm: Length
    half_y_mm: Length
    force_n: Annotated[float, Field(ge=-1e6)]
    mu: Annotated[float, Field(le=100)]
    phi_deg: Annotated[
        Annotated[float, Tag("one")]
        | Annotated[list[float], Field(min_length=1, max_length=MOST_DIRECTIONS), Tag("list")]
        | Annotated[Directions, Tag("table")],
        Discriminator(form),
    ]

    def directions(self) -> list[float]:
        """Return every direction in degrees; raises ``ValueError`` as ``Directions.values``."""
        if isinstance(self.phi_deg, Directions):
            return self.phi_deg.values()
        return self.phi_deg if isinstance(self.phi_deg, list) else [self.phi_deg]


class Document(Section):
    """The whole file."""

    name: Annotated[str, Field(pattern=IDENTIFIER)] | None = None
    sensor: SensorSection
    window: WindowSection | None = None
    contacts: ContactsSection | None = None
    adc: AdcSection = AdcSection()
    input: InputSection = InputSection()
    search: SearchSection = SearchSection()
    formats: FormatsSection = FormatsSection()
    architecture: ArchitectureSection = ArchitectureSection()
    target: TargetSection = TargetSection()
    bus: BusSection = BusSection()
    estimator: EstimatorSection = EstimatorSection()
    layer: LayerSection = LayerSection()
    contact: list[ContactSection] = []
