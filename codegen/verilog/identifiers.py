"""Names of a netlist as plain Verilog identifiers, which no tool has to escape."""

import re
from itertools import chain, count

from tfra.codegen.config.names import KEYWORDS, SIMULATORS

_NAME = re.compile(r'(?<=\\)[^\s"\\]+')
"""A public name in RTLIL, without its backslash; in a text, as that of a memory, there are two."""

_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def with_plain_names(rtlil: str) -> str:
    r"""``rtlil`` with plain names of modules, ports, wires, instances and memories; different ones stay different.

    ``\core.lane0`` becomes ``\core__lane0``: cores of different names have no module in common.  Names that begin with
    ``$`` are yosys' own, which it replaces by numbers when it writes Verilog.
    """
    names = dict.fromkeys(_NAME.findall(rtlil))
    renamed = {name: name for name in names if _is_plain(name)}
    taken = set(renamed)
    for name in names:
        if name not in renamed:
            renamed[name] = _free(_plain(name), taken)
            taken.add(renamed[name])
    return _NAME.sub(lambda match: renamed[match[0]], rtlil)


def _is_plain(name: str) -> bool:
    return bool(_PLAIN.fullmatch(name)) and name not in KEYWORDS | SIMULATORS


def _plain(name: str) -> str:
    word = re.sub(r"[^A-Za-z0-9_]", "_", name.replace(".", "__")).strip("_")
    return word if _is_plain(word) else f"n_{word}"


def _free(name: str, taken: set[str]) -> str:
    """``name``, with a number if it is taken."""
    return next(free for free in chain([name], (f"{name}_{number}" for number in count(2))) if free not in taken)
