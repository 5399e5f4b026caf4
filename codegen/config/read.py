"""From a CONFIG file in TOML to the objects of the model.

The keys carry units (``pitch_x_mm``, ``full_scale_pa``, ``phi_deg``); the objects are in SI and radians.
Millimetres become metres by exact decimal arithmetic, so 4.1 mm is the double nearest to 0.0041.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tfra.codegen.config.complaints import complaint
from tfra.codegen.config.cover import LayerSpec, require_few_modes
from tfra.codegen.config.names import checked, name_from
from tfra.codegen.config.schema import (
    ArchitectureSection,
    ContactSection,
    Document,
    EstimatorSection,
    FormatsSection,
    InputSection,
    LayerSection,
    Section,
    SensorSection,
    exact,
)
from tfra.codegen.config.weights import read_weights
from tfra.codegen.config.write import KEYS
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Bus, Formats, Search
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import ElasticLayer
from tfra.model.estimators import ESTIMATORS
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray, SensorKey, sensor_keys
from tfra.recordings.input import PLAIN, Input, overridden
from tfra.runtime.errors import InputError, quoted
from tfra.runtime.inputs import read_toml

MOST_TAXELS = 4096
"""The model holds dense matrices of taxels x taxels: 134 MB each at this limit."""

MOST_CONTACTS = 100_000
"""Contacts of a file, each direction counted."""

@dataclass(frozen=True, slots=True)
class Project:
    """The content of a CONFIG file: the core, the simulated cover, the contacts, recordings, and the file itself.

    ``weights`` names the file of an estimator that is trained, relative to CONFIG's folder.
    """

    design: Design
    layer: LayerSpec
    contacts: tuple[Contact, ...]
    path: Path
    input: Input = PLAIN
    weights: str | None = None


def load(path: str | Path) -> Project:
    """Read and check the CONFIG file at ``path``.

    Raises ``InputError``, a line that names the file, the key and the reason, for anything wrong with it.
    """
    file = Path(path)
    return build_project(read_toml(file), file)


def load_tfra(path: str | Path) -> Project:
    """The same with TFRA in its usual word lengths, whatever CONFIG says: for what needs neither weights nor a core."""
    file = Path(path)
    return build_project(read_toml(file) | {"estimator": {}, "formats": {}}, file)


def build_project(content: Mapping[str, object], file: Path) -> Project:
    """Check the ``content`` of a CONFIG file; raises ``InputError`` naming ``file`` for anything wrong with it.

    The learned estimator's weights are read, so an error can name their file, too.
    """
    try:
        document = Document.model_validate(content)
    except ValidationError as error:
        raise InputError(file, *complaint(error)) from None
    sensor = _sensor(file, document.sensor)
    with _blame(file, "layer"):
        cover = ElasticLayer.under(sensor, document.layer.poisson)
        if document.layer.solver == "fem":
            _require_fem(document.layer)
    with _blame(file, "sensor"):
        require_few_modes(cover)
    return Project(
        design=_design(file, document, sensor),
        layer=LayerSpec(
            document.layer.poisson,
            document.layer.sampling,
            document.layer.solver,
            _metres(exact(document.layer.element_mm)),
        ),
        contacts=tuple(_contacts(file, document)),
        path=file,
        input=_input(file, document.input),
        weights=document.estimator.weights,
    )


@contextmanager
def _blame(file: Path, section: str) -> Iterator[None]:
    """Turn the model's ``ValueError("field: reason")`` into an ``InputError`` with the file's key."""
    try:
        yield
    except ValueError as error:
        field, _, reason = str(error).partition(": ")
        *sections, field = [*([section] if section else []), *field.split(".")]
        raise InputError(file, ".".join([*sections, KEYS.get(field, field)]), reason) from None


def _require_fem(section: LayerSection) -> None:
    if section.sampling != "point":
        raise ValueError("sampling: finite elements give the stress at points only")
    if not 0 <= section.poisson < 0.5:
        raise ValueError(f"poisson: finite elements need 0 <= nu < 0.5, got {section.poisson}")


def _sensor(file: Path, section: SensorSection) -> SensorArray:
    values: dict[SensorKey, Any] = {key: getattr(section, key.config) for key in sensor_keys()}
    with _blame(file, "sensor"):
        if (taxels := math.prod(value for key, value in values.items() if not key.unit)) > MOST_TAXELS:
            raise ValueError(f"rows: at most {MOST_TAXELS} taxels (rows x columns) are supported, got {taxels}")
        given: dict[str, Any] = {key.field: _metres(exact(x)) if key.is_length else x for key, x in values.items()}
        return SensorArray(**given)


def _design(file: Path, document: Document, sensor: SensorArray) -> Design:
    parts = {}
    makers: dict[str, Callable[..., Any]] = {"adc": Adc, "search": Search, "bus": Bus}
    for name, make in makers.items():
        with _blame(file, name):
            parts[name] = make(**_given(getattr(document, name)))
    with _blame(file, "formats"):
        parts["formats"] = _formats(document.formats)
    estimator, own = _estimator(file, document.estimator, sensor)
    with _blame(file, ""):
        return estimator(
            sensor=sensor,
            name=name_from(file.stem) if document.name is None else checked(document.name),
            architecture=_architecture(document.architecture, sensor),
            images=document.target.images,
            target=document.target.name,
            **parts,
            **own,
        )


def _given(section: Section) -> dict[str, Any]:
    """Values of the keys that are there, by the names of the model's fields."""
    names = {key: field for field, key in KEYS.items()}
    return {names.get(key, key): value for key, value in section if value is not None}


