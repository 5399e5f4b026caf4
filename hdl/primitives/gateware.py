"""What each family's cells are used for, by CONFIG's target; the rest is plain Amaranth.

A family that has no cells of its own in the gateware needs no row.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tfra.hdl.primitives import ecp5, ice40


@dataclass(frozen=True)
class Gateware:
    """Functions that make a primitive of cells inside a module and return its words; None: plain Amaranth.

    ``multiplier(m, a, b, enable)`` and ``rom(m, images, bits, address, enable, write, data)`` answer two enabled cycles
    later, ``store(m, bits, address, write, data)`` one cycle later.
    """

    multiplier: Callable[..., Any] | None = None
    rom: Callable[..., Any] | None = None
    store: Callable[..., Any] | None = None


GATEWARE = {
    "portable": Gateware(),
    "ecp5": Gateware(multiplier=ecp5.multiplier, rom=ecp5.rom),
    "ice40": Gateware(store=ice40.store),
}
