"""The clock that a core can count on before it is placed: no more than was measured, and than is aimed at."""

from dataclasses import dataclass

from tfra.codegen.package.contents import placed
from tfra.families import Target


@dataclass(frozen=True, slots=True)
class Clock:
    """A clock in MHz, what it is known from, and whether cores of the kind were measured on the part."""

    mhz: float
    basis: str
    measured: bool


def clock_of(kind: str, target: Target) -> Clock:
    """The slowest clock measured of cores of ``kind`` on ``target``, or the aim of place and route if that is less.

    Place and route is content with its aim, so a core that is placed by default may not reach more.
    """
    rows = [row for row in placed() if (row["target"], row["architecture"]["kind"]) == (target.name, kind)]
    slowest = min((row["clock"]["lowest_mhz"] for row in rows if row["clock"]), default=None)
    aim = "the aim of place and route" if target.family.place_and_route else "assumed"
    if slowest is None:
        return Clock(target.clock_mhz, f"{aim}; no {kind} core was measured on {target.name}", measured=False)
    if slowest < target.clock_mhz:
        return Clock(slowest, f"the slowest {kind} core measured on {target.name}", measured=True)
    reached = f"{kind} cores measured on {target.name} reach {slowest:g} MHz or more"
    return Clock(target.clock_mhz, f"{aim}; {reached}", measured=True)
