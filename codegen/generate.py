"""``tfra generate``: a directory with the core's Verilog, its coefficient images, a testbench and the sidecar."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tfra.codegen.package.folder import package
from tfra.codegen.package.part import Part
from tfra.codegen.sidecar.build import LOADED, sidecar
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.header import header
from tfra.codegen.verilog.memories import extract
from tfra.codegen.verilog.testbench import hex_words, testbench
from tfra.hdl.cores import microarchitecture
from tfra.model.fixed.design import Design
from tfra.runtime.outputs import output_directory


def generate(
    design: Design, directory: Path, inputs: Sequence[Path] = (), part: Part | None = None
) -> dict[str, Any]:
    """Write everything of ``design``, which comes from the files ``inputs``, into ``directory`` and return the sidecar.

    ``NAME.v`` is complete in itself, or with ``images = "readmemh"`` reads the memories' contents from the ``.hex``
    files beside it, which the sidecar lists; tools search for these in their working directory.
    ``coefficients/load.hex`` has the words for a core that is loaded after a reset.  ``testbench/NAME_tb.v`` checks
    itself in any Verilog simulator, in any directory.  The same design gives the same bytes.

    With a ``part``, the directory is a package for the projects of others: :mod:`tfra.codegen.package.folder`.

    Raises ``ValueError`` for formats that can overflow or a serial core that is too large, and ``InputError`` for a
    directory that can't be written, or a name that a package can't have; all leave the directory as it was.
    """
    with output_directory(directory, "generate", inputs) as fresh:
        facts, texts = content(design)
        texts |= package(design, facts, texts, part) if part else {}
        for name, text in texts.items():
            (fresh / name).parent.mkdir(parents=True, exist_ok=True)
            (fresh / name).write_text(text, encoding="utf-8", newline="\n")
            if name.endswith(".sh"):
                (fresh / name).chmod(0o755)
    return facts


def content(design: Design) -> tuple[dict[str, Any], dict[str, str]]:
    """The sidecar, and the text of every file by its name; raises as ``generate``."""
    verilog = to_verilog(design)
    verilog, images = extract(verilog) if design.images == "readmemh" else (verilog, [])
    core = microarchitecture(design)
    words = core.loaded
    facts = sidecar(design, [image.facts for image in images])
    return facts, {
        f"{design.name}.v": header(facts, [file.stem for file in core.cell_models]) + verilog,
        **{image.file: hex_words(image.words, image.bits) for image in images},
        f"{design.name}.json": json.dumps(facts, indent=1) + "\n",
        **({} if words is None else {LOADED: hex_words(words, design.coefficient_word)}),
        **{f"testbench/{name}": text for name, text in testbench(design, facts).items()},
    }
