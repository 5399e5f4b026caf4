"""From a design to a CONFIG file of that design: plain, or with a comment on every key."""

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from fractions import Fraction
from typing import Any

from tfra.codegen.config.cover import LayerSpec
from tfra.codegen.config.examples import examples
from tfra.model.choices import FORMATS
from tfra.model.estimators import DEFAULT
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray, sensor_keys
from tfra.model.skin.skin import Skin

KEYS = {
    "full_scale": "full_scale_pa",
    "contact_threshold": "contact_threshold_codes",
    "tolerance": "plateau_tolerance",
    "coefficient": "coefficient_bits",
    "operand": "operand_bits",
    "vector_fraction": "vector_fraction_bits",
    "force_fraction": "force_fraction_bits",
    "normal_force": "force_n",
}
"""Keys of the file by the model's fields, where they have other names."""

EXAMPLE = "hertz_40x20"
"""It has a comment for every key."""

LOAD = 0.6
"""Peak pressure of the contact, as a share of full scale: no taxel gets over it."""

_COLUMN = 27
"""Where comments begin."""

_HEAD = re.compile(r"(?:# )?\[+(?P<name>\w+)\]+(?: +# .*)?")

_KEY = re.compile(r"(?P<off># )?(?P<key>\w+) = (?P<value>.+?)(?: +(?P<comment># .*))?")

Value = str | int | float | Mapping[str, int]

Sections = dict[str, Mapping[str, Value]]
"""Keys and values by the name of their section, which is empty for those in front of all sections."""


def config_text(
    design: Design, layer: LayerSpec | None, comment: str, weights: str | None = None, skin: Skin | None = None
) -> str:
    """CONFIG in TOML, under lines of ``comment``: :func:`tfra.codegen.config.read.load` makes the same design of it.

    Without a ``layer``, the cover is the default one.  ``weights`` names the file of the learned estimator; with None,
    the estimator is TFRA.  Of a ``skin``, ``design`` is that of a window.
    """
    lines = [f"# {line}" for line in comment.splitlines()]
    for title, keys in (sections(design, layer) | _skin(skin) | _estimator(design, weights)).items():
        if keys:
            lines += [*(["", f"[{title}]"] if title else []), *(assignment(key, keys[key]) for key in keys)]
    return "\n".join(lines) + "\n"


def sections(design: Design, layer: LayerSpec | None) -> Sections:
    """What CONFIG says of ``design`` and the cover."""
    architecture, formats = design.architecture, design.formats
    lengths = ("coefficient", "operand", "vector_fraction", "force_fraction")
    cover = ("poisson", "sampling", "solver")
    lanes = {"mac_lanes": architecture.mac_lanes, "vector_words": architecture.vector_words}
    return {
        "": {"name": design.name},
        "sensor": sensor_section(design.sensor),
        "adc": _keys(design.adc),
        "search": _keys(design.search),
        "formats": {"name": formats.name} if formats.name in FORMATS else _keys(formats, lengths),
        "formats.signals": dict(formats.signals),
        "architecture": {"kind": architecture.kind, **(lanes if architecture.kind == "parallel" else {})},
        "target": {"name": design.target, "images": design.images},
        "bus": _keys(design.bus),
        "layer": _keys(layer, cover) | {"element_mm": millimetres(layer.element)} if layer else {},
    }


def _skin(skin: Skin | None) -> Sections:
    if skin is None:
        return {}
    window = dict(zip(("rows", "columns"), skin.shape, strict=True))
    return {"sensor": sensor_section(skin.sensor), "window": window, "contacts": _keys(skin.choices)}


def assignment(key: str, value: Value) -> str:
    """``key = value`` in TOML."""
    if isinstance(value, Mapping):
        return f"{key} = {{ {', '.join(assignment(*pair) for pair in value.items())} }}"
    return f"{key} = " + (json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else repr(value))


