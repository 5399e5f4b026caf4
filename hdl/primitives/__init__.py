"""Primitives that depend on the FPGA family, each with one interface: multiplier and coefficient memory.

The design's target chooses the variant.  ``"portable"`` is plain Amaranth; the variants of other targets instantiate
the family's cells, whose simulation models are in ``models``.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from tfra.hdl.primitives.multiplier import Multiplier
from tfra.hdl.primitives.rom import Rom

__all__ = ["Multiplier", "Rom", "cell_models", "models"]

_CELLS = {"portable": (), "ecp5": ("DP16KD", "MULT18X18D"), "ice40": ()}


def cell_models(target: str) -> tuple[Path, ...]:
    """Verilog files with models of the cells that these primitives instantiate for ``target``."""
    return models(_CELLS[target])


def models(cells: Iterable[str]) -> tuple[Path, ...]:
    """Verilog files with models of ``cells``."""
    return tuple(Path(__file__).parent / "models" / f"{cell}.v" for cell in cells)
