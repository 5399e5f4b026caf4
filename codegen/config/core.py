"""Whether a core can be made of a CONFIG file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tfra.runtime.errors import InputError

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project


def check_core(project: Project) -> None:
    """Prove that no word of the core overflows, and that a core of its kind can hold the design.

    Raises ``InputError`` when the formats are too long or the sensor is too large.
    """
    from tfra.hdl.cores import microarchitecture
    from tfra.model.fixed.feasibility import advice, fits

    try:
        microarchitecture(project.design).check()
    except ValueError as error:
        nearest = "" if fits(project.design) else advice(project.design)
        raise InputError(project.path, "", f"{error}{nearest and f': {nearest} would do'}") from None
