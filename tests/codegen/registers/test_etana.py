"""The gateware beside what PeakRDL-etana makes of the same SystemRDL: the same accesses, the same answers."""

import json
import random
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from peakrdl_etana.cpuif.axi4lite import AXI4Lite_Cpuif_flattened
from peakrdl_etana.exporter import RegblockExporter
from peakrdl_etana.udps import ALL_UDPS
from systemrdl.compiler import RDLCompiler

from tests.codegen.cocotb_run import outcome
from tests.hdl.bus.model import Access, accesses, bits
from tests.marks import long
from tfra.codegen.registers.source import SOURCE, register_map
from tfra.codegen.verilog.emit import plain_verilog, to_rtlil
from tfra.hdl.bus.map import Kind
from tfra.hdl.bus.registers import Registers

VALUES = {"ROWS": 9, "COLUMNS": 14, "HASH_HIGH": 0xDEADBEEF, "ESTIMATOR": 1, "LATENCY_CYCLES": 1234}
MAP = register_map(VALUES)
STROBES = {1 << first: 1 for first in range(4)} | {15: 4, 3: 2, 12: 2, 6: 2, 7: 3, 14: 3}
"""Strobes of adjacent bytes, and how many these are: others a byte address and a length can't state."""

ENDINGS = {
    Kind.STATUS: {"": ""},
    Kind.EVENT: {"_set": "_hwset"},
    Kind.COUNTER: {"_up": "_incr"},
    Kind.CAPTURED: {"": "", "_store": "_we"},
    Kind.SETTING: {"": ""},
    Kind.PULSE: {"": ""},
    Kind.PORT: {"": "", "_written": "_swmod"},
}
"""Endings of our ports, and of theirs, by the kind of field."""
DRIVEN = (Kind.SETTING, Kind.PULSE, Kind.PORT)
"""Kinds whose ports are outputs."""

CHANNELS = {"aw": {"addr": 8, "prot": 3}, "w": {"data": 32, "strb": 4}, "ar": {"addr": 8, "prot": 3}}
ANSWERS = {"b": {"resp": 2}, "r": {"data": 32, "resp": 2}}


@dataclass(frozen=True)
class Port:
    """A port of hardware: its name in the pair, in ours and in theirs."""

    name: str
    ours: str
    theirs: str
    bits: int
    is_output: bool
    is_pulse: bool


def ports() -> Iterator[Port]:
    for register in MAP.registers:
        for field in register.fields:
            for mine, its in ENDINGS.get(field.kind, {}).items():
                is_output, name = field.kind in DRIVEN, f"{field.name}{mine}"
                theirs = f"hwif_{'out' if is_output else 'in'}_{register.name}_{field.name}{its}".lower()
                ours, wide = f"hardware__{register.name}__{name}", 1 if mine else field.bits
                is_pulse = field.kind is Kind.PULSE or mine == "_written"
                yield Port(f"{register.name}_{name}", ours, theirs, wide, is_output, is_pulse)
    yield Port("interrupt", "interrupt", "hwif_out_interrupt_status_intr", 1, True, False)


def pair() -> str:
    """Verilog with both in it: a bus and outputs for each, inputs in common."""
    declared, instances = ["input wire clk", "input wire rst"], []
    declared += [f"input wire [{port.bits - 1}:0] {port.name}" for port in ports() if not port.is_output]
    for side, prefix in (("ours", "bus__"), ("etana", "s_axil_")):
        wired = {"clk": "clk", "rst": "rst"}
        for channel, words in (CHANNELS | ANSWERS).items():
            for word, wide in {**words, "valid": 1, "ready": 1}.items():
                flow = "input" if (channel in CHANNELS) != (word == "ready") else "output"
                wired[f"{prefix}{channel}{word}"] = f"{side}_axil_{channel}{word}"
                declared.append(f"{flow} wire [{wide - 1}:0] {side}_axil_{channel}{word}")
        for port in ports():
            wired[getattr(port, "ours" if side == "ours" else "theirs")] = f"{side}_" * port.is_output + port.name
            declared += [f"output wire [{port.bits - 1}:0] {side}_{port.name}"] if port.is_output else []
        instances.append(f"{side} {side} (" + ", ".join(f".{port}({name})" for port, name in wired.items()) + ");")
    return "module pair(\n" + ",\n".join(declared) + ");\n" + "\n".join(instances) + "\nendmodule\n"


