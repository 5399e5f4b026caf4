"""The most steps that a core in C takes for a frame: what bounds its time."""

from tfra.codegen.blocks.constants import constants
from tfra.codegen.blocks.dialect import in_c
from tfra.codegen.blocks.program import blocks
from tfra.codegen.hls.lanes import lane_constants
from tfra.codegen.hls.loops import cycles, functions
from tfra.codegen.hls.source import sources
from tfra.model.fixed.design import Design


def most_steps(design: Design) -> int:
    """Iterations of all loops, one for one.

    They are counted in the blocks' C++, whose calls name the counts; the sweep has its loops in another order there.
    """
    lines = "\n".join(sources(design).values()).splitlines()
    found = functions("\n".join(line for line in lines if "#pragma" not in line))
    found |= functions(in_c(blocks(design).get("tfra/sweep", "")))
    values = {name: n for section in constants(design).values() for name, n in section.items()}
    limited = design.sensor.taxels
    return limited + cycles("estimate", found, values | lane_constants(design), each=1)
