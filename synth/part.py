"""The part that a package describes its core for: the smallest one of the design's family that it fits."""

from __future__ import annotations

from tfra.codegen.package.part import Part
from tfra.model.fixed.design import Design
from tfra.synth.estimate import basis, estimate, misfits
from tfra.synth.targets import TARGETS, Target


def part_of(design: Design) -> Part:
    """A part, its default clock, and the core's estimated resources; ECP5s for designs of no family.

    A core that fits none gets the largest.
    """
    family = "ice40" if design.target == "ice40" else "ecp5"
    targets = {target.available["LUT"]: target for target in reversed(TARGETS.values()) if target.family.name == family}
    total = estimate(design, next(iter(targets.values())).family).total
    kind = design.architecture.kind
    ordered = [targets[size] for size in sorted(targets)]
    target: Target = next((one for one in ordered if not misfits(total, one, kind)), ordered[-1])
    resources = {name: (total[name], have) for name, have in target.available.items()}
    return Part(target.name, target.clock_mhz, resources, basis(kind, target.family, design.estimator))
