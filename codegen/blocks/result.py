"""A result in C and C++: types that the blocks name, and its words in the order of the core's stream."""

from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import Field

NAMED = {key: f"{key}_t" for key in ("exponent", "sweep_index", "phi", "mu", "status")} | {"resultant": "force_t"}
"""Types of fields that the blocks name."""


def dimensions(count: int) -> str:
    """Those of a field of ``count`` words, as C declares them."""
    return {1: "", 3: "[3]"}.get(count, f"[3][{count // 3}]")


def gathered(design: Design, *, si: bool = False) -> str:
    """Statements that copy ``result`` to ``words``, in the order of the core's stream.

    With ``si`` they copy values in SI units to ``values``: a force times ``scale``, which is 2^-exponent.
    """
    return "\n".join(_gathered(field, design.sensor.taxels, si) for field in design.layout)


def _gathered(field: Field, taxels: int, si: bool) -> str:
    axes, place = "", f"result->{field.name}"
    if field.count > 1:
        axes, place = "    for (int axis = 0; axis < 3; axis++)\n    ", f"{place}[axis]"
    if field.count > 3:
        axes, place = f"{axes}    for (int taxel = 0; taxel < {taxels}; taxel++)\n        ", f"{place}[taxel]"
    scaled = f"{place} * {field.lsb!r}{' * scale' if field.unit == 'N' else ''}"
    return f"{axes}    {f'values[place++] = {scaled}' if si else f'words[place++] = {place}'};"
