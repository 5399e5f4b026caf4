"""The front end between the converters and the core: what it is built for."""

from __future__ import annotations


def repair_places(taxels: int) -> int:
    """Words of the table of repairs: enough for a tenth of the ``taxels``, each with twelve neighbours; a power of two.

    A block memory has 512 places at least.
    """
    return max(512, 1 << (13 * -(-taxels // 10) - 1).bit_length())
