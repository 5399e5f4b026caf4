"""From a CONFIG file in TOML to the objects of the model.

The keys carry units (``pitch_x_mm``, ``full_scale_pa``, ``phi_deg``); the objects are in SI and radians.
Millimetres become metres by exact decimal arithmetic, so 4.1 mm is the double nearest to 0.0041.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from tfra.codegen.config.complaints import blame, complaint
from tfra.codegen.config.contacts import read_contacts
from tfra.codegen.config.cover import LayerSpec, require_few_modes
from tfra.codegen.config.names import checked, name_from
from tfra.codegen.config.schema import (
    ArchitectureSection,
    ContactsSection,
    Document,
    EstimatorSection,
    FormatsSection,
    InputSection,
    LayerSection,
    Section,
    exact,
    metres,
)
from tfra.codegen.config.weights import read_weights
from tfra.codegen.config.write import KEYS, config_text
from tfra.model.arrays import Ints
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Bus, Formats, Search
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import ElasticLayer
from tfra.model.estimators import ESTIMATORS
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray, SensorKey, sensor_keys
from tfra.model.skin.finding import Finding
from tfra.model.skin.skin import Skin
from tfra.recordings.input import FILES, PLAIN, Input, overridden
from tfra.runtime.errors import InputError, quoted
from tfra.runtime.inputs import read_toml

MOST_TAXELS = 4096
"""The model holds dense matrices of taxels x taxels: 134 MB each at this limit."""

LONGEST_SIDE = 128
"""Rows or columns of a skin."""


@dataclass(frozen=True, slots=True)
class Project:
    """The content of a CONFIG file: the core, the simulated cover, the contacts, recordings, and the file itself.

    ``weights`` names the file of an estimator that is trained, relative to CONFIG's folder.  Of a ``skin``, ``design``
    is that of a window, and ``together`` so many contacts, one after the other, are those of a frame.
    """

    design: Design
    layer: LayerSpec
    contacts: tuple[Contact, ...]
    path: Path
    input: Input = PLAIN
    weights: str | None = None
    skin: Skin | None = None
    together: int = 1

    @property
    def frame(self) -> Ints | None:
        """The number of each contact's frame, if contacts share frames."""
        return np.arange(len(self.contacts)) // self.together if self.skin else None

    @property
    def array(self) -> Skin | Design:
        """What takes whole frames: its ``sensor`` and its ``adc`` are those of recordings."""
        return self.skin or self.design

    def text(self) -> str:
        """CONFIG that makes the same array, without contacts and recordings."""
        return config_text(self.design, self.layer, "", self.weights, self.skin)

    def require_array(self, command: str) -> None:
        """Raise ``InputError`` for a skin, which ``command`` knows nothing of."""
        if self.skin:
            raise InputError(self.path, "window", f"{command} takes no skins")


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
    sensor = _sensor(file, document)
    with blame(file, "layer"):
        cover = ElasticLayer.under(sensor, document.layer.poisson)
        if document.layer.solver == "fem":
            _require_fem(document.layer)
    with blame(file, "sensor"):
        require_few_modes(cover)
    design, skin = _array(file, document, sensor)
    contacts, together = read_contacts(file, document)
    return Project(
        design=design,
        layer=LayerSpec(
            document.layer.poisson,
            document.layer.sampling,
            document.layer.solver,
            metres(exact(document.layer.element_mm)),
        ),
        contacts=contacts,
        path=file,
        input=_input(file, document.input),
        weights=document.estimator.weights,
        skin=skin,
        together=together,
    )


def _require_fem(section: LayerSection) -> None:
    if section.sampling != "point":
        raise ValueError("sampling: finite elements give the stress at points only")
    if not 0 <= section.poisson < 0.5:
        raise ValueError(f"poisson: finite elements need 0 <= nu < 0.5, got {section.poisson}")


def _sensor(file: Path, document: Document) -> SensorArray:
    values: dict[SensorKey, Any] = {key: getattr(document.sensor, key.config) for key in sensor_keys()}
    with blame(file, "sensor"):
        given: dict[str, Any] = {key.field: metres(exact(x)) if key.is_length else x for key, x in values.items()}
        sensor = SensorArray(**given)
        if document.window is None:
            _require_few(sensor.taxels, " without a section window")
        for key in ("rows", "columns"):
            if getattr(sensor, key) > LONGEST_SIDE and document.window:
                raise ValueError(f"{key}: at most {LONGEST_SIDE} are supported, got {getattr(sensor, key)}")
        return sensor


def _require_few(taxels: int, hint: str = "") -> None:
    if taxels > MOST_TAXELS:
        raise ValueError(f"rows: at most {MOST_TAXELS} taxels (rows x columns) are supported{hint}, got {taxels}")


def _array(file: Path, document: Document, sensor: SensorArray) -> tuple[Design, Skin | None]:
    """The only core; or that of a window, and the skin that is made of it."""
    if document.window is None:
        if document.contacts:
            raise InputError(file, "contacts", "belongs to a skin: a section window is needed")
        return _design(file, document, sensor), None
    with blame(file, "window"):
        window = replace(sensor, rows=document.window.rows, columns=document.window.columns)
        _require_few(window.taxels)
    design = _design(file, document, window)
    with blame(file, "contacts"):
        choices = Finding(**_given(document.contacts or ContactsSection()))
    with blame(file, ""):
        return design, Skin(sensor, design, choices)


def _design(file: Path, document: Document, sensor: SensorArray) -> Design:
    parts = {}
    makers: dict[str, Callable[..., Any]] = {"adc": Adc, "search": Search, "bus": Bus}
    for name, make in makers.items():
        with blame(file, name):
            parts[name] = make(**_given(getattr(document, name)))
    with blame(file, "formats"):
        parts["formats"] = _formats(document.formats)
    estimator, own = _estimator(file, document.estimator, sensor, document.window is not None)
    with blame(file, ""):
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


def _estimator(
    file: Path, section: EstimatorSection, sensor: SensorArray, window: bool
) -> tuple[type[Design], dict[str, Any]]:
    """The class of the design, and its fields beside the choices."""
    estimator, given = ESTIMATORS[section.kind], section.model_dump(exclude={"kind"}, exclude_none=True)
    with blame(file, "estimator"):
        for key in (key for key in given if key not in estimator.config_keys):
            kinds = " or ".join(f'"{name}"' for name, each in ESTIMATORS.items() if key in each.config_keys)
            raise ValueError(f"{key}: belongs to kind = {kinds}")
        if "weights" in estimator.config_keys and "weights" not in given:
            raise ValueError(f'weights: is missing: kind = "{section.kind}" needs a file of tfra train')
    if "weights" in given:
        trained = read_weights(file.parent / given["weights"], sensor, window)
        given |= {"weights": trained.weights, "threshold": trained.threshold}
    return estimator, given


def _input(file: Path, section: InputSection) -> Input:
    given = section.model_dump(exclude_none=True)
    with blame(file, "input"):
        return overridden(PLAIN, given | {key: file.parent / given[key] for key in FILES if key in given})


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
