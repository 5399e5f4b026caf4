"""``netlist``: what ``tfra synth`` does after the Verilog, as programs that need the tools and Python alone."""

import inspect
import re
from importlib import import_module
from importlib.resources import files

from tfra.codegen.package.contents import Contents
from tfra.codegen.sidecar.build import core_ports
from tfra.codegen.verilog.emit import STRICT
from tfra.codegen.verilog.pins import pins_verilog
from tfra.codegen.verilog.wrapper import ports_of
from tfra.families import targets_of

_IMPORT = re.compile(r"^(?:import|from) .*\n", re.M)


def rules(contents: Contents) -> dict[str, str]:
    """``prepare.py``, for a family with changes of the netlist before place and route.

    It is made of the texts of the family's rules, which need Python alone, one after another.
    """
    family = contents.part.target.family
    if not (family.prepare and family.place_and_route):
        return {}
    texts = [inspect.getsource(import_module(name)) for name in family.rules]
    imports = {line for text in texts for line in _IMPORT.findall(text) if "tfra." not in line}
    floors = {target.part: target.floor for target in targets_of(family)}
    program = contents.fill(
        "prepare.py.txt",
        family=family.title,
        routing=" ".join(family.place_and_route.routing),
        free=" ".join(family.place_and_route.free),
        imports="".join(sorted(imports)),
        rules="\n\n".join(_IMPORT.sub("", text).strip() + "\n" for text in texts),
        prepare=inspect.getsource(family.prepare),
        floors="\n".join(f'    "{part}": {floor},' for part, floor in floors.items()),
    )
    return {"netlist/prepare.py": program}


def placed(contents: Contents) -> dict[str, str]:
    """``place.py``, which places the wrapper, or the core alone if the part has no room for more; and what it reads."""
    target, array = contents.part.target, contents.array
    tool = target.family.place_and_route
    if tool is None:
        return {}
    name, rtl, ports = contents.wrapper, contents.rtl, ports_of(array)
    if not contents.part.fits:
        name, rtl, ports = array.name, contents.rtl[:1], core_ports(array)
    top = f"{name}_pins"
    verilog = [*rtl, f"netlist/{top}.v"]
    read = " ".join(file.rpartition("/")[2] for file in verilog)
    script = f"read_verilog {read}; {target.family.synthesis.format(top=top)}; write_json netlist.json"
    constrained = [word.format(file="pins.lpf") for word in tool.constrained]
    importing, prepare = "", ""
    if target.family.prepare:
        importing = "import prepare\n"
        prepare = f'    prepare.main(str(BUILD / "netlist.json"), "{top}", "{target.part}")\n'
    program = contents.fill(
        "place.py.txt",
        top=name,
        program=tool.program.removeprefix("yowasp-"),
        package=tool.program,
        clock=contents.measured["clock"]["asked_mhz"] if contents.measured else target.clock_mhz,
        files=[*verilog, *contents.images],
        yosys=[*STRICT, "-q", "-p", script],
        words=[*target.device, *target.speed, *tool.routing, "--timing-allow-fail", *constrained],
        free=[*tool.free],
        layout=[word.format(file="layout") for word in tool.layout],
        constraints=repr(tool.constraints),
        importing=importing,
        prepare=prepare,
    )
    return {
        f"netlist/{top}.v": pins_verilog(name, ports),
        "netlist/nextpnr.py": files("tfra.synth").joinpath("nextpnr.py").read_text("utf-8"),
        "netlist/place.py": program,
    }