def _estimator(design: Design, weights: str | None) -> Sections:
    """The section of the estimator; none of the default one, or where weights are needed but not named."""
    values: dict[str, Any] = {key: weights if key == "weights" else getattr(design, key) for key in design.config_keys}
    if design.estimator == DEFAULT or None in values.values():
        return {}
    return {"estimator": {"kind": design.estimator, **values}}


def _keys(part: Any, names: Iterable[str] = ()) -> dict[str, Value]:
    """Keys and values of a ``part`` of a design: of its fields ``names``, by default all, those that are not None."""
    values = {name: getattr(part, name) for name in names or (field.name for field in fields(part))}
    return {KEYS.get(name, name): value for name, value in values.items() if value is not None}


def sensor_section(sensor: SensorArray) -> dict[str, int | float]:
    """Keys and values of ``[sensor]``."""
    values = {key: getattr(sensor, key.field) for key in sensor_keys()}
    return {key.config: millimetres(value) if key.is_length else value for key, value in values.items()}


def millimetres(metres: float) -> float:
    """The decimal number of millimetres that equals exactly these metres."""
    return float(Fraction(repr(metres)) * 1000)


def commented(design: Design, layer: LayerSpec) -> str:
    """CONFIG in TOML with a comment on every key; what ``design`` leaves to its default is commented out.

    It has a contact to simulate.  :func:`tfra.codegen.config.read.load` makes the same design of it.
    """
    sensor = design.sensor
    size = f"{sensor.rows} x {sensor.columns} taxels"
    title = f"# A sensor of {size}, pressed by a rounded tip that drags in 24 directions."
    chosen = sections(design, layer) | {"": {}, "contact": _contact(design)}
    middle = {"center_x_mm": 5e2 * (sensor.columns - 1) * sensor.pitch_x}
    middle |= {"center_y_mm": 5e2 * (sensor.rows - 1) * sensor.pitch_y}
    defaults: Sections = {
        "": {"name": design.name},
        "adc": {"contact_threshold_codes": design.adc.threshold},
        "contact": {key: _rounded(value) for key, value in middle.items()},
    }
    return "\n".join([title, *_lines(examples()[EXAMPLE].splitlines()[1:], chosen, defaults)]) + "\n"


def _lines(template: list[str], chosen: Sections, defaults: Sections) -> Iterator[str]:
    """The lines of ``template`` with the values ``chosen``; other keys are commented out, with their ``defaults``.

    Remarks on the template's own values are left out.
    """
    section = ""
    for line in template:
        if head := _HEAD.fullmatch(line):
            section = head["name"]
        elif match := _KEY.fullmatch(line):
            yield _assigned(match, chosen.get(section, {}), defaults.get(section, {}))
            continue
        elif section and line.startswith("#"):
            continue
        yield line


def _assigned(match: re.Match[str], chosen: Mapping[str, Value], defaults: Mapping[str, Value]) -> str:
    key = match["key"]
    if key in chosen:
        text = assignment(key, chosen[key])
    else:
        text = "# " + (assignment(key, defaults[key]) if key in defaults else f"{key} = {match['value']}")
    return f"{text:{_COLUMN - 1}} {match['comment'] or ''}".rstrip()


def _contact(design: Design) -> dict[str, Value]:
    """A contact in the middle that covers two fifths of the array in each direction, and one taxel at least."""
    sensor = design.sensor
    half_x, half_y = (
        max(0.2 * count, 0.9) * pitch
        for count, pitch in ((sensor.columns, sensor.pitch_x), (sensor.rows, sensor.pitch_y))
    )
    force = LOAD * design.adc.full_scale * 2 / 3 * math.pi * half_x * half_y  # Hertz: the peak is 3/2 of the mean
    return {
        "shape": "hertz",
        "half_x_mm": _rounded(1e3 * half_x),
        "half_y_mm": _rounded(1e3 * half_y),
        "force_n": -_rounded(force),
        "mu": 0.5,
        "phi_deg": {"start": 0, "stop": 360, "step": 15},
    }


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")
