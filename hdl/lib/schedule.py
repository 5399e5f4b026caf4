"""Cycles of a fixed schedule, which begins at cycle 0; a register is loaded at the end of its cycle."""


def once(cycle: int) -> range:
    """One cycle, as a window."""
    return range(cycle, cycle + 1)


def later(window: range, cycles: int) -> range:
    """``window`` delayed by the given number of cycles: the next register of a pipeline."""
    return range(window.start + cycles, window.stop + cycles)
