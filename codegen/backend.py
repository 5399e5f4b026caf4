"""The back ends: each turns a design into the files of one target language.

A new one takes a folder ``codegen/NAME/`` with a function ``files``, an entry in ``BACKENDS`` and its test.  Every back
end's files include the sidecar ``NAME.json`` of :mod:`tfra.codegen.sidecar.build`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from tfra.codegen.package.contents import Part
from tfra.codegen.package.folder import package
from tfra.codegen.verilog.files import files as verilog
from tfra.model.fixed.design import Design
from tfra.runtime.errors import InputError

Files = dict[str, str]
"""Text of every file by its name, with folders."""


@dataclass(frozen=True)
class Backend:
    """A back end by its ``name``; ``help`` is a line for users."""

    name: str
    help: str
    files: Callable[[Design], Files]
    """The files of a design, the same for the same design; raises ``ValueError`` for one that can't be built."""
    package: Callable[[Design, Mapping[str, str], Part], Files]
    """Further files around those given, for projects with the device."""


_ALL = (Backend("verilog", "Verilog of the core, its memories' contents and a testbench.", verilog, package),)

BACKENDS = {backend.name: backend for backend in _ALL}


def find_backend(name: str) -> Backend:
    """The back end ``name``; raises ``InputError`` for an unknown one."""
    if name not in BACKENDS:
        raise InputError("backend", name, f"one of {', '.join(BACKENDS)} is needed")
    return BACKENDS[name]
