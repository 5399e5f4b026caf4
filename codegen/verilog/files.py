"""All files of a core in Verilog: the core, its sidecar, its memories' contents, a testbench."""

import json

from tfra.codegen.sidecar.build import LOADED, sidecar
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.header import header
from tfra.codegen.verilog.memories import extract
from tfra.codegen.verilog.testbench import hex_words, testbench
from tfra.hdl.cores import microarchitecture
from tfra.model.fixed.design import Design


def files(design: Design) -> dict[str, str]:
    """Text of every file by its name.

    ``NAME.v`` is complete in itself, or with ``images = "readmemh"`` reads the memories' contents from the ``.hex``
    files beside it, which the sidecar lists; tools search for these in their working directory.
    ``coefficients/load.hex`` has the words for a core that is loaded after a reset.  ``testbench/NAME_tb.v`` checks
    itself in any Verilog simulator, in any directory; with it are models of the device's cells that the core has.

    Raises ``ValueError`` for formats that can overflow or a serial core that is too large.
    """
    verilog = to_verilog(design)
    verilog, images = extract(verilog) if design.images == "readmemh" else (verilog, [])
    core = microarchitecture(design)
    facts = sidecar(design, [image.facts for image in images])
    texts = {
        f"{design.name}.v": header(facts, [file.stem for file in core.cell_models]) + verilog,
        f"{design.name}.json": json.dumps(facts, indent=1) + "\n",
        f"testbench/{design.name}_tb.v": testbench(design, facts),
    }
    texts |= {f"testbench/{file.name}": file.read_text() for file in core.cell_models}
    texts |= {image.file: hex_words(image.words, image.bits) for image in images}
    if core.loaded is not None:
        texts[LOADED] = hex_words(core.loaded, design.coefficient_word)
    return texts
