"""The register map as SystemRDL states it: ``tfra.rdl`` compiled, and as plain data with the values of a design."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfra.codegen.sidecar.build import sidecar
from tfra.hdl.bus.map import BITS, Field, Kind, Register, RegisterMap
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import interval, skin_interval
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.choices import KINDS
from tfra.model.estimators import ESTIMATORS
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import repair_places
from tfra.model.skin.skin import Skin, core_of
from tfra.runtime.errors import InputError, require

if TYPE_CHECKING:
    from systemrdl.node import AddrmapNode, FieldNode, RegNode

SOURCE = Path(__file__).with_name("tfra.rdl")

_KINDS: Mapping[tuple[str, str, frozenset[str]], Kind] = {
    ("r", "na", frozenset()): Kind.CONSTANT,
    ("r", "w", frozenset()): Kind.STATUS,
    ("rw", "r", frozenset()): Kind.SETTING,
    ("w", "r", frozenset({"singlepulse"})): Kind.PULSE,
    ("w", "r", frozenset({"swmod"})): Kind.PORT,
    ("rw", "na", frozenset({"onwrite=woclr", "hwset", "precedence=hw"})): Kind.EVENT,
    ("r", "na", frozenset({"counter"})): Kind.COUNTER,
    ("r", "w", frozenset({"we"})): Kind.CAPTURED,
}
"""Kinds by access of software and of hardware, and by the other properties that decide what the field does."""

_ELSEWHERE = frozenset({"name", "desc", "encode", "sw", "hw", "reset", "hwclr", "intr", "enable"})
"""Properties that a kind does not depend on, or that are read elsewhere."""


def compiled(parameters: Mapping[str, int], source: Path = SOURCE) -> AddrmapNode:
    """The address map of ``source`` with values for its ``parameters``, elaborated.

    Raises ``InputError`` without the compiler, and for what it rejects.
    """
    require(source, "ip", "systemrdl-compiler")
    from systemrdl.compiler import RDLCompiler
    from systemrdl.messages import MessagePrinter, RDLCompileError

    class Collected(MessagePrinter):
        """The first complaint, instead of all of them on the terminal."""

        first = ""

        def print_message(self, severity: Any, text: str, src_ref: Any) -> None:
            self.first = self.first or text

    printer = Collected()
    compiler = RDLCompiler(message_printer=printer)
    try:
        compiler.compile_file(str(source))
        return compiler.elaborate(parameters=dict(parameters)).top
    except RDLCompileError:
        raise InputError(source, "", printer.first) from None


def as_map(top: AddrmapNode, source: Path = SOURCE) -> RegisterMap:
    """The map as plain data; raises ``InputError`` for what the gateware does not offer."""
    from systemrdl.node import RegNode

    registers = []
    for node in top.children():
        if not isinstance(node, RegNode) or node.is_array or node.get_property("regwidth") != BITS:
            raise InputError(source, node.inst_name, f"single registers of {BITS} bits are needed, nothing else")
        registers.append(_register(node, source))
    return RegisterMap(tuple(sorted(registers, key=lambda register: register.address)))


def register_map(parameters: Mapping[str, int]) -> RegisterMap:
    """The map of ``tfra.rdl`` with values for its ``parameters``; raises as :func:`compiled`."""
    return _map_of(frozenset(parameters.items()))


@lru_cache(maxsize=8)
def _map_of(parameters: frozenset[tuple[str, int]]) -> RegisterMap:
    """A package asks for its map a dozen times, and the compiler takes a while."""
    return as_map(compiled(dict(parameters)))


def _register(node: RegNode, source: Path) -> Register:
    fields = tuple(_field(field, source) for field in node.fields())
    return Register(node.inst_name, node.raw_address_offset, fields, _text(node))


def _field(node: FieldNode, source: Path) -> Field:
    kind, reset = _kind(node, source), node.get_property("reset") or 0
    if not isinstance(reset, int):
        raise InputError(source, _path(node), "its reset value is a number")
    if kind is Kind.EVENT and node.width > 1:
        raise InputError(source, _path(node), "an event has one bit")
    clear, enable = (_other(node, name, source) for name in ("hwclr", "enable"))
    return Field(node.inst_name, node.low, node.width, kind, reset, clear, enable, _text(node))


def _other(node: FieldNode, name: str, source: Path) -> str:
    """The field that the property ``name`` refers to."""
    from systemrdl.node import FieldNode

    other = node.get_property(name)
    if not other:
        return ""
    if not isinstance(other, FieldNode):
        raise InputError(source, _path(node), f"{name} is another field")
    return _path(other)


def _kind(node: FieldNode, source: Path) -> Kind:
    sw, hw = node.get_property("sw").name, node.get_property("hw").name
    names = sorted(set(node.list_properties()) - _ELSEWHERE)
    decisive = {name: value for name in names if (value := node.get_property(name))}
    found = frozenset(name if value is True else f"{name}={value.name}" for name, value in decisive.items())
    if (sw, hw, found) not in _KINDS:
        reason = f"no kind of field has sw = {sw}, hw = {hw}, {', '.join(sorted(found)) or 'and nothing else'}"
        raise InputError(source, _path(node), reason)
    return _KINDS[sw, hw, found]


def _path(node: FieldNode) -> str:
    return f"{node.parent.inst_name}.{node.inst_name}"


def _text(node: RegNode | FieldNode) -> str:
    return " ".join((node.get_property("desc") or "").split())


def parameters(array: Design | Skin) -> dict[str, int]:
    """Values for the parameters of ``tfra.rdl``; they follow from the sidecar, and are the same for the same design."""
    design, facts = core_of(array), sidecar(array)
    core = microarchitecture(design)
    between = skin_interval(SkinTiming.of(array, core)) if isinstance(array, Skin) else interval(core)
    major, minor, patch = (int(number) for number in re.findall(r"\d+", version("tfra"))[:3])
    design_hash = int(facts["configuration_sha256"][:16], 16)
    return {
        "MAJOR": major,
        "MINOR": minor,
        "PATCH": patch,
        "HASH_LOW": design_hash & 0xFFFFFFFF,
        "HASH_HIGH": design_hash >> 32,
        "ESTIMATOR": tuple(ESTIMATORS).index(design.estimator),
        "ARCHITECTURE": KINDS.index(design.architecture.kind),
        "LOADABLE": int(core.loaded is not None),
        "TAXEL_FORCES": int("forces" in design.result_fields),
        "ROWS": array.sensor.rows,
        "COLUMNS": array.sensor.columns,
        "TAXEL_BITS": design.adc.bits,
        "RESULT_BITS": facts["result"]["bits"],
        "COEFFICIENT_BITS": design.coefficient_word,
        "RESULT_LENGTH": facts["result"]["transfers_per_frame"],
        "LATENCY_CYCLES": facts["axi_latency_cycles"]["first_word"],
        "INTERVAL_CYCLES": between,
        "LOAD_LENGTH": 0 if core.loaded is None else core.loaded.size,
        "TAXELS_PER_BEAT": design.bus.taxels_per_beat,
        "REPAIR_PLACES": repair_places(array.sensor.taxels),
        **(_skin(array) if isinstance(array, Skin) else {}),
    }


def _skin(skin: Skin) -> dict[str, int]:
    """Values for the parameters of registers that only a skin has."""
    rows, columns = skin.shape
    return {
        "SKIN": 1,
        "WINDOW_ROWS": rows,
        "WINDOW_COLUMNS": columns,
        "MOST_CONTACTS": skin.choices.most,
        "CONTACT_THRESHOLD": skin.choices.word,
        "CONTACT_GAP": skin.choices.gap,
    }


def registers_of(array: Design | Skin) -> RegisterMap:
    """The register map with the values of a design; raises ``InputError`` without the compiler of SystemRDL."""
    return register_map(parameters(array))
