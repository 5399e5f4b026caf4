"""What PeakRDL-etana makes of the same SystemRDL, against the model of the map that the gateware is compared with.

cocotb runs :func:`play` in a Verilog simulator: it takes the accesses of ``script.json`` and writes ``outcome.json``,
how many values were compared, and those that differ.
"""

import itertools
import json
import random
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.axi import AxiLiteBus, AxiLiteMaster
from peakrdl_etana.cpuif.axi4lite import AXI4Lite_Cpuif_flattened
from peakrdl_etana.exporter import RegblockExporter
from peakrdl_etana.udps import ALL_UDPS
from systemrdl.compiler import RDLCompiler

from tests.codegen.cocotb_run import outcome
from tests.hdl.bus.model import Access, Model, accesses, bits
from tfra.codegen.registers.source import SOURCE, register_map
from tfra.hdl.bus.map import Kind

VALUES = {"ROWS": 9, "COLUMNS": 14, "HASH_HIGH": 0xDEADBEEF, "ESTIMATOR": 1, "LATENCY_CYCLES": 1234}
MAP = register_map(VALUES)

INPUTS = {Kind.STATUS: "", Kind.CAPTURED: ""}
STROBES = {Kind.EVENT: "_hwset", Kind.COUNTER: "_incr", Kind.CAPTURED: "_we"}
PULSES = {Kind.PULSE: "", Kind.PORT: "_swmod"}
"""Endings of the names of ports by the kind of field: inputs with a value, inputs for one cycle, outputs for one."""


def port(dut: Any, path: str, ending: str, flow: str = "in") -> Any:
    """The port of the field ``path``, ``REGISTER.field``."""
    return dut[f"hwif_{flow}_{path.replace('.', '_')}{ending}".lower()]


@cocotb.test()
async def play(dut: Any) -> None:
    """Every access on both; answers and outputs after it, and the pulses at the end."""
    model, pulses = Model(MAP), dict.fromkeys(Model(MAP).pulses, 0)
    manager, kinds = await begun(dut), {path: field.kind for path, field in model.fields.items()}
    for path in pulses:
        cocotb.start_soon(count(dut, port(dut, path, PULSES[kinds[path]], "out"), pulses, path))
    compared, differ = 0, []
    for action, place, *values in json.loads(Path("script.json").read_text()):
        states: dict[str, tuple[Any, Any]] = {}
        if action == "happen":
            model.happen(place, *values)
            await happen(dut, place, kinds[place], *values)
        elif action == "read":
            answer = await manager.read(place & ~3, 4)
            found = int.from_bytes(answer.data, "little"), int(answer.resp)
            states["answer"] = model.read(place), found
        else:
            word, first, number = values[0], *stated(values[1])
            expected = model.write(place, word, (1 << number) - 1 << first)
            written = await manager.write((place & ~3) + first, word.to_bytes(4, "little")[first : first + number])
            states["answer"] = expected, int(written.resp)
        await ClockCycles(dut.clk, 4)
        for path, kind in kinds.items():
            if kind is Kind.SETTING or (kind is Kind.PORT and model.pulses[path]):
                states[path] = model.values[path], int(port(dut, path, "", "out").value)
        states["interrupt"] = model.interrupt, int(dut.hwif_out_interrupt_status_intr.value)
        compared += len(states)
        differ += [[name, action, place, *pair] for name, pair in states.items() if pair[0] != pair[1]]
    differ += [[path, "pulses", *pair] for path in pulses if (pair := (model.pulses[path], pulses[path]))[0] != pair[1]]
    Path("outcome.json").write_text(json.dumps({"compared": compared, "pulses": pulses, "differ": differ}))


async def begun(dut: Any) -> AxiLiteMaster:
    """A manager with stalls of its own on every channel, after a reset."""
    manager, rng = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.clk, dut.rst), random.Random(1)
    channels = [manager.write_if.aw_channel, manager.write_if.w_channel, manager.write_if.b_channel]
    for channel in [*channels, manager.read_if.ar_channel, manager.read_if.r_channel]:
        channel.set_pause_generator(itertools.cycle([rng.random() < 0.3 for _ in range(997)]))
    for path, field in Model(MAP).fields.items():
        for endings in (INPUTS, STROBES):
            if field.kind in endings:
                port(dut, path, endings[field.kind]).value = 0
    dut.rst.value = 1
    Clock(dut.clk, 10, unit="ns").start()
    await ClockCycles(dut.clk, 4)
    dut.rst.value = 0
    await ClockCycles(dut.clk, 2)
    return manager


async def count(dut: Any, pulse: Any, pulses: dict[str, int], path: str) -> None:
    while True:
        await RisingEdge(dut.clk)
        pulses[path] += int(pulse.value)


async def happen(dut: Any, path: str, kind: Kind, value: int) -> None:
    """Set an input, or one of a captured field and its strobe, or a strobe alone, for one cycle."""
    if kind in INPUTS:
        port(dut, path, INPUTS[kind]).value = value
    if kind in STROBES:
        port(dut, path, STROBES[kind]).value = 1
        await RisingEdge(dut.clk)
        port(dut, path, STROBES[kind]).value = 0


def stated(strobe: int) -> tuple[int, int]:
    """First byte and number of bytes of a ``strobe``; all four for one that is not of adjacent bytes."""
    first = (strobe & -strobe).bit_length() - 1
    number = strobe.bit_count()
    return (first, number) if strobe and strobe >> first == (1 << number) - 1 else (0, 4)


def etana(simulator: str, folder: Path, script: Iterable[Access], source: Path = SOURCE) -> Any:
    """Play ``script`` on what is made of ``source``, with errors for bad addresses and accesses; the outcome."""
    compiler = RDLCompiler()
    for udp in ALL_UDPS:
        compiler.register_udp(udp, soft=False)
    compiler.compile_file(str(source))
    options = {"cpuif_cls": AXI4Lite_Cpuif_flattened, "err_if_bad_addr": True, "err_if_bad_rw": True}
    RegblockExporter().export(compiler.elaborate(parameters=VALUES), str(folder), module_name="etana", **options)
    (folder / "script.json").write_text(json.dumps(list(script)))
    return outcome("tests.codegen.registers.test_etana", simulator, folder, "etana", "etana.sv")


@pytest.mark.long
def test_random_accesses(tmp_path: Path) -> None:
    result = etana("icarus", tmp_path, accesses(MAP, random.Random(1), 300))
    assert result["differ"] == []
    assert result["compared"] > 300
    assert all(result["pulses"].values()), result["pulses"]


@pytest.mark.long
def test_every_bit(tmp_path: Path) -> None:
    assert etana("verilator", tmp_path, bits(MAP))["differ"] == []


@pytest.mark.long
@pytest.mark.parametrize(
    ("stated", "other", "seen"),
    [
        ("setting_f taxel_forces[1] = 1;", "setting_f taxel_forces[1] = 0;", "CONTROL.taxel_forces"),
        ("LOAD_COUNT.words->hwclr = CONTROL.soft_reset;", "", "answer"),
        ("field port_f { sw = w;", "field port_f { sw = rw;", "answer"),
    ],
)
def test_a_planted_difference_is_noticed(tmp_path: Path, stated: str, other: str, seen: str) -> None:
    text = SOURCE.read_text()
    assert text.count(stated) == 1
    source = tmp_path / "other.rdl"
    source.write_text(text.replace(stated, other))
    script = [("happen", "LOAD_COUNT.words", 1), ("write", 0x40, 2, 15), ("read", 0x84), ("read", 0x80)]
    assert {name for name, *_ in etana("icarus", tmp_path, script, source)["differ"]} == {seen}