def etana(folder: Path, source: Path) -> None:
    """Write ``etana.sv``: errors for bad addresses and for bad accesses, as the gateware answers them."""
    compiler = RDLCompiler()
    for udp in ALL_UDPS:
        compiler.register_udp(udp, soft=False)
    compiler.compile_file(str(source))
    options = {"cpuif_cls": AXI4Lite_Cpuif_flattened, "err_if_bad_addr": True, "err_if_bad_rw": True}
    RegblockExporter().export(compiler.elaborate(parameters=VALUES), str(folder), module_name="etana", **options)


def told(script: Iterable[Access]) -> list[list[Any]]:
    """Accesses as the testbench takes them."""
    kinds = {f"{r.name}.{f.name}": f.kind for r in MAP.registers for f in r.fields}
    found: list[list[Any]] = []
    for action, place, *values in script:
        if action == "read":
            found.append(["read", place & ~3])
        elif action == "write":
            strobe = values[1] if values[1] in STROBES else 15
            first = (strobe & -strobe).bit_length() - 1
            word = list(values[0].to_bytes(4, "little"))[first : first + STROBES[strobe]]
            found.append(["write", (place & ~3) + first, word])
        else:
            name, endings = place.replace(".", "_"), ENDINGS[kinds[place]]
            strobes = [f"{name}{ending}" for ending in endings if ending]
            found.append(["happen", {name: values[0]} if "" in endings else {}, "".join(strobes)])
    return found


def side_by_side(simulator: str, folder: Path, script: Iterable[Access], source: Path = SOURCE) -> dict[str, Any]:
    """Play ``script`` on both, theirs being made of ``source``; the outcome."""
    (folder / "ours.v").write_text(plain_verilog(to_rtlil(Registers(MAP), "ours"), "ours"))
    etana(folder, source)
    (folder / "pair.v").write_text(pair())
    names = {"inputs": [port.name for port in ports() if not port.is_output]}
    names |= {"outputs": [port.name for port in ports() if port.is_output and not port.is_pulse]}
    names |= {"pulses": [port.name for port in ports() if port.is_pulse]}
    (folder / "script.json").write_text(json.dumps({"accesses": told(script), **names}))
    sources = ("pair.v", "ours.v", "etana.sv")
    result: dict[str, Any] = outcome("tests.codegen.registers.pair", simulator, folder, "pair", *sources)
    return result


@pytest.mark.parametrize("simulator", ["icarus", *long("verilator")])
def test_random_accesses(tmp_path: Path, simulator: str) -> None:
    number = 300 if simulator == "icarus" else 2000
    result = side_by_side(simulator, tmp_path, accesses(MAP, random.Random(1), number))
    assert result["differ"] == []
    assert result["compared"] > number
    assert all(ours > 0 for ours, _ in result["pulses"].values()), result["pulses"]


@pytest.mark.long
@pytest.mark.parametrize("simulator", ["icarus", "verilator"])
def test_every_bit(tmp_path: Path, simulator: str) -> None:
    result = side_by_side(simulator, tmp_path, bits(MAP))
    assert result["differ"] == []


@pytest.mark.long
@pytest.mark.parametrize(
    ("stated", "other", "seen"),
    [
        ("setting_f taxel_forces[1] = 1;", "setting_f taxel_forces[1] = 0;", "CONTROL_taxel_forces"),
        ("FRAMES_OUT.count->hwclr = CONTROL.clear_counters;", "", "answer"),
        ("field port_f { sw = w;", "field port_f { sw = rw;", "answer"),
    ],
)
def test_a_planted_difference_is_noticed(tmp_path: Path, stated: str, other: str, seen: str) -> None:
    text = SOURCE.read_text()
    assert text.count(stated) == 1
    source = tmp_path / "other.rdl"
    source.write_text(text.replace(stated, other))
    script = [("happen", "FRAMES_OUT.count", 1), ("write", 0x40, 4, 15), ("read", 0x64), ("read", 0x80)]
    result = side_by_side("icarus", tmp_path, script, source)
    assert {name for _, name, *_ in result["differ"]} == {seen}
