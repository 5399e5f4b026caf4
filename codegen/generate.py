"""``tfra generate``: a directory with the core's Verilog, its coefficient images, a testbench and the sidecar."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tfra.codegen.files import output_directory
from tfra.codegen.memories import extract
from tfra.codegen.sidecar import sidecar
from tfra.codegen.testbench import hex_words, testbench
from tfra.codegen.verilog import to_verilog
from tfra.hdl.cores import loaded
from tfra.hdl.parallel.matvec.images import LOAD, lane_images
from tfra.model.design import Design


def generate(design: Design, directory: Path, inputs: Sequence[Path] = ()) -> dict[str, Any]:
    """Write everything of ``design``, which comes from the files ``inputs``, into ``directory`` and return the sidecar.

    ``NAME.v`` is complete in itself, or with ``images = "readmemh"`` reads the memories' contents from the ``.hex``
    files beside it, which the sidecar lists; tools look for these in the directory they work in.
    ``coefficients/lane_NN.hex`` hold what the lanes' memories are initialised with, for flows that fill memories in
    their own way; ``coefficients/load.hex`` what a core wants after a reset that has none.  ``testbench`` checks itself
    in any Verilog simulator.  The same design gives the same bytes.

    Raises ``ValueError`` for formats that can overflow or a serial core that is too large, and ``InputError`` for a
    directory that can't be written; either leaves the directory as it was.
    """
    with output_directory(directory, "generate", inputs) as fresh:
        facts, texts = content(design)
        for name, text in texts.items():
            (fresh / name).parent.mkdir(exist_ok=True)
            (fresh / name).write_text(text)
    return facts


def content(design: Design) -> tuple[dict[str, Any], dict[str, str]]:
    """The sidecar, and the text of every file by its name; raises as ``generate``."""
    verilog = to_verilog(design)
    verilog, images = extract(verilog) if design.images == "readmemh" else (verilog, [])
    facts = sidecar(design) | {"images": [image.facts for image in images]}
    return facts, {
        f"{design.name}.v": verilog,
        **{image.file: hex_words(image.words, image.bits) for image in images},
        f"{design.name}.json": json.dumps(facts, indent=1) + "\n",
        **{f"coefficients/{name}": text for name, text in coefficient_files(design).items()},
        **{f"testbench/{name}": text for name, text in testbench(design, facts["interval_cycles"]).items()},
    }


def coefficient_files(design: Design) -> dict[str, str]:
    """Text for ``$readmemh`` by name: a file for each lane's memory, or one of what is loaded."""
    bits, words = design.formats.coefficient, loaded(design)
    if words is not None:
        return {LOAD: hex_words(words, bits)}
    return {f"lane_{lane:02}.hex": hex_words(image, bits) for lane, image in enumerate(lane_images(design))}
