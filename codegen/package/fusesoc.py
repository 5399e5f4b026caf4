"""``NAME.core``: the package for FuseSoC, in CAPI2."""

from __future__ import annotations

import json
from collections.abc import Iterable

from tfra.codegen.package.contents import Contents, filled
from tfra.codegen.registers.files import VENDOR

_SYNTHESIS: dict[str, tuple[str, dict[str, str | list[str]]]] = {
    "ecp5": ("trellis", {"yosys_synth_options": ["-no-rw-check"]}),
    "ice40": (
        "icestorm",
        {
            "nextpnr_options": ["--up5k", "--package", "sg48"],
            "yosys_synth_options": ["-dsp", "-spram", "-device", "u", "-no-rw-check"],
        },
    ),
    "portable": ("vivado", {"part": "xc7a35tcsg324-1"}),
}
"""The tool of a design's target, and its options."""


def fusesoc(contents: Contents) -> dict[str, str]:
    """Targets ``default``, ``sim`` (Icarus), ``lint`` (Verilator) and ``synth``."""
    tool, options = _SYNTHESIS[contents.design.target]
    if tool == "trellis":
        size = contents.part.name.split("-")[1]
        options = {**options, "nextpnr_options": [f"--{size}k", "--package", "CABGA381"]}
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
    return {f"{contents.name}.core": filled("fusesoc.core", values)}


def _listed(names: Iterable[str]) -> str:
    return f"[{', '.join(names)}]"
