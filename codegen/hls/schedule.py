"""The schedule that the loops and pragmas of an HLS core ask for; no tool has confirmed it."""

from collections.abc import Mapping

from tfra.codegen.hls.loops import Block, Call, Function, cycles


def schedule(found: Mapping[str, Function], top: str, values: Mapping[str, int]) -> dict[str, int]:
    """Cycles by the names of the processes, in their order, of the dataflow region ``top`` and of those in it.

    They are iterations of pipelines: to fill and to empty each takes some cycles more.
    """
    scheduled: dict[str, int] = {}
    for part in found[top].body.parts:
        if isinstance(part, Call) and part.name in found:
            if is_region(found[part.name].body):
                scheduled |= schedule(found, part.name, values)
            else:
                scheduled[part.name] = cycles(part.name, found, values)
    return scheduled


def is_region(block: Block) -> bool:
    """It is a dataflow region."""
    return any("DATAFLOW" in pragma for pragma in block.pragmas)
