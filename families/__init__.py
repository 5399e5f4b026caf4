"""Device families, a file each, and their parts: facts alone, which gateware, package and synthesis ask for.

Resources of a part are the totals that nextpnr 0.11.1 reports as ``utilization``.
"""

from tfra.families import ecp5, gatemate, gowin, ice40, xilinx
from tfra.families.family import Family, Target
from tfra.runtime.errors import quoted

__all__ = [
    "DEFAULT",
    "DEFAULT_PART",
    "FAMILIES",
    "TARGETS",
    "Family",
    "Target",
    "find",
    "part_names",
    "parts",
    "targets_of",
]

_FILES = (ecp5, ice40, gowin, xilinx, gatemate)

FAMILIES: dict[str, Family] = {file.FAMILY.name: file.FAMILY for file in _FILES}
"""By name."""

TARGETS: dict[str, Target] = {target.name: target for file in _FILES for target in file.TARGETS}
"""By name, a family's from the smallest part to the largest, and a part's from the slowest grade."""

DEFAULT_PART = "ecp5-45"
"""The part of a study that names none."""

DEFAULT = ecp5.FAMILY
"""The family that a design is described and counted for if it names none."""


def find(name: str) -> Target:
    """The target called ``name``, of a part without its grade the slowest; raises ``ValueError`` that lists all."""
    for target in TARGETS.values():
        if name in (target.name, target.part):
            return target
    raise ValueError(f"one of {', '.join(TARGETS)} is needed, got {quoted(name)}")


def targets_of(family: Family) -> list[Target]:
    """The targets of ``family``, in the order of :data:`TARGETS`."""
    return [target for target in TARGETS.values() if target.family is family]


def parts() -> list[Target]:
    """Every part once, at its slowest grade, in the order of :data:`TARGETS`."""
    return [find(name) for name in dict.fromkeys(target.part for target in TARGETS.values())]


def part_names() -> str:
    """All parts in one line, with the speed grades of each family after its parts: the help of commands."""
    texts = []
    for family in FAMILIES.values():
        parts = ", ".join(dict.fromkeys(target.part for target in targets_of(family)))
        grades = sorted({f"-{target.grade}" for target in targets_of(family) if target.grade})
        suffix = f" (suffix {', '.join(grades[:-1])} or {grades[-1]}: speed grade)" if grades else ""
        texts.append(parts + suffix)
    return ", ".join(texts)
