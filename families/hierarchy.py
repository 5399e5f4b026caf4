"""The block and the lane of the core that a cell belongs to, by its name in a flat netlist."""

import re


def block_of(path: str) -> str:
    """Block of ``hdl/parallel/tfra/core.py`` that a hierarchical name lies in: what follows the last ``core``."""
    parts = re.split(r"[./]", path.lstrip("\\"))
    place = len(parts) - parts[::-1].index("core") if "core" in parts else len(parts)
    return parts[place] if place < len(parts) else "top"


def lane_of(path: str) -> int | None:
    """MAC lane that a hierarchical name of a cell belongs to, if it does; of two that share a memory, the first.

    The register of the address has the name of one memory, but drives all of them.
    """
    places = r"lane|(?:rom|tail)\.memory(?!.*\.address)|drain\.sums__|drain\.captured"
    found = re.search(rf"\.matvec\.(?:{places})(\d+)", path)
    return int(found[1]) if found else None