def _estimator(file: Path, section: EstimatorSection, sensor: SensorArray) -> tuple[type[Design], dict[str, Any]]:
    """The class of the design, and its fields beside the choices."""
    estimator, given = ESTIMATORS[section.kind], section.model_dump(exclude={"kind"}, exclude_none=True)
    with _blame(file, "estimator"):
        for key in (key for key in given if key not in estimator.config_keys):
            kinds = " or ".join(f'"{name}"' for name, each in ESTIMATORS.items() if key in each.config_keys)
            raise ValueError(f"{key}: belongs to kind = {kinds}")
        if "weights" in estimator.config_keys and "weights" not in given:
            raise ValueError(f'weights: is missing: kind = "{section.kind}" needs a file of tfra train')
    if "weights" in given:
        trained = read_weights(file.parent / given["weights"], sensor)
        given |= {"weights": trained.weights, "threshold": trained.threshold}
    return estimator, given


def _input(file: Path, section: InputSection) -> Input:
    given = section.model_dump(exclude_none=True)
    with _blame(file, "input"):
        return overridden(PLAIN, given | ({} if section.tare is None else {"tare": file.parent / section.tare}))


def _formats(section: FormatsSection) -> Formats:
    if section.name not in FORMATS:
        raise ValueError(f"name: one of {', '.join(FORMATS)} is needed, got {quoted(section.name)}")
    given = _given(section)
    base, signals = FORMATS[given.pop("name")], given.pop("signals").pairs()
    return replace(base, name="custom", signals=signals, **given) if given or signals else base


def _architecture(section: ArchitectureSection, sensor: SensorArray) -> Architecture:
    """Fill in defaults, limited to the parallelism that a small sensor can use."""
    most = 4 * -(-sensor.rows // 2) * -(-sensor.columns // 2)
    default = SERIAL if section.kind == SERIAL.kind else Architecture(min(Architecture().mac_lanes, most))
    return replace(default, **_given(section))


def _contacts(file: Path, document: Document) -> Iterator[Contact]:
    count = 0
    for number, section in enumerate(document.contact, 1):
        with _blame(file, f"contact#{number}"):
            directions = section.directions()
            count += len(directions)
            if count > MOST_CONTACTS:
                raise ValueError(f"phi_deg: at most {MOST_CONTACTS} directions of all contacts are supported")
            center_x = _center("x", section, document.sensor.columns, document.sensor.pitch_x_mm)
            center_y = _center("y", section, document.sensor.rows, document.sensor.pitch_y_mm)
            for degrees in directions:
                yield Contact(
                    shape=section.shape,  # type: ignore[arg-type]  # names are converted and checked there
                    center_x=_metres(center_x),
                    center_y=_metres(center_y),
                    half_x=_metres(exact(section.half_x_mm)),
                    half_y=_metres(exact(section.half_y_mm)),
                    normal_force=section.force_n,
                    mu=section.mu,
                    phi=math.radians(degrees),
                )


def _center(axis: str, section: ContactSection, count: int, pitch_mm: float) -> Fraction:
    """Return the centre along ``axis`` in mm; raises ``ValueError`` when the footprint leaves the block."""
    given = getattr(section, f"center_{axis}_mm")
    half, pitch = exact(getattr(section, f"half_{axis}_mm")), exact(pitch_mm)
    center = (count - 1) * pitch / 2 if given is None else exact(given)
    low, high = -pitch / 2, (count - Fraction(1, 2)) * pitch
    if center - half < low or center + half > high:
        key = f"half_{axis}_mm" if 2 * half > high - low else f"center_{axis}_mm"
        reach, block = _span(center - half, center + half), _span(low, high)
        raise ValueError(f"{key}: the footprint {reach} leaves the block {block}")
    return center


def _span(low: Fraction, high: Fraction) -> str:
    return f"from {float(low):g} to {float(high):g} mm"


def _metres(millimetres: Fraction) -> float:
    return float(millimetres / 1000)
