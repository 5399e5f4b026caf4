"""The part that a package describes its core for: the smallest one of the design's family that it fits."""

from tfra.codegen.package.contents import Part
from tfra.families import DEFAULT, FAMILIES, targets_of
from tfra.model.fixed.design import Design
from tfra.synth.estimate import basis, estimate, misfits


def part_of(design: Design) -> Part:
    """A target of the slowest grade, and the core's estimated resources; ``DEFAULT``'s for designs of no family.

    A core that fits none gets the largest.
    """
    family, kind = FAMILIES.get(design.target, DEFAULT), design.architecture.kind
    total = estimate(design, family).total
    slowest = list({target.part: target for target in reversed(targets_of(family))}.values())[::-1]
    target = next((one for one in slowest if not misfits(total, one, kind)), slowest[-1])
    resources = {name: (total[name], have) for name, have in target.available.items()}
    return Part(target, resources, basis(kind, target.family, design.estimator))
