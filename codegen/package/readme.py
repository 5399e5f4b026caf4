"""``README.md`` of a package: what each file is for, and the first commands."""

from tfra.codegen.package.contents import Contents, fill
from tfra.codegen.sidecar.build import LOADED

_FILES = (
    ("datasheet.html", "everything about the core on one page: words, cycles, registers, resets, faults; begin here"),
    ("{name}_axi.v", "the core behind AXI4-Lite and AXI4-Stream: the module for a system on chip"),
    ("{name}.v", "the core alone, in one file of plain Verilog; its head states ports, rules and words"),
    ("{name}.json", "the same facts for programs"),
    (LOADED, "coefficients, loaded after every reset"),
    ("{name}.core", "FuseSoC: targets sim, lint and synth"),
    ("testbench/{name}_tb.v", "checks every result word of the core in any simulator, needs no other file"),
    ("core.schema.json", "JSON Schema of {name}.json: what each of its keys means"),
    ("driver/tfra_driver.h", "driver in C99: all its functions; example.c shows how to use them"),
    ("python/tfra_host/__init__.py", "driver in Python; example.py shows how to use it"),
    ("registers/tfra.h", "registers for C"),
    ("registers/tfra.html", "registers, one by one"),
    ("registers/tfra.xml", "registers in IP-XACT"),
    ("constraints/{name}.sdc", "the clock, for tools that read SDC"),
    ("vivado/package_ip.tcl", "makes an IP core for Vivado's catalogue"),
    ("vivado/{name}_axi.xdc", "the clock, for Vivado"),
    ("litex/{name}.py", "a module for LiteX"),
    ("boards/{board}/build.sh", "bitstream for the board {board}: the core behind its serial line"),
    ("boards/talk.py", "talks to the board: loads it, sends frames, compares the results"),
)


def readme(contents: Contents) -> dict[str, str]:
    """Lists the files that are there."""
    board = contents.part.target.family.board
    names = {"name": contents.name, "board": board.name if board else ""}
    rows = [(file.format(**names), text.format(**names)) for file, text in _FILES]
    table = "\n".join(f"| `{file}` | {text} |" for file, text in rows if file in contents.texts)
    values = {**names, "files": table, "computes": contents.facts["computes"], "generator": contents.facts["generator"]}
    return {"README.md": fill("README.md", values)}
