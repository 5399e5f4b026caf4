"""From a design to a CONFIG file of that design."""

import json
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from tfra.codegen.config.cover import LayerSpec
from tfra.model.choices import FORMATS, Formats
from tfra.model.estimators import DEFAULT
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray, sensor_keys

Value = str | int | float | Mapping[str, int]

Sections = dict[str, Mapping[str, Value]]
"""Keys and values by the name of their section, which is empty for those in front of all sections."""


def config_text(design: Design, layer: LayerSpec, comment: str, weights: str | None = None) -> str:
    """CONFIG in TOML, under lines of ``comment``: :func:`tfra.codegen.config.read.load` makes the same design of it.

    ``weights`` names the file of the learned estimator; with None, the estimator is TFRA.
    """
    lines = [f"# {line}" for line in comment.splitlines()]
    for title, keys in (sections(design, layer) | _estimator(design, weights)).items():
        if keys:
            lines += [*(["", f"[{title}]"] if title else []), *(assignment(key, keys[key]) for key in keys)]
    return "\n".join(lines) + "\n"


def sections(design: Design, layer: LayerSpec) -> Sections:
    """What CONFIG says of ``design`` and the cover."""
    adc, architecture = design.adc, design.architecture
    threshold = {} if adc.contact_threshold is None else {"contact_threshold_codes": adc.contact_threshold}
    lanes = {"mac_lanes": architecture.mac_lanes, "vector_words": architecture.vector_words}
    return {
        "": {"name": design.name},
        "sensor": sensor_section(design.sensor),
        "adc": {"bits": adc.bits, "full_scale_pa": adc.full_scale, **threshold},
        "search": {"steps": design.search.steps, "plateau_tolerance": design.search.tolerance},
        "formats": _formats(design.formats),
        "formats.signals": dict(design.formats.signals),
        "architecture": {"kind": architecture.kind, **(lanes if architecture.kind == "parallel" else {})},
        "target": {"name": design.target, "images": design.images},
        "bus": {"taxels_per_beat": design.bus.taxels_per_beat},
        "layer": {
            "poisson": layer.poisson,
            "sampling": layer.sampling,
            "solver": layer.solver,
            "element_mm": millimetres(layer.element),
        },
    }


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


def _formats(formats: Formats) -> Mapping[str, Value]:
    if formats.name in FORMATS:
        return {"name": formats.name}
    return {
        f"{key}_bits": getattr(formats, key)
        for key in ("coefficient", "operand", "vector_fraction", "force_fraction")
    }


def sensor_section(sensor: SensorArray) -> dict[str, int | float]:
    """Keys and values of ``[sensor]``."""
    values = {key: getattr(sensor, key.field) for key in sensor_keys()}
    return {key.config: millimetres(value) if key.is_length else value for key, value in values.items()}


def millimetres(metres: float) -> float:
    """The decimal number of millimetres that equals exactly these metres."""
    return float(Fraction(repr(metres)) * 1000)
