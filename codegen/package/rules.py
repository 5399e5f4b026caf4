"""``netlist/prepare.py``: a family's changes of a netlist before place and route, as a program of their own."""

import inspect
import re
from importlib import import_module

from tfra.codegen.package.contents import Contents
from tfra.families import targets_of

_IMPORT = re.compile(r"^(?:import|from) .*\n", re.M)


def rules(contents: Contents) -> dict[str, str]:
    """The program, for a family with such changes: the texts of its rules, which need Python alone, one after another.

    With it, the package's Verilog becomes the netlist that ``tfra synth`` places.
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
