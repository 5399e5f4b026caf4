"""Primitives that depend on the FPGA family, each with one interface: multiplier, coefficient memory, store.

The design's target chooses the variant.  ``"portable"`` is plain Amaranth; the variants of other targets instantiate
the family's cells, whose simulation models are in ``models``.
"""

from pathlib import Path

from tfra.families import FAMILIES
from tfra.hdl.primitives.gateware import Multiplier, Rom, Store

__all__ = ["Multiplier", "Rom", "Store", "cell_models"]


def cell_models(target: str, *primitives: str) -> tuple[Path, ...]:
    """Verilog files with models of the cells that ``primitives`` are made of for ``target``, in the cells' order."""
    cells = FAMILIES[target].gateware if target in FAMILIES else {}
    names = sorted(cells[primitive] for primitive in primitives if primitive in cells)
    return tuple(Path(__file__).parent / "models" / f"{name}.v" for name in names)
