"""Names of signals that do not depend on the version of Python.

Amaranth names ``x = Signal()`` by the instruction that stores it.  From Python 3.13 on, one instruction may store a
variable and load or store another, which Amaranth 0.5 does not know: such a signal would lose its name.
"""

import sys
from opcode import opname
from typing import Any

from amaranth import tracer

_PAIRS = ("STORE_FAST_LOAD_FAST", "STORE_FAST_STORE_FAST")
_known = tracer.get_var_name


def name_of_variable(depth: int = 2, default: Any = tracer._raise_exception) -> Any:
    """What ``amaranth.tracer.get_var_name`` returns, or raises, also where an instruction stores and does more."""
    frame = sys._getframe(depth)
    code, index = frame.f_code.co_code, frame.f_lasti
    if opname[code[index]].startswith("CALL"):
        index += 2
        while opname[code[index]] in ("CACHE", "COPY"):
            index += 2
        if opname[code[index]] in _PAIRS:
            return frame.f_code.co_varnames[code[index + 1] >> 4]
    return _known(depth + 1, default)


tracer.get_var_name = name_of_variable
