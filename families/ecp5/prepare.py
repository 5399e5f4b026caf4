"""What vendors' tools do to an ECP5's netlist and yosys does not: netlist in, netlist out."""

from collections import Counter
from typing import Any

from tfra.families.ecp5.copies import spread
from tfra.families.ecp5.floorplan import Floor, pin
from tfra.families.ecp5.registers import absorb


def prepare(netlist: dict[str, Any], top: str, floor: Floor | None = None) -> Counter[str]:
    """Change module ``top`` of yosys' JSON ``netlist``; return how many cells of each type were added.

    Registers move into hard blocks, what drives many lanes gets copies, and with ``floor`` hard blocks get sites.
    """
    moved = absorb(netlist, top)
    added = Counter(spread(netlist, top))
    added["TRELLIS_FF"] -= moved
    if floor:
        pin(netlist, top, floor)
    return added
