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
from tfra.model.skin.skin import Skin, core_of
from tfra.runtime.digest import digest


def files(array: Design | Skin) -> dict[str, str]:
    """Text of every file of a core, or of a skin, by its name.

    ``NAME.v`` is complete in itself, or with ``images = "readmemh"`` reads the memories' contents from the ``.hex``
    files beside it, which the sidecar lists; tools search for these in their working directory.
    ``coefficients/load.hex`` has the words for a core that is loaded after a reset.  ``testbench/NAME_tb.v`` checks
    itself in any Verilog simulator, in any directory; with it are models of the device's cells that the core has.

    Raises ``ValueError`` for formats that can overflow or a serial core that is too large.
    """
    facts, texts = core(array)
    design = core_of(array)
    models, loaded = microarchitecture(design).cell_models, microarchitecture(design).loaded
    texts |= {
        f"{array.name}.json": json.dumps(facts, indent=1) + "\n",
        f"testbench/{array.name}_tb.v": testbench(array, facts),
    }
    texts |= {f"testbench/{file.name}": file.read_text() for file in models}
    if loaded is not None:
        texts[LOADED] = hex_words(loaded, design.coefficient_word)
    return texts


def core(array: Design | Skin) -> tuple[dict[str, Any], dict[str, str]]:
    """The sidecar, and the texts of the files that synthesis reads; raises as :func:`files`."""
    verilog, design = to_verilog(array), core_of(array)
    verilog, images = extract(verilog) if design.images == "readmemh" else (verilog, [])
    facts = sidecar(array, [image.facts for image in images])
    cells = [file.stem for file in microarchitecture(design).cell_models]
    texts = {image.file: hex_words(image.words, image.bits) for image in images}
    return facts, texts | {f"{array.name}.v": header(facts, cells) + verilog}


def modules(array: Design | Skin, *, package: bool, pins: bool) -> dict[str, str]:
    """Files that synthesis reads: the core's, then with ``package`` its wrapper, then with ``pins`` these around it.

    Raises as :func:`files` and :func:`wrapper.wrapper_verilog`.
    """
    _, texts = core(array)
    name, ports = array.name, core_ports(array)
    if package:
        name, ports = module_name(array), ports_of(array)
        texts[f"{name}.v"] = wrapper_verilog(array)
    return texts | ({f"{name}_pins.v": pins_verilog(name, ports)} if pins else {})


def fingerprint(texts: Iterable[str]) -> str:
    """A hash of the files that synthesis reads, but for their comments."""
    return digest(*sorted(re.sub("^//.*\n", "", text, flags=re.M) for text in texts))
