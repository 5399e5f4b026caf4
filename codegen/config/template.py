"""A commented CONFIG file for a sensor: the example that explains every key, with this sensor's values."""

import math
import re
from collections.abc import Iterator, Mapping

from tfra.codegen.config.cover import LayerSpec
from tfra.codegen.config.examples import examples
from tfra.codegen.config.write import Sections, Value, assignment, sections
from tfra.model.fixed.design import Design

EXAMPLE = "hertz_40x20"
"""It has a comment for every key."""

LOAD = 0.6
"""Peak pressure of the contact, as a share of full scale: no taxel gets over it."""

_COLUMN = 27
"""Where comments begin."""

_HEAD = re.compile(r"(?:# )?\[+(?P<name>\w+)\]+(?: +# .*)?")

_KEY = re.compile(r"(?P<off># )?(?P<key>\w+) = (?P<value>.+?)(?: +(?P<comment># .*))?")


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
