"""Cycles of a fixed schedule, which begins at cycle 0; registers are loaded at the end of theirs."""

from __future__ import annotations


def once(cycle: int) -> range:
    """One cycle, as a window."""
    return range(cycle, cycle + 1)


def later(window: range, cycles: int) -> range:
    """``window`` so many cycles later: the next register of a pipeline."""
    return range(window.start + cycles, window.stop + cycles)
