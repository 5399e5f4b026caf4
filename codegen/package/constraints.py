"""``constraints/NAME.sdc``: the clock's period, for tools that read Synopsys' format."""

from tfra.codegen.package.contents import Contents, fill


def constraints(contents: Contents) -> dict[str, str]:
    """Constraints of the wrapper and of the core, whichever is the top module."""
    return {f"constraints/{contents.name}.sdc": fill("constraints.sdc", timing(contents))}


def timing(contents: Contents) -> dict[str, str]:
    """Values for templates: the part, its clock and period."""
    part = contents.part
    return {
        "name": contents.name,
        "part": part.name,
        "mhz": f"{part.clock_mhz:g}",
        "period": f"{1000 / part.clock_mhz:.3f}",
    }
