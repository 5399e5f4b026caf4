"""``tfra generate``: a directory with the core's Verilog, its coefficient images and the sidecar."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tfra.codegen.files import atomic_directory
from tfra.codegen.images import lane_images
from tfra.codegen.sidecar import sidecar
from tfra.codegen.verilog import to_verilog
from tfra.model.design import Design


def generate(design: Design, directory: Path) -> dict[str, Any]:
    """Write everything of ``design`` into ``directory`` and return the sidecar.

    ``NAME.v`` is complete in itself.  ``coefficients/lane_NN.hex`` hold what its lanes' memories are initialised
    with, in the format of ``$readmemh``, for flows that fill memories in their own way.  The same design gives the
    same bytes.  Raises ``ValueError`` for formats that can overflow and ``InputError`` for a directory that can't be
    written; either leaves the directory as it was.
    """
    facts = sidecar(design)
    verilog = to_verilog(design)
    with atomic_directory(directory, f"{design.name}.json") as fresh:
        (fresh / f"{design.name}.v").write_text(verilog)
        (fresh / f"{design.name}.json").write_text(json.dumps(facts, indent=1) + "\n")
        (fresh / "coefficients").mkdir()
        for lane, text in enumerate(hex_images(design)):
            (fresh / "coefficients" / f"lane_{lane:02}.hex").write_text(text)
    return facts


def hex_images(design: Design) -> list[str]:
    """One ``$readmemh`` text for each lane: two's complement words, one a line."""
    bits = design.formats.coefficient
    digits, mask = -(-bits // 4), (1 << bits) - 1
    return ["".join(f"{int(word) & mask:0{digits}x}\n" for word in image) for image in lane_images(design)]
