"""All files of a core in Verilog: the core, its sidecar, its memories' contents, a testbench."""

import json
import re
from collections.abc import Iterable
from typing import Any

from tfra.codegen.sidecar.build import LOADED, core_ports, sidecar
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.header import header
from tfra.codegen.verilog.memories import extract
from tfra.codegen.verilog.pins import pins_verilog
from tfra.codegen.verilog.testbench import hex_words, testbench
from tfra.codegen.verilog.wrapper import module_name, ports_of, wrapper_verilog
from tfra.hdl.cores import microarchitecture
from tfra.model.fixed.design import Design
from tfra.runtime.digest import digest


def files(design: Design) -> dict[str, str]:
    """Text of every file by its name.

    ``NAME.v`` is complete in itself, or with ``images = "readmemh"`` reads the memories' contents from the ``.hex``
    files beside it, which the sidecar lists; tools search for these in their working directory.
    ``coefficients/load.hex`` has the words for a core that is loaded after a reset.  ``testbench/NAME_tb.v`` checks
    itself in any Verilog simulator, in any directory; with it are models of the device's cells that the core has.

    Raises ``ValueError`` for formats that can overflow or a serial core that is too large.
    """
    facts, texts = core(design)
    models, loaded = microarchitecture(design).cell_models, microarchitecture(design).loaded
    texts |= {
        f"{design.name}.json": json.dumps(facts, indent=1) + "\n",
        f"testbench/{design.name}_tb.v": testbench(design, facts),
    }
    texts |= {f"testbench/{file.name}": file.read_text() for file in models}
    if loaded is not None:
        texts[LOADED] = hex_words(loaded, design.coefficient_word)
    return texts


def core(design: Design) -> tuple[dict[str, Any], dict[str, str]]:
    """The sidecar, and the texts of the files that synthesis reads; raises as :func:`files`."""
    verilog = to_verilog(design)
    verilog, images = extract(verilog) if design.images == "readmemh" else (verilog, [])
    facts = sidecar(design, [image.facts for image in images])
    cells = [file.stem for file in microarchitecture(design).cell_models]
    texts = {image.file: hex_words(image.words, image.bits) for image in images}
    return facts, texts | {f"{design.name}.v": header(facts, cells) + verilog}


def modules(design: Design, *, package: bool, pins: bool) -> dict[str, str]:
    """Files that synthesis reads: the core's, then with ``package`` its wrapper, then with ``pins`` these around it.

    Raises as :func:`files` and :func:`wrapper.wrapper_verilog`.
    """
    _, texts = core(design)
    name, ports = design.name, core_ports(design)
    if package:
        name, ports = module_name(design), ports_of(design)
        texts[f"{name}.v"] = wrapper_verilog(design)
    return texts | ({f"{name}_pins.v": pins_verilog(name, ports)} if pins else {})


def fingerprint(texts: Iterable[str]) -> str:
    """A hash of the files that synthesis reads, but for their comments."""
    return digest(*sorted(re.sub("^//.*\n", "", text, flags=re.M) for text in texts))
