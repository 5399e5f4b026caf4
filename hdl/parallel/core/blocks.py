"""The blocks of a core, and the cycles that they state."""

import gc
import warnings
from collections.abc import Callable, Iterable, Iterator
from operator import attrgetter
from typing import Any

from amaranth.hdl import UnusedElaboratable


class CoreBlocks:
    """A base of classes whose attributes are blocks, set in dataflow order and named as their instances."""

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return iter(vars(self).items())


def stated_cycles(build: Callable[[], CoreBlocks], names: Iterable[str]) -> dict[str, int]:
    """By "BLOCK.PROPERTY", the cycles that the blocks state; without those of blocks that are not there."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnusedElaboratable)
        blocks = build()
        cycles = {name: attrgetter(name)(blocks) for name in names if hasattr(blocks, name.partition(".")[0])}
        del blocks
        gc.collect()  # a block that was never elaborated warns when it is deleted: delete it here
    return cycles
