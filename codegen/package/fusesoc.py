"""``NAME.core``: the package for FuseSoC, in CAPI2."""

import json
from collections.abc import Iterable

from tfra.codegen.package.contents import Contents, fill
from tfra.codegen.registers.files import VENDOR
from tfra.families import FAMILIES, xilinx


def fusesoc(contents: Contents) -> dict[str, str]:
    """Targets ``default``, ``sim`` (Icarus), ``lint`` (Verilator) and ``synth``."""
    family = FAMILIES.get(contents.design.target)
    tool, options = (family or xilinx.FAMILY).project
    if family:
        options = {**options, "nextpnr_options": [*contents.part.target.device]}
    rules = [f"{name}: {{file_type: vlt}}" for name in contents.rules]
    copied = [f"{name}: {{file_type: user, copyto: {name}}}" for name in contents.images]
    values = {
        "name": contents.name,
        "vendor": VENDOR,
        "version": contents.version,
        "description": json.dumps(f"Computes {contents.facts['computes']}"),
        "rtl": _listed([*contents.rtl, *copied]),
        "simulated": _listed([*contents.cells, f"testbench/{contents.name}_tb.v"]),
        "linted": _listed([*rules, *contents.rtl, *contents.cells]),
        "top": contents.wrapper if len(contents.rtl) > 1 else contents.name,
        "tool": tool,
        "options": json.dumps(options),
    }
    return {f"{contents.name}.core": fill("fusesoc.core", values)}


def _listed(names: Iterable[str]) -> str:
    return f"[{', '.join(names)}]"
